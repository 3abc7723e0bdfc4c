"""Planning over terrain: what a move costs depends on how far it rises, so there and back differ.

A model says what one move costs and which moves are allowed: `P3ATEnergy` [J], `P3ATTime` [s],
`Tobler` [s]. Every move is priced while planning, in float32, by the formula in the model's
docstring; constants are computed in float64 and rounded once, then every operation is rounded, none
fused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from cairn import _brain, errors
from cairn.arguments import (
    GridCell,
    Simd,
    checked_flag,
    checked_means,
    goal_cells,
    start_cell,
    two_dimensional,
    whole_number,
)
from cairn.planning import Field

_P3AT = _brain.terrain_defaults("p3at_energy")
_TOBLER = _brain.terrain_defaults("tobler")


def _as_dict(model: Any) -> dict[str, Any]:
    plain = {
        key: value.item() if isinstance(value, np.generic) else value
        for key, value in asdict(model).items()
    }
    return {"kind": model.kind, **plain}


@dataclass(frozen=True, kw_only=True)
class _Model:
    kind: ClassVar[str]
    unit: ClassVar[str]

    def __post_init__(self) -> None:
        _brain.terrain_check(_as_dict(self))


@dataclass(frozen=True, kw_only=True)
class _P3ATModel(_Model):
    mass_kg: float = _P3AT["mass_kg"]
    payload_kg: float = _P3AT["payload_kg"]
    gravity_mps2: float = _P3AT["gravity_mps2"]
    rolling_resistance: float = _P3AT["rolling_resistance"]
    roughness_resistance: float = _P3AT["roughness_resistance"]
    max_speed_mps: float = _P3AT["max_speed_mps"]
    roughness_slowdown: float = _P3AT["roughness_slowdown"]
    drive_power_w: float = _P3AT["drive_power_w"]
    max_climb_rad: float = _P3AT["max_climb_rad"]
    max_descent_rad: float = _P3AT["max_descent_rad"]
    max_roll_rad: float = _P3AT["max_roll_rad"]
    max_roughness: float = _P3AT["max_roughness"]


@dataclass(frozen=True, kw_only=True)
class P3ATTime(_P3ATModel):
    """Time that a Pioneer P3-AT takes [s].

    Over a horizontal run x (the cell size d, or d √2 for a diagonal move), a rise z (< 0 down) and
    roughness ρ, the mean of both cells, with m = `mass_kg` + `payload_kg`:

        W = m g (z + (μ + κ ρ) x)             work of the motors against gravity and ground [J]
        T = max(√(x² + z²) (1 + σ ρ) / v, W / P)                                           [s]

    Friction and gravity as in [Rowe90] and [Sun05]. The speed is the greatest one v, less on rough
    ground, and no more than the drive's power P allows: up is slower than down. In float32, with
    r = ρ_from + ρ_to and every constant rounded once:

        work = weight * z + (drag + rough_drag * r)
        time = max(sqrt(run2 + z * z) * (pace + rough_pace * r), work * per_power)
        weight = m * g             drag = m * g * μ * x        rough_drag = 0.5 * (m * g) * κ * x
        run2 = x * x               pace = 1 / v                rough_pace = 0.5 * σ / v
        per_power = 1 / P

    Turning is not priced: a cell of a field has no heading.

    Attributes:
        mass_kg: with one battery: 12, Webots' guide to the Pioneer 3-AT.
        payload_kg: what it carries; the guide allows 12 on a floor.
        gravity_mps2: g.
        rolling_resistance: μ, resistance over weight: 0.08 on medium hard soil; 0.01 on asphalt,
            0.04 on loose gravel, 0.1 to 0.2 on sand [Carvill93].
        roughness_resistance: κ; 1: every bump is climbed, and braked down behind it (ours).
        max_speed_mps: v, 0.7, datasheet.
        roughness_slowdown: σ; 5: bumps a fifth as high as long halve the speed (ours).
        drive_power_w: P, mechanical. Not published; 20 (ours) gives full speed up to a 16 % grade
            and 0.42 m/s at 35 %; climbing on, by `P3ATEnergy`'s defaults, then empties three
            batteries (259 Wh) in 3.7 h; the guide says 2 to 4 h.
        max_climb_rad, max_descent_rad: steepest way up and down: 35 %, Webots' guide; π/2: none.
        max_roll_rad: steepest slope across the way; as up, far from tipping (ours); π/2: no limit.
        max_roughness: rougher cells are blocked; inf is no limit.
    """

    kind: ClassVar[str] = "p3at_time"
    unit: ClassVar[str] = "s"


@dataclass(frozen=True, kw_only=True)
class P3ATEnergy(_P3ATModel):
    """Energy that a Pioneer P3-AT draws from its battery [J].

    With work W and time T as in `P3ATTime`:

        E = H T + max(W, 0) / η                                                            [J]

    What computer, sensors and electronics take while it lasts, and the drive's work over its
    efficiency; nothing is won back downhill. In float32:
    `hotel * time + effort * max(work, 0)`, hotel = H, effort = 1 / η.

    Attributes:
        hotel_power_w: H; not published; 30 (ours). [Mei05] found that on a Pioneer 3-DX motion
            takes less than half of all power.
        drive_efficiency: η; not published; 0.5 (ours).

    The others are those of `P3ATTime`.
    """

    kind: ClassVar[str] = "p3at_energy"
    unit: ClassVar[str] = "J"

    drive_efficiency: float = _P3AT["drive_efficiency"]
    hotel_power_w: float = _P3AT["hotel_power_w"]


@dataclass(frozen=True, kw_only=True)
class Tobler(_Model):
    """Time that a person takes on foot [s]: Tobler's hiking function [Tobler93].

    The walking speed is 6 exp(-3.5 |s + 0.05|) km/h on footpaths, s the rise over the horizontal
    run, and 3/5 of that off the path: 5.04 km/h on the level, at most 6 km/h, where the way falls
    by 5 %. A move takes its horizontal run x over that speed. In float32, z the rise:

        base * exp2(abs(z * per_rise + offset))
        base = 0.6 * x / factor (6 km/h are 0.6 s/m; factor 1, off the path 0.6)
        per_rise = 3.5 * log2(e) / x        offset = 3.5 * log2(e) * 0.05

    `exp2` is a polynomial in float32, within 2.5e-7 (relative), its argument held at 126; the whole
    is within 1e-6 up to 45°. Roughness plays no part but for its limit.

    Attributes:
        off_path: walk at 3/5 of the speed.
        max_climb_rad, max_descent_rad: steepest way up and down: π/4 (ours), 33 times slower than
            on the level; π/2: no limit.
        max_roll_rad: steepest slope across the way; π/2: no limit.
        max_roughness: rougher cells are blocked; inf is no limit.
    """

    kind: ClassVar[str] = "tobler"
    unit: ClassVar[str] = "s"

    off_path: bool = _TOBLER["off_path"]
    max_climb_rad: float = _TOBLER["max_climb_rad"]
    max_descent_rad: float = _TOBLER["max_descent_rad"]
    max_roll_rad: float = _TOBLER["max_roll_rad"]
    max_roughness: float = _TOBLER["max_roughness"]


Model = P3ATEnergy | P3ATTime | Tobler
ModelName = Literal["p3at_energy", "p3at_time", "tobler", "tobler_off_path"]

_NAMED: dict[str, Model] = {
    "p3at_energy": P3ATEnergy(),
    "p3at_time": P3ATTime(),
    "tobler": Tobler(),
    "tobler_off_path": Tobler(off_path=True),
}


def model_of(model: Model | ModelName) -> Model:
    """Return a model, or the one with that name and its default parameters.

    Raises:
        TerrainModelUnknown: neither a model nor the name of one.
    """
    if isinstance(model, P3ATEnergy | P3ATTime | Tobler):
        return model
    if isinstance(model, str) and model in _NAMED:
        return _NAMED[model]
    choices = tuple(_NAMED)
    raise errors.TerrainModelUnknown(
        f"{model!r} is no terrain model; give P3ATEnergy(...), P3ATTime(...) or Tobler(...) of "
        f"cairn.terrain, or one of {', '.join(map(repr, choices))}",
        value=model,
        choices=choices,
    )


def plan_terrain(
    elevation: npt.ArrayLike,
    cell_size: float,
    goal: GridCell | Sequence[GridCell],
    model: Model | ModelName,
    *,
    roughness: npt.ArrayLike | None = None,
    corner_cutting: bool = False,
    start: GridCell | None = None,
    threads: int | None = None,
    simd: Simd | None = None,
) -> Field:
    """Plan from every cell of an elevation grid to `goal`.

    Args:
        elevation: heights (rows, cols) [m], rounded to float32; NaN or masked: no data, blocked.
        cell_size: side of the square cells [m].
        goal: (row, col), or a sequence of them.
        model: what a move costs and which are allowed: a model of `cairn.terrain`, or the name of
            one with its defaults: "p3at_energy", "p3at_time", "tobler", "tobler_off_path".
        roughness: (rows, cols), without unit: height of bumps over their length; NaN: no data,
            blocked. Without it, `terrain.roughness` of the elevation.
        corner_cutting: let a diagonal move pass beside blocked cells.
        start: the one cell whose way is wanted: what is farther from the goals than it is left
            out of the field, as if it had no way, which saves the work on it.
        threads: most threads to use; the result does not depend on it.
        simd: instructions to use: "avx512", "avx2" or "portable"; the result does not depend on it.

    Returns:
        The field in the model's unit (`model.unit`), joules or seconds; its paths are cells, its
        `native` float32. The least fixed point of J(goal) = 0, J(n) = min over allowed moves n -> m
        of c(n, m) + J(m) [Bellman57], one rounded add per move, summed from the goal. Which moves
        are allowed: `terrain.allowed_moves`.

    Raises:
        GridNotPlannable: elevation or roughness is no two-dimensional array of numbers.
        CellSizeOutOfRange, TerrainModelUnknown: as named.
        ElevationInfinite, RoughnessShape, RoughnessOutOfRange: as named, with cell and value.
        GoalMalformed, CellNotWhole: a goal is no pair of whole numbers.
        EmptyGrid, NoGoal, GoalOutsideGrid, GoalBlocked, NoThreads: as named.
        LinkCostAbsorbed, CostToGoOverflow: costs differ too much in size for float32.
        UnknownPlanOption: an option is none of what it may be.
        StartOutsideGrid, StartMalformed: `start` is no cell of the grid.
        SimdNotAvailable: this processor does not have the instructions asked for.
    """
    brain = _brain.plan_terrain(
        _heights(elevation),
        _or_none(roughness),
        _size(cell_size),
        _as_dict(model_of(model)),
        goal_cells(goal),
        checked_flag("corner_cutting", corner_cutting),
        checked_means(threads, simd, None if start is None else start_cell(start)),
    )
    return Field(brain, 1.0, None)


def path_cost(
    elevation: npt.ArrayLike,
    cell_size: float,
    path: npt.ArrayLike,
    model: Model | ModelName,
    *,
    roughness: npt.ArrayLike | None = None,
    corner_cutting: bool = False,
) -> float:
    """Price one way over terrain as a field does: exactly `cost_to_go` for a path of the field.

    Args:
        elevation, cell_size, model, roughness, corner_cutting: as `plan_terrain`.
        path: (n, 2) cells (row, col), each a neighbour of the one before.

    Returns:
        Its cost [model.unit]; 0 for one cell, inf if a move of it is not allowed.

    Raises:
        PathMalformed, CellNotWhole, PathWithoutCells, PathOutsideGrid, PathBroken: as named.
        CairnError: whatever `plan_terrain` refuses of these, near the path.
    """
    try:
        cells = [(whole_number(row), whole_number(col)) for row, col in path]  # pyright: ignore
    except (TypeError, ValueError) as error:
        if isinstance(error, errors.CairnError):
            raise
        raise errors.PathMalformed(
            f"path {path!r} is no sequence of cells (row, col)", value=path
        ) from None
    return _brain.terrain_path_cost(
        _heights(elevation),
        _or_none(roughness),
        _size(cell_size),
        _as_dict(model_of(model)),
        cells,
        checked_flag("corner_cutting", corner_cutting),
    )


def roughness(elevation: npt.ArrayLike, cell_size: float) -> npt.NDArray[np.float32]:
    """Roughness of every cell: how far it lies off the middle of its opposite neighbours.

    For each of the four pairs of opposite neighbours (a, b) that have data (columns, main diagonal,
    rows, other diagonal), e = h - (a + b) * 0.5; the roughness is sqrt(sum of e² / number of pairs)
    over the cell size: 0 on any plane and without a pair, 0.1 where a cell of 1 m sticks out by
    10 cm, NaN where there is no data. It sees bumps of about a cell; measure finer ones otherwise,
    and give them to `plan_terrain`. One of the many measures in use; [Hoffman89] reviews them.

    Args:
        elevation: as `plan_terrain`.
        cell_size: side of the square cells [m].

    Returns:
        float32 (rows, cols), without unit.

    Raises:
        GridNotPlannable, ElevationInfinite, CellSizeOutOfRange: as `plan_terrain`.
    """
    return _brain.terrain_roughness(_heights(elevation), _size(cell_size))


def allowed_moves(
    elevation: npt.ArrayLike,
    cell_size: float,
    model: Model | ModelName,
    *,
    roughness: npt.ArrayLike | None = None,
    corner_cutting: bool = False,
) -> npt.NDArray[np.uint8]:
    """Say which moves a model allows: bit k of a cell for the move with code k out of it.

    Cells without data or too rough are blocked, their heights unused. A move n -> m over the
    horizontal run x is allowed if n and m are on the grid and not blocked, and

    - a diagonal one, unless corners may be cut: so are the two cells beside it;
    - its rise z = h(m) - h(n) is at most tan(max_climb_rad) x and at least -tan(max_descent_rad) x;
    - the slope across it is at most tan(max_roll_rad): for a straight move between the mean of the
      two cells to its left and that of those to its right, two cells apart (a side counts only with
      both its cells); for a diagonal one between the two cells beside it, √2 cells apart. With one
      side unknown, twice its difference to the middle of n and m stands in; with both, 0.

    Args:
        elevation, cell_size, model, roughness, corner_cutting: as `plan_terrain`.

    Returns:
        uint8 (rows, cols).

    Raises:
        CairnError: whatever `plan_terrain` refuses of these.
    """
    return _brain.terrain_moves(
        _heights(elevation),
        _or_none(roughness),
        _size(cell_size),
        _as_dict(model_of(model)),
        checked_flag("corner_cutting", corner_cutting),
    )


def link_cost(
    rise_m: npt.ArrayLike,
    cell_size: float,
    model: Model | ModelName,
    *,
    diagonal: bool = False,
    roughness: float = 0.0,
) -> npt.NDArray[np.float32]:
    """Price single moves, whether a limit allows them or not.

    Args:
        rise_m: h(m) - h(n) of each move n -> m [m], any shape.
        cell_size: side of the square cells [m].
        model: as `plan_terrain`.
        diagonal: whether the moves are diagonal.
        roughness: of both cells.

    Returns:
        float32 costs [model.unit], shaped as `rise_m`.

    Raises:
        CellSizeOutOfRange, TerrainModelUnknown: as named.
    """
    rises = np.asarray(rise_m, np.float32)
    costs = _brain.terrain_link_costs(
        np.ascontiguousarray(rises).ravel(),
        float(roughness),
        _size(cell_size),
        _as_dict(model_of(model)),
        checked_flag("diagonal", diagonal),
    )
    return costs.reshape(rises.shape)


# ---- what the brain is given ---------------------------------------------------------------------


def _heights(elevation: npt.ArrayLike) -> npt.NDArray[np.float32]:
    if isinstance(elevation, np.ma.MaskedArray) and elevation.dtype.kind in "iuf":
        elevation = np.ma.filled(elevation.astype(np.float64), np.nan)
    heights = two_dimensional(elevation)
    if heights.dtype == bool:
        raise errors.GridNotPlannable(
            f"a grid of shape {heights.shape} and type bool; give numbers",
            shape=heights.shape,
            dtype="bool",
        )
    with np.errstate(over="ignore"):
        return heights.astype(np.float32, copy=False)


def _or_none(roughness: npt.ArrayLike | None) -> npt.NDArray[np.float32] | None:
    return None if roughness is None else _heights(roughness)


def _size(cell_size: Any) -> float:
    try:
        return float(cell_size)
    except (TypeError, ValueError):
        raise errors.CellSizeOutOfRange(
            f"a cell size of {cell_size!r}; give metres", value=cell_size, least=1e-3, most=1e6
        ) from None
