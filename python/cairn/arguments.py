"""What planners are given: returned in the form that they need, or refused by name."""

import operator
from collections.abc import Sized
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from cairn import errors

GridCell = tuple[int, int]
Place = tuple[float, tuple[float, float, float]]
"""(resolution [m], (x, y, yaw)) of a grid in the world."""

Means = tuple[int | None, str | None, GridCell | None]
"""(most threads, instructions, start), each None for the solver's choice."""
Simd = Literal["avx512", "avx2", "portable"]

_MOST_THREADS = 2**31 - 1


# ---- arrays --------------------------------------------------------------------------------------


def two_dimensional(grid: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return a grid of bool or real numbers as an array, not copied if it is one.

    Raises:
        GridNotPlannable: not two-dimensional, ragged, masked, or of another type.
    """
    if isinstance(grid, np.ma.MaskedArray) and np.ma.is_masked(grid):
        raise _not_plannable(
            grid, "with masked cells; say what these cost, such as costs.filled(np.inf) for blocked"
        )
    try:
        array = np.asarray(grid)
    except (TypeError, ValueError):  # rows that differ in length, or what is no array at all
        rows = len(grid) if isinstance(grid, Sized) else ()
        ragged = np.empty(rows, object)
        raise _not_plannable(ragged, "with rows that differ in length") from None
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise _not_plannable(array, "; give a two-dimensional array of bool or real numbers")
    return array


def _not_plannable(grid: npt.NDArray[Any], reason: str) -> errors.GridNotPlannable:
    between = "" if reason.startswith(";") else " "
    return errors.GridNotPlannable(
        f"a grid of shape {grid.shape} and type {grid.dtype}{between}{reason}",
        shape=grid.shape,
        dtype=str(grid.dtype),
    )


def single_precision(costs: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Round to float32; what would silently become zero or infinite is refused."""
    return _rounded(costs, np.float32, 'beyond single precision; ask for precision="f64"')


def double_precision(costs: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Round to float64, as `single_precision` does to float32."""
    return _rounded(costs, np.float64, "beyond double precision; scale the costs")


def _rounded(costs: npt.NDArray[Any], wanted: Any, complaint: str) -> npt.NDArray[Any]:
    with np.errstate(over="ignore", under="ignore"):
        rounded = costs.astype(wanted, copy=False)
    if np.can_cast(costs.dtype, wanted):
        return rounded
    lost = (np.isinf(rounded) & ~np.isinf(costs)) | ((rounded == 0) & (costs != 0))
    if lost.any():
        where = tuple(int(i) for i in np.argwhere(lost)[0])
        which = f"of cell {where}" if len(where) == 2 else f"number {where[0]}"
        raise errors.CellCostBeyondPrecision(
            f"the cost {which} is {costs[where]!s}, {complaint}",
            row=where[0],
            col=where[-1],
            value=float(costs[where]),
        )
    return rounded


def world_arrays(
    world: Any,
) -> tuple[npt.NDArray[Any], npt.NDArray[Any] | None, Place]:
    """Return occupancy, costs or None, and place of what stands for a world.

    Raises:
        WorldNotPlannable: it lacks occupancy, resolution or origin.
        WorldShapeInvalid: costs are not of the shape of the occupancy.
        WorldValueOutOfRange: the resolution or the origin is not usable.
        GridNotPlannable: occupancy or costs are no grid.
    """
    for attribute in ("occupancy", "resolution_m", "origin"):
        if not hasattr(world, attribute):
            raise errors.WorldNotPlannable(
                f"{type(world).__name__} has no `{attribute}`; give a cairn.World, or use "
                "cairn.plan_grid for an array",
                kind=type(world).__name__,
                attribute=attribute,
            )
    occupancy = two_dimensional(world.occupancy)
    costs = getattr(world, "costs", None)
    if costs is not None:
        costs = two_dimensional(costs)
        if costs.shape != occupancy.shape:
            raise errors.WorldShapeInvalid(
                f"costs have shape {costs.shape}, but the occupancy {occupancy.shape}",
                what="costs",
                shape=costs.shape,
            )
    (resolution_m,) = _finite("resolution_m", world.resolution_m, 1)
    if resolution_m <= 0.0:
        raise _not_usable("resolution_m", world.resolution_m, "give metres > 0")
    x, y, yaw = _finite("origin", world.origin, 3)
    return occupancy, costs, (resolution_m, (x, y, yaw))


def _finite(key: str, value: Any, count: int) -> list[float]:
    try:
        numbers = [float(each) for each in (value if count > 1 else (value,))]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        many = "a finite number" if count == 1 else f"{count} finite numbers"
        raise _not_usable(key, value, f"give {many}")
    return numbers


def _not_usable(key: str, value: Any, rule: str) -> errors.WorldValueOutOfRange:
    return errors.WorldValueOutOfRange(f"{key} is {value!r}; {rule}", key=key, value=value)


# ---- options -------------------------------------------------------------------------------------


def checked_choice(option: str, value: Any, choices: tuple[str | None, ...]) -> None:
    """Refuse an option value that is none of its choices."""
    if not (value is None or isinstance(value, str)) or value not in choices:
        raise _unknown_option(option, value, choices)


def checked_flag(option: str, value: Any) -> bool:
    """Return a yes or no as a bool; a number or a word is neither."""
    if not isinstance(value, bool | np.bool_):
        raise _unknown_option(option, value, (False, True))
    return bool(value)


def checked_threads(threads: Any) -> int | None:
    """Return the most threads to use, or None for the solver's choice.

    Raises:
        NoThreads: it is zero (refused by the brain).
        UnknownPlanOption: it is no whole number, or less than zero.
    """
    if threads is None:
        return None
    try:
        most = -1 if isinstance(threads, bool | np.bool_) else operator.index(threads)
    except TypeError:
        most = -1
    if most < 0:
        raise _unknown_option("threads", threads, (None, "a whole number >= 1"))
    return min(most, _MOST_THREADS)


def checked_means(threads: Any, simd: Any, start: GridCell | None) -> Means:
    """Return what a planner is to work with, and the one start wanted.

    Raises:
        NoThreads, UnknownPlanOption: as `checked_threads`, `checked_choice`.
    """
    checked_choice("simd", simd, (None, "avx512", "avx2", "portable"))
    return checked_threads(threads), simd, start


def checked_share(option: str, value: Any) -> float:
    """Return a number >= 0."""
    try:
        share = float(value)
    except (TypeError, ValueError):
        share = -1.0
    if isinstance(value, bool | np.bool_) or not share >= 0.0:
        raise _unknown_option(option, value, ("a number >= 0",))
    return share


def _unknown_option(option: str, value: Any, choices: tuple[Any, ...]) -> errors.UnknownPlanOption:
    listed = ", ".join(map(repr, choices))
    return errors.UnknownPlanOption(
        f"{option}={value!r}; give one of {listed}", option=option, value=value, choices=choices
    )


# ---- cells, nodes and points ---------------------------------------------------------------------


def whole_number(value: Any) -> int:
    """Return `value` as an int of 64 bits; a fraction is an error, not a cell."""
    try:
        whole = int(value)
        if whole == value and abs(whole) < 2**63:
            return whole
    except (TypeError, ValueError, OverflowError):
        pass
    raise errors.CellNotWhole(f"{value!r} is not a row, column or node number", value=value)


def goal_cells(goal: Any) -> list[GridCell]:
    """One cell or several as a list of (row, col)."""
    goals = _several(goal)
    if any(len(place) != 2 for place in goals):
        raise errors.GoalMalformed(f"goal {goal!r}: a cell is (row, col)", value=goal)
    return [(whole_number(row), whole_number(col)) for row, col in goals]


def goal_points(goal: Any) -> list[tuple[float, float]]:
    """One point or several as a list of (x, y) [m]; what follows y is left out."""
    try:
        return [(float(place[0]), float(place[1])) for place in _several(goal)]
    except (TypeError, ValueError):
        raise errors.GoalMalformed(
            f"goal {goal!r}: a point is (x, y) in metres", value=goal
        ) from None


def start_cell(start: Any) -> GridCell:
    """Return a start (row, col)."""
    try:
        row, col = start
    except (TypeError, ValueError):
        raise errors.StartMalformed(f"start {start!r}: a cell is (row, col)", value=start) from None
    return whole_number(row), whole_number(col)


def start_point(start: Any) -> tuple[float, float]:
    """Return a start (x, y) [m]; what follows y is left out."""
    try:
        x, y, *_ = start
        return float(x), float(y)
    except (TypeError, ValueError):
        raise errors.StartMalformed(f"start {start!r} is no pair of numbers", value=start) from None


def _several(goal: Any) -> list[Any]:
    """One place or a sequence of places as a list of places, each with two numbers at least."""
    try:
        goals = list(goal)
        if goals and np.ndim(goals[0]) == 0:
            goals = [goals]
        if not isinstance(goal, str | bytes) and all(len(place) >= 2 for place in goals):
            return goals
    except (TypeError, ValueError):
        pass
    raise errors.GoalMalformed(
        f"goal {goal!r} is neither a pair of numbers nor a sequence of such", value=goal
    )


# ---- updates -------------------------------------------------------------------------------------


def cell_array(cells: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """One cell or several as an array (n, 2) of (row, col)."""
    try:
        array = np.asarray(cells)
        if array.size == 0:
            return np.zeros((0, 2), np.int64)
        whole = array.astype(np.int64)
        pairs = whole.reshape(1, 2) if whole.shape == (2,) else whole
        is_pairs = array.dtype.kind in "iuf" and pairs.ndim == 2 and pairs.shape[1] == 2
        if is_pairs and np.array_equal(whole, array):
            return pairs
    except (TypeError, ValueError, OverflowError):
        pass
    raise errors.CellsMalformed(
        f"cells {cells!r:.80}: give (n, 2) whole numbers, a row and a column each", value=cells
    )


def update_costs(
    costs: npt.ArrayLike, count: int, planned_on: np.dtype[Any]
) -> npt.NDArray[np.bool_] | npt.NDArray[np.float32] | npt.NDArray[np.float64]:
    """Return new costs of `count` cells as an array of the kind that a field was planned on."""
    try:
        array = np.asarray(costs)
        if array.ndim == 0:
            array = np.full(count, array)
    except ValueError:
        array = np.empty(0, object)
    if array.ndim != 1 or array.dtype.kind not in "biuf":
        raise errors.UpdateCostsMalformed(
            f"costs of shape {array.shape} and type {array.dtype}; give one bool or real number "
            "for each cell, or one for all",
            shape=array.shape,
            dtype=str(array.dtype),
        )
    if planned_on.kind != "f":
        return np.ascontiguousarray(array if array.dtype == bool else array.astype(np.float64))
    if array.dtype == bool:
        array = np.where(array, 1.0, np.inf)
    if planned_on == np.float32:
        return np.ascontiguousarray(single_precision(array))
    return np.ascontiguousarray(double_precision(array))
