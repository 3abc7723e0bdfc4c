"""What plans are measured against one another, behind one small protocol.

`prepare` brings a map into the form that a contender takes and is not timed; `run` solves for every
cell and returns the seconds that took; `values` is the cost-to-go that came out, inf where there is
no way, in cost × cells.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, ClassVar, Protocol

import numpy as np
import numpy.typing as npt

import cairn
from cairn import _brain, terrain
from cairn.experiments.grids import Map, Terrain, as_costs

STEP = 985
F64 = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """A map to solve.

    Attributes:
        grid: bool, True free; uint8 weights, 0 blocked; or a terrain.
        goal: (row, col).
        corner_cutting: whether a diagonal may pass between blocked cells.
    """

    grid: Map
    goal: tuple[int, int]
    corner_cutting: bool

    @property
    def is_free(self) -> bool:
        """A map of free and blocked cells, without weights."""
        return not isinstance(self.grid, Terrain) and self.grid.dtype == bool

    def cells(self) -> npt.NDArray[Any]:
        """Return the map as `cairn.plan_grid` takes it; refused for a terrain."""
        if isinstance(self.grid, Terrain):
            raise Refused("knows no costs that differ there and back")
        return self.grid if self.is_free else as_costs(self.grid)


class Contender(Protocol):
    """One planner on one task."""

    arithmetic: str
    """Contenders with the same one must agree to the bit; others within `TOLERANCE`."""

    def run(self) -> float:
        """Solve, and return how long that took [s]."""
        ...

    def values(self) -> npt.NDArray[Any]:
        """Cost-to-go in native numbers of the arithmetic, or cost × cells as float64."""
        ...

    def next_node(self) -> npt.NDArray[np.int8] | None:
        """Next cells' codes, or None if it has none."""
        ...


class Refused(Exception):
    """A contender cannot take a task; the message says why."""


def _model() -> dict[str, Any]:
    """Cost model of terrains, as the brain takes it."""
    return {"kind": Terrain.MODEL, **asdict(terrain.model_of(Terrain.MODEL))}


class InRust:
    """A solver of the brain that keeps its memory from run to run."""

    def __init__(self, solver: str, task: Task, *, whole: bool = False, threads: int = 1) -> None:
        """Make it ready; `whole` takes weights in whole numbers, else in single precision."""
        goals, ground = [task.goal], task.grid
        if isinstance(ground, Terrain):
            self.arithmetic = "f32"
            self._timed = _brain.TimedSolver.terrain(
                solver,
                ground.elevation,
                ground.roughness,
                ground.cell_size_m,
                _model(),
                goals,
                task.corner_cutting,
                threads,
            )
            return
        whole = whole and not task.is_free
        self.arithmetic = "steps" if task.is_free else "whole" if whole else "f32"
        grid = ground if whole else task.cells()
        self._timed = _brain.TimedSolver(solver, grid, goals, task.corner_cutting, threads)

    def run(self) -> float:
        """Solve; timed around the solver alone."""
        return self._timed.run()

    def update(self, block: tuple[slice, slice], new: npt.NDArray[Any]) -> tuple[float, bool]:
        """Change a block of cells and repair: (how long it took [s], solved anew after all)."""
        rows, cols = (range(part.start, part.stop) for part in block)
        return self._timed.update([(row, col) for row in rows for col in cols], new)

    def values(self) -> npt.NDArray[Any]:
        """Return a copy of the native field."""
        return self._timed.native()

    def next_node(self) -> npt.NDArray[np.int8]:
        """Return a copy of the policy."""
        return self._timed.next_node()


class EndToEnd:
    """`cairn.plan_grid` or `plan_terrain` as a user calls it: nothing kept from run to run."""

    def __init__(self, task: Task) -> None:
        """Make it ready."""
        self.arithmetic = "steps" if task.is_free else "f32"
        rule = {"corner_cutting": task.corner_cutting, "threads": 1}
        ground = task.grid
        if isinstance(ground, Terrain):
            self._plan = partial(
                cairn.plan_terrain,
                ground.elevation,
                ground.cell_size_m,
                task.goal,
                ground.MODEL,
                roughness=ground.roughness,
                **rule,
            )
        else:
            self._plan = partial(cairn.plan_grid, task.cells(), task.goal, **rule)
        self._field: cairn.Field | None = None

    def run(self) -> float:
        """Plan and fetch both arrays."""
        self._field = None
        begin = time.perf_counter()
        field = self._plan()
        _ = field.native, field.next_node
        took = time.perf_counter() - begin
        self._field = field
        return took

    def values(self) -> npt.NDArray[Any]:
        """Return the native field."""
        assert self._field is not None
        return self._field.native

    def next_node(self) -> npt.NDArray[np.int8] | None:
        """Return the policy."""
        assert self._field is not None
        return self._field.next_node


