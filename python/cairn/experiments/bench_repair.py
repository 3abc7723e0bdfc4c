"""Fields repaired after a local change, against solving them anew.

At places drawn by the seed a block of cells is changed and changed back, one place after another:
on maps of free and blocked cells it is blocked and cleared, in mazes a hole is broken and mended,
on weights it is made as dear as any cell and as it was. Both ways are timed, in Rust, on a field
that keeps its memory. What comes out must be the field solved anew, to the bit.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cairn import _brain
from cairn.experiments.bench_plan import choose_goal
from cairn.experiments.contenders import InRust, Task
from cairn.experiments.grids import CLASSES, Terrain

CLASSES_REPAIRED = (
    "open", "random-20", "caves", "maze-4", "maze-16", "smooth-weights", "random-weights",
)  # fmt: skip
BLOCK = 20
HOLE = 6
CHECKED = 3
"""Places after whose change the field is compared with one solved anew."""

DEAREST = 255


@dataclass
class RepairResult:
    """What came of one map.

    Attributes:
        full: runs of solving anew [s].
        there, back: every change and its taking back [s].
        anew: how many of these gave up and solved anew.
        agree: whether the compared fields were equal to the bit.
    """

    name: str
    size: int
    change: str
    full: list[float]
    there: list[float] = field(default_factory=list)
    back: list[float] = field(default_factory=list)
    anew: int = 0
    agree: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Everything, and what follows from it."""
        full, both = statistics.median(self.full), self.there + self.back
        return {
            "class": self.name,
            "size": self.size,
            "change": self.change,
            "full_ms": _spread(self.full),
            "there_ms": _spread(self.there),
            "back_ms": _spread(self.back),
            "ratio": full / statistics.median(both),
            "changes": len(both),
            "solved_anew": self.anew,
            "agree": self.agree,
        }


def _spread(seconds: list[float]) -> dict[str, float]:
    return {
        "median": 1e3 * statistics.median(seconds),
        "least": 1e3 * min(seconds),
        "most": 1e3 * max(seconds),
    }


def measure(
    names: tuple[str, ...],
    sizes: tuple[int, ...],
    places: int,
    seed: int,
    tell: Callable[[str], None] = lambda _: None,
) -> Iterator[RepairResult]:
    """Change one map after another at so many places."""
    for size in sizes:
        for name in names:
            tell(f"{name} {size}²: drawing the map")
            yield _measured(name, size, places, seed, tell)


def _measured(
    name: str, size: int, places: int, seed: int, tell: Callable[[str], None]
) -> RepairResult:
    grid = CLASSES[name].draw(size, seed)
    assert not isinstance(grid, Terrain)
    task = Task(grid, choose_goal(grid, seed), False)
    cells = task.cells()
    side, new, change = _change(name, cells)
    solver = InRust("cairn", task)
    solver.run()
    result = RepairResult(name, size, change, [solver.run() for _ in range(3)])
    before = solver.values()
    rng = np.random.default_rng(seed)
    for number in range(places + 1):  # the first one pays for memory and does not count
        tell(f"{name} {size}²: place {number} of {places}")
        block = _place(rng, size, side, task.goal)
        old = cells[block].ravel()
        took, anew = solver.update(block, np.full(old.shape, new, old.dtype))
        if number in range(1, CHECKED + 1):
            changed = cells.copy()
            changed[block] = new
            result.agree &= _same(solver, changed, task)
        undone, again = solver.update(block, old)
        if number:
            result.there.append(took)
            result.back.append(undone)
            result.anew += anew + again
    result.agree &= np.array_equal(solver.values(), before)
    return result


def _change(name: str, cells: npt.NDArray[Any]) -> tuple[int, Any, str]:
    """(cells a side, what they become, what that is called) of a map's changes."""
    if name.startswith("maze"):
        return HOLE, True, f"a hole of {HOLE} × {HOLE} broken, and mended"
    if cells.dtype == bool:
        return BLOCK, False, f"a block of {BLOCK} × {BLOCK} put down, and taken away"
    return BLOCK, np.float32(DEAREST), f"{BLOCK} × {BLOCK} cells made dearest, and as before"


def _place(
    rng: np.random.Generator, size: int, side: int, goal: tuple[int, int]
) -> tuple[slice, slice]:
    """Choose a block that does not hold the goal."""
    side = min(side, size // 4)
    while True:
        row, col = (int(first) for first in rng.integers(0, size - side, 2))
        if not (row <= goal[0] < row + side and col <= goal[1] < col + side):
            return slice(row, row + side), slice(col, col + side)


def _same(solver: InRust, changed: npt.NDArray[Any], task: Task) -> bool:
    values, codes = solver.values(), solver.next_node()
    fresh = _brain.TimedSolver("cairn", changed, [task.goal], task.corner_cutting, 1)
    fresh.run()
    return np.array_equal(values, fresh.native()) and np.array_equal(codes, fresh.next_node())


def summary_of(results: list[RepairResult]) -> dict[str, Any]:
    """What it comes to over all maps."""
    changes = [each for result in results for each in result.there + result.back]
    return {
        "maps": len(results),
        "changes": len(changes),
        "median_ms": 1e3 * statistics.median(changes),
        "solved_anew": sum(result.anew for result in results),
        "agree": all(result.agree for result in results),
    }
