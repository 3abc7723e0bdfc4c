"""Planning on a grid of which every move has a cost of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from cairn import _brain, errors
from cairn.arguments import GridCell, Simd, checked_means, goal_cells, start_cell
from cairn.planning import Field


def plan_weights(
    weights: npt.ArrayLike,
    goal: GridCell | Sequence[GridCell],
    *,
    start: GridCell | None = None,
    threads: int | None = None,
    simd: Simd | None = None,
) -> Field:
    """Plan from every cell to `goal`, each move out of each cell at a cost of its own.

    Args:
        weights: (8, rows, cols): `weights[k, row, col]` is the cost of the move with code k out of
            cell (row, col), codes as in `Field.next_node`; > 0, inf for no such move. Floats are
            planned in float32. Integers are planned in uint32, with 4294967295 for no such move.
            Moves that leave the grid are not looked at, but must be valid.
        goal: (row, col), or a sequence of them.
        start: the one cell whose way is wanted: what is farther from the goals than it is left
            out of the field, as if it had no way, which saves the work on it.
        threads: most threads to use; the result does not depend on it.
        simd: instructions to use: "avx512", "avx2" or "portable"; the result does not depend on it.

    Returns:
        The field in the unit of the weights, `unit` 1: float32, or uint32 (uint64 where a
        cost-to-go would not fit). The least fixed point of J(goal) = 0, J(n) = min over moves
        n -> m of weight + J(m) [Bellman57], one rounded add per move, summed from the goal.

    Raises:
        WeightsNotPlannable: no array (8, rows, cols) of real numbers.
        WeightNan, WeightNegative, WeightZero: with row, col, code, value.
        WeightBeyondPrecision: a weight would become 0 or inf in float32, or is beyond uint32.
        GoalMalformed, CellNotWhole: a goal is no pair of whole numbers.
        EmptyGrid, NoGoal, GoalOutsideGrid, NoThreads: as named.
        LinkCostAbsorbed, CostToGoOverflow: float weights differ too much in size for float32.
        UnknownPlanOption: an option is none of what it may be.
        StartOutsideGrid, StartMalformed: `start` is no cell of the grid.
        SimdNotAvailable: this processor does not have the instructions asked for.
    """
    planes = _planes(weights)
    cells = goal_cells(goal)
    means = checked_means(threads, simd, None if start is None else start_cell(start))
    if planes.dtype == np.uint32:
        return Field(_brain.plan_weights_u32(planes, cells, means), 1.0, None)
    return Field(_brain.plan_weights_f32(planes, cells, means), 1.0, None)


def _planes(weights: npt.ArrayLike) -> npt.NDArray[Any]:
    masked = isinstance(weights, np.ma.MaskedArray) and np.ma.is_masked(weights)
    try:
        planes: npt.NDArray[Any] = np.asarray(weights)
    except (TypeError, ValueError):
        planes = np.empty((), object)
    if masked or planes.ndim != 3 or planes.shape[0] != 8 or planes.dtype.kind not in "iuf":
        raise errors.WeightsNotPlannable(
            f"weights of shape {planes.shape} and type {planes.dtype}"
            f"{', some masked' if masked else ''}; give (8, rows, cols) real numbers",
            shape=planes.shape,
            dtype=str(planes.dtype),
        )
    if planes.dtype.kind == "f":
        with np.errstate(over="ignore", under="ignore"):
            rounded = planes.astype(np.float32)
        lost = (np.isinf(rounded) & ~np.isinf(planes)) | ((rounded == 0) & (planes != 0))
    else:
        if (planes < 0).any():
            code, row, col, value = _first(planes, planes < 0)
            raise errors.WeightNegative(
                f"the weight of move {code} out of cell ({row}, {col}) is {value}, negative",
                row=row,
                col=col,
                code=code,
                value=value,
            )
        lost = planes > np.iinfo(np.uint32).max
        rounded = planes.astype(np.uint32)
    if lost.any():
        code, row, col, value = _first(planes, lost)
        raise errors.WeightBeyondPrecision(
            f"the weight of move {code} out of cell ({row}, {col}) is {value}, beyond "
            f"{rounded.dtype}; scale the weights",
            row=row,
            col=col,
            code=code,
            value=value,
        )
    return rounded


def _first(planes: npt.NDArray[Any], wrong: npt.NDArray[np.bool_]) -> tuple[int, int, int, float]:
    code, row, col = (int(i) for i in np.argwhere(wrong)[0])
    return code, row, col, float(planes[code, row, col])