class Scipy:
    """`scipy.sparse.csgraph.dijkstra`, links as those of `cairn.grid_graph`, summed in float64.

    Building the sparse matrix is not timed; `build_s` says how long it took.
    """

    def __init__(self, task: Task) -> None:
        """Build the links."""
        from scipy.sparse import csgraph, csr_array

        begin = time.perf_counter()
        if isinstance(task.grid, Terrain):
            ground, model = task.grid, _model()
            heights, rough, size = ground.elevation, ground.roughness, ground.cell_size_m
            links = heights, rough, size, model, task.corner_cutting
            indptr, indices, costs = _brain.reversed_terrain_links(*links)
        else:
            # Links are the same both ways, so distances from the goal are those to it.
            cells = task.cells()
            indptr, indices, costs = cairn.grid_graph(cells, corner_cutting=task.corner_cutting)
        nodes = len(indptr) - 1
        small = np.int32 if len(indices) < 2**31 else np.int64
        self._graph = csr_array(
            (costs.astype(np.float64), indices.astype(small), indptr.astype(small)),
            shape=(nodes, nodes),
        )
        self.build_s = time.perf_counter() - begin
        self.arithmetic = "float64"
        self._dijkstra = csgraph.dijkstra
        self._shape, self._unit = task.grid.shape, STEP if task.is_free else 1
        self._goal = task.goal[0] * self._shape[1] + task.goal[1]
        self._found: F64 | None = None

    def run(self) -> float:
        """Solve, next nodes as well."""
        begin = time.perf_counter()
        self._found, _ = self._dijkstra(
            self._graph, directed=True, indices=self._goal, return_predecessors=True
        )
        return time.perf_counter() - begin

    def values(self) -> F64:
        """Return distances in cost × cells."""
        assert self._found is not None
        return self._found.reshape(self._shape) / self._unit

    def next_node(self) -> None:
        """Return nothing: predecessors are not compared."""


def _prices(task: Task, blocked: float) -> F64:
    """Cost of each cell as float64, for peers that always cut corners."""
    if isinstance(task.grid, Terrain):
        raise Refused("knows no costs that differ there and back")
    if not task.corner_cutting:
        raise Refused("cuts corners always")
    return np.where(task.grid > 0, task.grid.astype(np.float64), blocked)


class ScikitImage:
    """`skimage.graph.MCP_Geometric`: the mean rule in float64; it always cuts corners."""

    def __init__(self, task: Task) -> None:
        """Turn the map into costs, negative where blocked."""
        from skimage.graph import MCP_Geometric  # pyright: ignore[reportMissingImports]

        cells = _prices(task, -1.0)
        self.arithmetic = "float64"
        self._costs = cells
        self._goal, self._solver = task.goal, MCP_Geometric
        self._found: F64 | None = None

    def run(self) -> float:
        """Solve on a solver made anew: one cannot be used twice."""
        begin = time.perf_counter()
        self._found, _ = self._solver(self._costs, fully_connected=True).find_costs([self._goal])
        return time.perf_counter() - begin

    def values(self) -> F64:
        """Return costs."""
        assert self._found is not None
        return np.asarray(self._found)

    def next_node(self) -> None:
        """Return nothing: its trace is not compared."""


class XarraySpatial:
    """`xrspatial.cost_distance`: the mean rule, no policy; it always cuts corners."""

    def __init__(self, task: Task) -> None:
        """Turn the map into friction, NaN where blocked; compile on a tiny one."""
        import xarray  # pyright: ignore[reportMissingImports]
        from xrspatial import cost_distance  # pyright: ignore[reportMissingImports]

        friction = _prices(task, np.nan)
        self.arithmetic = "float64"
        rows, cols = friction.shape
        place = {"y": np.arange(rows, dtype=float), "x": np.arange(cols, dtype=float)}

        def array(values: npt.NDArray[Any]) -> Any:
            return xarray.DataArray(values, dims=("y", "x"), coords=place)

        target = np.zeros(friction.shape)
        target[task.goal] = 1.0
        self._target, self._friction = array(target), array(friction)
        self._solve = cost_distance
        self._found: Any = None
        corner = {"y": slice(0, 4), "x": slice(0, 4)}
        tiny = self._target.isel(corner) * 0 + 1
        self._solve(tiny, tiny)  # compiles

    def run(self) -> float:
        """Solve."""
        begin = time.perf_counter()
        self._found = self._solve(self._target, self._friction)
        return time.perf_counter() - begin

    def values(self) -> F64:
        """Return costs."""
        found = np.asarray(self._found.values, np.float64)
        return np.where(np.isnan(found), np.inf, found)

    def next_node(self) -> None:
        """Return nothing: it has none."""


