"""Published maps and lengths [Sturtevant12], from a folder of whoever runs this.

For every `.map` the whole field is timed, to the goal of the last (longest) query or one in the
middle. For every query of its `.scen` file a field is solved and the path's straight and diagonal
steps are counted; the published length must be straight + diagonal √2. Corners are not cut, as
there.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import cairn
from cairn import _brain, maps
from cairn.experiments.bench_plan import choose_goal, geometric_mean

TOLERANCE = 0.00501
"""Some files give lengths with two decimals only [cells]."""

SOLVERS = ("cairn", "dial")


@dataclass
class MapResult:
    """What came of one map.

    Attributes:
        seconds: runs of each of `SOLVERS` for a whole field.
        queries: published lengths looked at.
        met: those that were reproduced.
        worst: largest difference from a published length [cells].
        first_wrong: a sentence about the first that was not reproduced.
        query_s: all fields and paths of the queries, end to end in Python.
    """

    name: str
    shape: tuple[int, int]
    free: int
    goal: tuple[int, int]
    seconds: dict[str, list[float]]
    queries: int = 0
    met: int = 0
    worst: float = 0.0
    first_wrong: str | None = None
    query_s: float = 0.0

    def median(self, solver: str) -> float:
        """Median time of a whole field [s]."""
        return statistics.median(self.seconds[solver])

    def to_dict(self) -> dict[str, Any]:
        """Everything, and what follows from it."""
        cells = self.shape[0] * self.shape[1]
        return {
            "map": self.name,
            "shape": list(self.shape),
            "free_cells": self.free,
            "goal": list(self.goal),
            "ratio": self.median("dial") / self.median("cairn"),
            **{
                f"{solver}_ms": {
                    "median": 1e3 * self.median(solver),
                    "least": 1e3 * min(runs),
                    "most": 1e3 * max(runs),
                }
                for solver, runs in self.seconds.items()
            },
            "ns_per_cell": 1e9 * self.median("cairn") / cells,
            "queries": self.queries,
            "lengths_met": self.met,
            "worst_difference": self.worst,
            "first_wrong": self.first_wrong,
            "query_ms": 1e3 * self.query_s / self.queries if self.queries else None,
        }


def find_maps(folder: Path) -> list[Path]:
    """MovingAI maps of a folder, by name."""
    return sorted(folder.glob("*.map"))


def measure(
    paths: list[Path], repeats: int, tell: Callable[[str], None] = lambda _: None
) -> Iterator[MapResult]:
    """Time and check one map after another."""
    for path in paths:
        tell(path.stem)
        free = np.ascontiguousarray(maps.load(path).free())
        beside = path.with_name(path.name + ".scen")
        queries = maps.load_scen(beside) if beside.exists() else []
        goal = queries[-1].goal if queries else choose_goal(free)
        solvers = {
            name: _brain.TimedSolver(name, free, [(int(goal[0]), int(goal[1]))], False, 1)
            for name in SOLVERS
        }
        for solver in solvers.values():
            solver.run()
        seconds: dict[str, list[float]] = {name: [] for name in solvers}
        for _ in range(repeats):
            for name, solver in solvers.items():
                seconds[name].append(solver.run())
        rows, cols = free.shape
        result = MapResult(path.stem, (rows, cols), int(free.sum()), goal, seconds)
        begin = time.perf_counter()
        _check(free, queries, result, lambda text, name=path.stem: tell(f"{name}: {text}"))
        result.query_s = time.perf_counter() - begin
        yield result


def _check(
    free: npt.NDArray[np.bool_],
    queries: list[maps.Query],
    result: MapResult,
    tell: Callable[[str], None],
) -> None:
    by_goal: dict[tuple[int, int], list[maps.Query]] = {}
    for query in queries:
        by_goal.setdefault(query.goal, []).append(query)
    for goal, asked in by_goal.items():
        if result.queries % 100 < len(asked):
            tell(f"{result.queries} of {len(queries)} lengths")
        field = cairn.plan_grid(free, goal)
        for query in asked:
            found = octile_length(field.path(query.start))
            result.queries += 1
            off = abs(found - query.optimal_length)
            result.worst = max(result.worst, off)
            if off <= TOLERANCE:
                result.met += 1
            elif result.first_wrong is None:
                result.first_wrong = (
                    f"{result.name}: from {query.start} to {goal} {found:.8g}, "
                    f"published {query.optimal_length:.8g}"
                )


def octile_length(path: npt.NDArray[np.int64] | None) -> float:
    """Straight + diagonal √2 steps of a path of cells; inf without one."""
    if path is None:
        return math.inf
    diagonal = int((np.abs(np.diff(path, axis=0)).sum(axis=1) == 2).sum())
    return len(path) - 1 - diagonal + diagonal * math.sqrt(2)


def summary_of(results: list[MapResult]) -> dict[str, Any]:
    """Return what it comes to over all maps."""
    return {
        "maps": len(results),
        "geometric_mean_ratio": geometric_mean(
            [result.median("dial") / result.median("cairn") for result in results]
        ),
        "queries": sum(result.queries for result in results),
        "lengths_met": sum(result.met for result in results),
        "all_met": all(result.met == result.queries for result in results),
        "wrong": [result.first_wrong for result in results if result.first_wrong],
    }
