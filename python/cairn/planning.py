"""Exact cost-to-go and next node of every cell or node [Maalouf06 §3].

One plan serves every start: a robot knocked off its path goes on from wherever it is, and any
number of robots share the field.

Arithmetic on grids. Bool grids: integers, a straight step is 985 and a diagonal one 1393 (or the
paper's 100 and 141), in uint32, or uint64 where a cost-to-go would not fit. Float grids: a link
between cells of costs a and b costs (a + b) * h, h = 1/2 straight and sqrt(2)/2 diagonal, and paths
are summed from the goal, one add per link, every operation rounded in the precision asked for.
The field is the least fixed point in that arithmetic, whatever `threads` is.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from cairn import _brain, errors
from cairn.arguments import (
    GridCell,
    Means,
    Simd,
    cell_array,
    checked_choice,
    checked_flag,
    checked_means,
    checked_share,
    double_precision,
    goal_cells,
    goal_points,
    single_precision,
    start_cell,
    start_point,
    two_dimensional,
    update_costs,
    world_arrays,
)

Precision = Literal["f32", "f64"]
Steps = Literal["985/1393", "100/141"]
Place = tuple[float, tuple[float, float, float]]  # resolution [m], (x, y, yaw) of the grid
Point = Sequence[float]

_CELLS = (1.0, (0.0, 0.0, 0.0))


class PlannableWorld(Protocol):
    """What `plan` reads of a world (`cairn.World` has it)."""

    @property
    def occupancy(self) -> npt.NDArray[np.uint8]:
        """(rows, cols): 0 free, 1 occupied, 2 unknown; row 0 has the lowest y."""
        ...

    @property
    def resolution_m(self) -> float:
        """Side of a cell [m]."""
        ...

    @property
    def origin(self) -> tuple[float, float, float]:
        """(x, y, yaw) of the outer corner of cell (0, 0) in the world [m, m, rad]."""
        ...

    @property
    def costs(self) -> npt.NDArray[np.floating] | None:
        """Cost per metre of each cell, inf blocked, or None."""
        ...


class Update(NamedTuple):
    """What an update of a field took.

    Attributes:
        anew: whether the field was solved anew.
        changed: cells whose cost really changed.
        forgotten: cells that were forgotten because their way became dearer; 0 if solved anew.
        visits: visits to tiles; 0 if solved anew.
    """

    anew: bool
    changed: int
    forgotten: int
    visits: int


class Field:
    """Cost-to-go and next cell of every cell of a grid; made by `plan` and `plan_grid`.

    Attributes:
        goals: the goals as given: world points [m] of `plan`, (row, col) of `plan_grid`.
        brain: the compiled field, for parts of Cairn that follow it.
    """

    def __init__(
        self,
        brain: _brain.GridField,
        scale: float,
        goal_points: list[tuple[float, float]] | None,
    ) -> None:
        """Wrap a solved field; `scale` turns cost x cells into the unit shown."""
        self.brain = brain
        self.goals: list[Any] = list(brain.goals if goal_points is None else goal_points)
        self._scale = scale
        self._goal_points = goal_points
        self._forget_arrays()

    def _forget_arrays(self) -> None:
        """Let go of arrays that show the field as it was."""
        self._native: npt.NDArray[Any] | None = None
        self._next_node: npt.NDArray[np.int8] | None = None
        self._cost_to_go: npt.NDArray[np.float64] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        return self.brain.shape

    @property
    def native(self) -> npt.NDArray[Any]:
        """The solver's own numbers, (rows, cols), read-only, not copied.

        uint32 or uint64 steps, `unit` of them to a straight step, the largest value where there is
        no way; or float32 or float64 cost x cells, inf where there is no way. An array fetched
        keeps its numbers when the field is updated.
        """
        if self._native is None:
            self._native = self.brain.native()
        return self._native

    @property
    def next_node(self) -> npt.NDArray[np.int8]:
        """The move to the next cell, int8 (rows, cols), read-only, not copied.

        (Δrow, Δcol) = 0 (0,1), 1 (1,1), 2 (1,0), 3 (1,-1), 4 (0,-1), 5 (-1,-1), 6 (-1,0), 7 (-1,1);
        the lowest code among equally good ones; -1 at goals and where there is none. An array
        fetched keeps its codes when the field is updated.
        """
        if self._next_node is None:
            self._next_node = self.brain.next_node()
        return self._next_node

    @property
    def unit(self) -> float:
        """`native` cost of one straight step through cells of unit cost: 985, 100 or 1."""
        return self.brain.unit

    @property
    def cost_to_go(self) -> npt.NDArray[np.float64]:
        """Cost of the best way from every cell, (rows, cols), float64, computed on first use.

        Unit: cost x metres for `plan` (metres on a world without costs), cost x cells for
        `plan_grid`. 0 at goals, inf where blocked or unreachable.
        """
        if self._cost_to_go is None:
            self._cost_to_go = self.brain.cost_to_go(self._scale)
            self._cost_to_go.flags.writeable = False
        return self._cost_to_go

    def path(self, start: Point, *, any_angle: bool = False) -> npt.NDArray[Any] | None:
        """Walk the pointers from `start` to a goal.

        Args:
            start: (x, y) in the world [m], anything after y ignored, for a field of `plan`;
                (row, col) for `plan_grid`.
            any_angle: leave out what is between two points of the path wherever the straight
                segment passes and costs no more. A segment may enter what the path may: no blocked
                cell, and unless corners may be cut no corner of one. It costs the integral of the
                cost along it. What is left has a cost never above that of the path (rounding
                aside, 1e-11 of it), and nothing is left out of it a second time.

        Returns:
            For `plan`: float64 (n, 2) world points [m]: `start` itself, the centres of the cells
            between, the goal point itself; no point twice. For `plan_grid`: int64 (n, 2) cells,
            both ends included. With `any_angle`: those of them where it turns. (Where corners may
            be cut, the centre of the first or last cell is among them if the way from `start` or
            to the goal would clip a blocked cell without.) None from anywhere that cannot reach a
            goal.

        Raises:
            StartOutsideMap: `start` is not on the map (or NaN).
            StartOutsideGrid: the cell `start` is not in the grid.
            StartMalformed, CellNotWhole: `start` is no pair of (whole) numbers.
            UnknownPlanOption: `any_angle` is neither yes nor no.
            AnyAngleNotPriced: the field was not solved on costs of cells (`plan_terrain`,
                `plan_weights`), so that only its own moves have a cost.
        """
        straightened = checked_flag("any_angle", any_angle)
        if straightened and not self.brain.prices_segments:
            raise errors.AnyAngleNotPriced(
                "this field prices moves between cells, not the ground between them: it has "
                "no cost for a segment at any angle; take the path without any_angle"
            )
        if self._goal_points is not None:
            point = start_point(start)
            if straightened:
                return self.brain.any_angle_path_in_world(point, self._goal_points)
            return self.brain.path_in_world(point, self._goal_points)
        cell = start_cell(start)
        return self.brain.any_angle_path(cell) if straightened else self.brain.path(cell)

    def update(self, cells: npt.ArrayLike, costs: npt.ArrayLike, *, give_up: float = 0.1) -> Update:
        """Change the costs of some cells and make the field right again, policy included.

        The field then equals the one planned anew, to the bit. A local change takes some tenths of
        a millisecond on a grid of any size, if no array of the field is held: arrays fetched
        before are snapshots, and while one is held the first update copies the field.

        Args:
            cells: (n, 2) of (row, col), or one cell. Of a cell given twice the last cost counts.
            costs: (n,), or one for all cells, in the kind that was planned on: bool, True is free;
                or cost per unit length, > 0, inf blocked (for these, bool stands for 1 and inf).
            give_up: share of the work of the last full solution, counted, not clocked, after which
                repair gives way to solving anew.

        Returns:
            What it took.

        Raises:
            CellsMalformed: `cells` is no array of pairs of whole numbers.
            UpdateCostsMalformed: `costs` are no bools or real numbers.
            UpdateLengthMismatch: there are not as many costs as cells.
            CellOutsideGrid, GoalBlocked: as named.
            CellCostNan, CellCostNegative, CellCostZero, CellCostBeyondPrecision: with the value.
            LinkCostAbsorbed, CostToGoOverflow: as in `plan_grid`.
            FieldNotUpdatable: the field was planned for one start only, on costs of another kind,
                or by `plan_terrain` or `plan_weights`.
            UnknownPlanOption: `give_up` is no number >= 0.

            The field is as it was then.
        """
        where = cell_array(cells)
        share = checked_share("give_up", give_up)
        new = update_costs(costs, len(where), self.native.dtype)
        self._forget_arrays()
        return Update(*self.brain.update(where, new, share))

    def __repr__(self) -> str:
        """Shape, number type and goals."""
        rows, cols = self.shape
        return f"Field({rows} x {cols} cells, {self.native.dtype}, goals={self.goals})"


def plan(
    world: PlannableWorld,
    goal: Point | Sequence[Point],
    *,
    corner_cutting: bool = False,
    precision: Precision | None = None,
    unknown: Literal["blocked", "free"] = "blocked",
    start: Point | None = None,
    threads: int | None = None,
    simd: Simd | None = None,
) -> Field:
    """Plan from everywhere on a world's map to `goal`.

    A world with `costs` is planned on these (cost per metre, > 0, inf blocked) wherever nothing
    stands; grow obstacles by the robot beforehand. One without is planned on its free cells at unit
    cost.

    Args:
        world: occupancy, resolution, origin, and perhaps costs.
        goal: (x, y) in the world [m], anything after y ignored, or a sequence of such points.
        corner_cutting: let a diagonal move pass between blocked cells; if not, the two cells
            beside it must be free.
        precision: "f32" (default) or "f64", for costs; given for a world without costs, its cells
            cost 1.0 in that precision instead of integer steps.
        unknown: whether cells never seen may be entered; for a world without costs.
        start: the one point of the world [m] whose way is wanted: what is farther from the goals
            than it is left out of the field, as if it had no way, which saves the work on it.
        threads: most threads to use; the result does not depend on it.
        simd: instructions to use: "avx512", "avx2" or "portable"; the result does not depend on it.

    Returns:
        The field; its unit is cost x metres, its paths are in the world frame.

    Raises:
        GoalOutsideMap: a goal is not on the map (or NaN).
        GoalBlocked: a goal lies in a cell that cannot be entered.
        GoalMalformed: a goal is no pair of numbers.
        StartOutsideMap, StartMalformed: `start` is not on the map.
        WorldNotPlannable: `world` has no occupancy, resolution or origin.
        WorldShapeInvalid, WorldValueOutOfRange: one of these is not usable.
        CairnError: whatever `plan_grid` refuses.
    """
    checked_choice("unknown", unknown, ("blocked", "free"))
    points = goal_points(goal)
    occupancy, costs, place = world_arrays(world)
    if costs is None:
        free = (occupancy == 0) | (occupancy == 2) if unknown == "free" else occupancy == 0
        grid: npt.NDArray[Any] = free
    else:
        grid = _blocked(costs, occupancy == 1)
    rows, cols = grid.shape
    cells = _brain.goal_cells(points, rows, cols, place) if grid.size else []
    cell = None if start is None else _brain.start_cell(start_point(start), rows, cols, place)
    means = checked_means(threads, simd, cell)
    brain = _solve(grid, cells, place, corner_cutting, precision, "985/1393", means)
    return Field(brain, place[0], points)


def plan_grid(
    costs: npt.ArrayLike,
    goal: GridCell | Sequence[GridCell],
    *,
    corner_cutting: bool = False,
    precision: Precision | None = None,
    steps: Steps = "985/1393",
    start: GridCell | None = None,
    threads: int | None = None,
    simd: Simd | None = None,
) -> Field:
    """Plan from every cell of an array to `goal`.

    Args:
        costs: (rows, cols). Bool: True is free, at unit cost. Any other real type: cost per unit
            length, > 0, inf blocked; a link costs its length x the mean of its two cells.
        goal: (row, col), or a sequence of them.
        corner_cutting: let a diagonal move pass between blocked cells; if not, the two cells
            beside it must be free.
        precision: "f32" (default for costs) or "f64"; given for a bool array, free cells cost 1.0
            in that precision instead of integer steps.
        steps: integer steps on a bool array: 985 and 1393 (sqrt 2 within 2.6e-7), or the paper's
            100 and 141.
        start: the one cell whose way is wanted: what is farther from the goals than it is left
            out of the field, as if it had no way, which saves the work on it.
        threads: most threads to use; the result does not depend on it.
        simd: instructions to use: "avx512", "avx2" or "portable"; the result does not depend on it.

    Returns:
        The field, in cost x cells; its paths are cells.

    Raises:
        GridNotPlannable: not two-dimensional, not of a real number type, ragged, or with masked
            cells.
        GoalMalformed, CellNotWhole: a goal is no pair of whole numbers.
        EmptyGrid, NoGoal, GoalOutsideGrid, GoalBlocked, NoThreads: as named.
        CellCostNan, CellCostNegative, CellCostZero, CellCostBeyondPrecision: with row, col, value.
        LinkCostAbsorbed: costs differ so much in size that a link vanishes in the sum.
        CostToGoOverflow: a cost-to-go is larger than the precision can hold.
        UnknownPlanOption: an option is none of what it may be.
        StartOutsideGrid, StartMalformed: `start` is no cell of the grid.
        SimdNotAvailable: this processor does not have the instructions asked for.
    """
    cells = goal_cells(goal)
    means = checked_means(threads, simd, None if start is None else start_cell(start))
    grid = two_dimensional(costs)
    brain = _solve(grid, cells, _CELLS, corner_cutting, precision, steps, means)
    return Field(brain, 1.0, None)


def release_memory() -> None:
    """Give the memory that plans leave for the next plan back to the system.

    Fresh memory takes the system as long to provide as the solver takes to fill it, so the
    workspace of the last plan is kept, and the arrays of a field that is gone: up to three times
    the size of its arrays.
    """
    _brain.release_memory()


def _solve(
    grid: npt.NDArray[Any],
    cells: list[GridCell],
    place: tuple[float, tuple[float, float, float]],
    corner_cutting: bool,
    precision: str | None,
    steps: str,
    means: Means,
) -> _brain.GridField:
    checked_choice("precision", precision, (None, "f32", "f64"))
    checked_choice("steps", steps, ("985/1393", "100/141"))
    corner_cutting = checked_flag("corner_cutting", corner_cutting)
    if grid.dtype == bool and precision is None:
        return _brain.plan_free(grid, cells, place, corner_cutting, steps == "100/141", means)
    costs = np.where(grid, 1.0, np.inf) if grid.dtype == bool else grid
    if precision == "f64":
        return _brain.plan_costs_f64(double_precision(costs), cells, place, corner_cutting, means)
    return _brain.plan_costs_f32(single_precision(costs), cells, place, corner_cutting, means)


def _blocked(costs: npt.NDArray[Any], stands: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    if not stands.any():
        return costs
    if costs.dtype == bool:
        return costs & ~stands
    priced = np.where(stands, np.inf, costs)
    return priced.astype(costs.dtype) if costs.dtype.kind == "f" else priced