@dataclass(frozen=True)
class Peer:
    """A planner of others.

    Attributes:
        package: what to install.
        module: what to import.
        make: the contender on a task.
        guess_ns: what it may take per cell, before it was measured [ns].
        bytes_per_cell: what it may need, for a map to be left out that would not fit.
    """

    package: str
    module: str
    make: Callable[[Task], Contender]
    guess_ns: float
    bytes_per_cell: int

    EXTRA: ClassVar[str] = 'pip install "cairn-nav[bench]"'

    def missing(self) -> str | None:
        """Say why it cannot be imported, or None if it can."""
        try:
            importlib.import_module(self.module)
        except Exception as error:  # a peer may be broken in any way
            return f"{self.package} is not there ({error}): {self.EXTRA}"
        return None

    @property
    def version(self) -> str | None:
        """Version installed."""
        try:
            return importlib.metadata.version(self.package)
        except importlib.metadata.PackageNotFoundError:
            return None


PEERS: dict[str, Peer] = {
    "scipy": Peer("scipy", "scipy.sparse.csgraph", Scipy, 350.0, 500),
    "scikit-image": Peer("scikit-image", "skimage.graph", ScikitImage, 430.0, 80),
    "xarray-spatial": Peer("xarray-spatial", "xrspatial", XarraySpatial, 320.0, 120),
}

OURS: dict[str, Callable[[Task], Contender]] = {
    "cairn": lambda task: InRust("cairn", task),
    "cairn-2-threads": lambda task: InRust("cairn", task, threads=2),
    "cairn-python": EndToEnd,
    "dial": lambda task: InRust("dial", task, whole=True),
    "dial-wide": lambda task: InRust("dial-wide", task),
    "dial-f32": lambda task: InRust("dial", task),
    "heap": lambda task: InRust("heap", task),
}
"""Those of the package, in the order of a round. `dial` is what ratios refer to."""


def ours(task: Task) -> list[str]:
    """Names of our contenders that take a task."""
    if task.is_free:
        left_out = {"dial-f32"}
    elif isinstance(task.grid, Terrain):
        left_out = {"dial-wide", "dial-f32"}  # `dial` is in float32 there
    else:
        left_out = {"dial-wide"}
    return [name for name in OURS if name not in left_out]


def compare(
    name: str, one: Contender, other_name: str, other: Contender, tolerance: float
) -> tuple[str, str | None]:
    """Compare two answers: (how they were compared, what differs or None)."""
    first, second = one.values(), other.values()
    if one.arithmetic == other.arithmetic:
        codes, others = one.next_node(), other.next_node()
        same = np.array_equal(first, second)
        if codes is not None and others is not None:
            same = same and np.array_equal(codes, others)
        how = "to the bit"
        return how, None if same else f"{name} and {other_name} differ in {one.arithmetic}"
    first, second = in_cells(first, one.arithmetic), in_cells(second, other.arithmetic)
    reached = np.isfinite(first)
    how = f"within {tolerance:g}"
    if not np.array_equal(reached, np.isfinite(second)):
        return how, f"{name} and {other_name} do not reach the same cells"
    first, second = first[reached], second[reached]
    worst = float(np.max(np.abs(first - second) / np.maximum(first, 1.0), initial=0))
    off = f"{name} and {other_name} differ by {worst:.1e} of the cost, more than {tolerance:g}"
    return how, None if worst <= tolerance else off


def in_cells(values: npt.NDArray[Any], arithmetic: str) -> F64:
    """Native numbers as cost × cells in float64, inf where there is no way."""
    unit = {"steps": STEP, "whole": 2 * STEP}.get(arithmetic, 1)
    found = values.astype(np.float64) / unit
    if values.dtype.kind == "u":
        found[values == np.iinfo(values.dtype).max] = np.inf
    return found
