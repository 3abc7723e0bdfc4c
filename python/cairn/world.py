"""The world as the planner sees it: what stands where, what a metre costs, and named places.

One frame, called *world* throughout (`map` in ROS): metres, x right and y up on a map. A grid lies
in it with the outer corner of cell (0, 0) at `origin`; columns run along the origin's yaw, rows to
its left. Row 0 has the lowest y when the yaw is 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypedDict, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain, errors

FREE, OCCUPIED, UNKNOWN = 0, 1, 2

Cell = tuple[int, int]
"""(row, column)."""

Place = tuple[float, float] | tuple[float, float, float]
"""(x, y) or (x, y, heading) in the world [m, rad]."""


@dataclass(frozen=True, eq=False)
class World:
    """A grid of what stands where. Checked and read-only: make a changed one with `with_boxes`.

    Args:
        occupancy: (rows, cols), 0 free, 1 occupied, 2 unknown; a bool array is True where free,
            as everywhere in Cairn. Kept as read-only uint8.
        resolution_m: side of a cell [m].
        origin: (x, y, yaw) of the outer corner of cell (0, 0) in the world [m, m, rad].
        costs: cost per metre (rows, cols), > 0, inf blocked; None: every free metre costs 1.
            Kept as read-only float32, or float64 if given so.
        name: what a person would call it.
        goals: named places in the world, (x, y) or (x, y, heading) [m, rad].

    Raises:
        WorldShapeInvalid: not two axes, no cell, or costs of another shape.
        WorldCellInvalid: a cell is none of 0, 1, 2, or a cost is NaN, zero or negative.
        WorldValueOutOfRange: the resolution or origin is not usable.
        WorldGoalInvalid: a goal is not two or three finite numbers.
    """

    occupancy: NDArray[np.uint8]
    resolution_m: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    costs: NDArray[np.floating[Any]] | None = None
    name: str = ""
    goals: Mapping[str, Place] = field(default_factory=dict)

    def __post_init__(self) -> None:
        put = lambda key, value: object.__setattr__(self, key, value)  # noqa: E731
        put("occupancy", _checked_occupancy(self.occupancy))
        put("resolution_m", _checked_number("resolution_m", self.resolution_m, least=0.0))
        put("origin", _checked_origin(self.origin))
        if self.costs is not None:
            put("costs", _checked_costs(self.costs, self.shape))
        put("goals", {str(name): _checked_goal(name, at) for name, at in self.goals.items()})

    def __reduce__(self) -> tuple[Any, ...]:
        return World, tuple(getattr(self, each.name) for each in fields(self))

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        rows, cols = self.occupancy.shape
        return rows, cols

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(least x, greatest x, least y, greatest y) of the grid's corners in the world [m]."""
        corners = self.world_from_grid(np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) * self.size_m)
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return float(x0), float(x1), float(y0), float(y1)

    @property
    def size_m(self) -> tuple[float, float]:
        """Length along the columns and along the rows [m]."""
        return self.shape[1] * self.resolution_m, self.shape[0] * self.resolution_m

    def free(self, *, unknown: bool = True) -> NDArray[np.bool_]:
        """True where nothing stands and the cost is finite; `unknown` says if unknown is free."""
        free = self.occupancy == FREE
        if unknown:
            free |= self.occupancy == UNKNOWN
        return free if self.costs is None else free & np.isfinite(self.costs)

    def world_from_grid(self, points_in_grid: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 2), from metres along columns and rows to the world [m]."""
        x, y, yaw = self.origin
        c, s = np.cos(yaw), np.sin(yaw)
        return np.asarray(points_in_grid, float) @ np.array([[c, s], [-s, c]]) + (x, y)

    def grid_from_world(self, points_in_world: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 2), from the world to metres along columns and rows [m]."""
        x, y, yaw = self.origin
        c, s = np.cos(yaw), np.sin(yaw)
        return (np.asarray(points_in_world, float) - (x, y)) @ np.array([[c, -s], [s, c]])

    def contains(self, point: ArrayLike) -> bool:
        """The world point (x, y) [m] lies on the grid; False for NaN."""
        return self._cell(point) is not None

    def cell_of(self, point: ArrayLike) -> Cell:
        """(row, col) of the cell that holds the world point (x, y) [m].

        Raises:
            PointOutsideWorld: no cell holds it.
        """
        cell = self._cell(point)
        if cell is None:
            x, y = (float(v) for v in np.asarray(point, float)[:2])
            x0, x1, y0, y1 = self.extent
            raise errors.PointOutsideWorld(
                f"({x:g}, {y:g}) m is outside {self.name or 'the world'}: "
                f"x {x0:g} to {x1:g} m, y {y0:g} to {y1:g} m",
                x=x,
                y=y,
                extent=self.extent,
            )
        return cell

    def point_of(self, cell: ArrayLike) -> NDArray[np.float64]:
        """Centres in the world [m] of cells (row, col), shape (..., 2)."""
        row_col = np.asarray(cell, float)
        return self.world_from_grid((row_col[..., ::-1] + 0.5) * self.resolution_m)

    def with_boxes(self, boxes: ArrayLike) -> "World":
        """The same world with boxes standing in it: every cell that a box touches is occupied.

        Args:
            boxes: (n, 4) or (n, 5): centre x, y and full length, width in the world [m], and
                heading of the length [rad] (0 if not given).
        """
        centres = self.point_of(np.moveaxis(np.indices(self.shape), 0, -1))
        occupancy = self.occupancy.copy()
        half = self.resolution_m / 2
        for box in np.atleast_2d(np.asarray(boxes, float)):
            x, y, length, width = box[:4]
            heading = box[4] if len(box) > 4 else 0.0
            from_box = _rotation(heading)
            in_box = np.abs((centres - (x, y)) @ from_box)
            # Separating axes: the two of the box, then the two of the cells.
            turn = self.origin[2] - heading
            reach = half * (abs(np.cos(turn)) + abs(np.sin(turn)))
            touched = (in_box <= (length / 2 + reach, width / 2 + reach)).all(axis=-1)
            in_grid = np.abs((centres - (x, y)) @ _rotation(self.origin[2]))
            c, s = abs(np.cos(turn)), abs(np.sin(turn))
            bounds = (length / 2 * c + width / 2 * s + half, length / 2 * s + width / 2 * c + half)
            touched &= (in_grid <= bounds).all(axis=-1)
            occupancy[touched] = OCCUPIED
        return replace(self, occupancy=occupancy)

    def _cell(self, point: ArrayLike) -> Cell | None:
        cells = self.grid_from_world(np.asarray(point, float)[:2]) / self.resolution_m
        if not np.isfinite(cells).all():
            return None
        col, row = (int(v) for v in np.floor(cells))
        return (row, col) if 0 <= row < self.shape[0] and 0 <= col < self.shape[1] else None


class Priced(TypedDict):
    """`{"priced": {"factor": 3.0}}`: unknown cells cost that many times as much."""

    priced: dict[str, float]


class CostmapOptions(TypedDict, total=False):
    """Options of `costmap`; the brain owns the defaults."""

    unknown: Literal["free", "blocked"] | Priced
    distance_weight: float
    time_weight: float
    safety_weight: float
    soft_margin_m: float
    near_speed_mps: float
    open_speed_mps: float


def costmap(
    world: World,
    footprint: Any,
    *,
    layers: Mapping[str, tuple[float, ArrayLike]] | None = None,
    **options: Unpack[CostmapOptions],
) -> World:
    """Price a world for one robot: the same world with `costs` per metre, inf where it would touch.

    A metre costs `distance_weight` (1, times the world's own `costs` if it has any) +
    `time_weight` (0) / speed + `safety_weight` (8) · closeness² + Σ weight · layer. Closeness falls
    from 1 at the inscribed radius of the footprint, below which a cell is blocked, to 0 at the
    circumscribed radius plus `soft_margin_m` (0.35 m); over the same stretch the speed rises from
    `near_speed_mps` (0.15) to `open_speed_mps` (0.7). Distances are exact, from the cell's centre
    to the nearest point of an occupied cell. Blocked cells of the world's own costs are kept clear
    of like walls, so give it the world as loaded, not one that was priced before.

    Args:
        world: what stands where.
        footprint: (length, width) of the robot [m], or anything with a `footprint` that has
            `length_m` and `width_m`, such as a `Profile`.
        layers: name → (weight, values ≥ 0 of shape (rows, cols)); inf blocks a cell.
        options: `unknown` "free" (default), "blocked" or {"priced": {"factor": f}}, and the
            weights, margin and speeds named above.

    Raises:
        CostmapValueOutOfRange: an option is not usable.
        LayerShapeMismatch, LayerValueInvalid: a layer is not usable.
    """
    occupancy, ground = world.occupancy, None
    if world.costs is not None:
        ground = np.asarray(world.costs, np.float32)
        occupancy = np.where(np.isinf(ground), np.uint8(OCCUPIED), occupancy)
    extra = []
    for name, (weight, values) in (layers or {}).items():
        array = np.asarray(values, np.float32)
        if array.shape != world.shape:
            raise errors.LayerShapeMismatch(
                f"costmap: layer `{name}` has shape {array.shape}, the world {world.shape}",
                layer=name,
                values=array.size,
                rows=world.shape[0],
                cols=world.shape[1],
            )
        extra.append((name, array, float(weight)))
    costs = _brain.costmap(
        occupancy, world.resolution_m, _outline(footprint), dict(options), ground, extra
    )
    return replace(world, costs=costs)


def distance_to_occupied(
    occupied: ArrayLike, resolution_m: float = 1.0, *, surface: bool = False
) -> NDArray[np.float32]:
    """Exact distance from every cell's centre to the nearest occupied cell [m].

    Args:
        occupied: bool (rows, cols).
        resolution_m: side of a cell [m].
        surface: to the nearest point of the occupied cell's square instead of its centre.

    Returns:
        float32 (rows, cols); 0 in occupied cells, inf where nothing is occupied.
    """
    return _brain.distance_to_occupied(np.asarray(occupied, bool), resolution_m, surface=surface)


def _rotation(angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def _outline(footprint: Any) -> tuple[float, float]:
    box = getattr(footprint, "footprint", footprint)
    if isinstance(box, Mapping):
        length, width = box["length_m"], box["width_m"]
    elif hasattr(box, "length_m"):
        length, width = box.length_m, box.width_m
    else:
        length, width = box
    return (
        _checked_number("footprint.length_m", length, least=0.0),
        _checked_number("footprint.width_m", width, least=0.0),
    )


def _checked_number(key: str, value: Any, least: float = -np.inf) -> float:
    number = float(value)
    if not (np.isfinite(number) and number > least):
        rule = "a finite number" + ("" if least == -np.inf else f" greater than {least:g}")
        raise errors.WorldValueOutOfRange(
            f"world: {key} is {number}, must be {rule}", key=key, value=number
        )
    return number


def _checked_origin(origin: Any) -> tuple[float, float, float]:
    if len(origin) != 3:
        raise errors.WorldValueOutOfRange(
            f"world: origin is {origin!r}, must be (x, y, yaw)", key="origin", value=origin
        )
    keys = ("origin.x", "origin.y", "origin.yaw")
    x, y, yaw = (_checked_number(key, v) for key, v in zip(keys, origin, strict=True))
    return x, y, yaw


def _checked_goal(name: str, place: Any) -> Place:
    numbers = tuple(float(v) for v in place)
    if len(numbers) not in (2, 3) or not np.isfinite(numbers).all():
        raise errors.WorldGoalInvalid(
            f"world: goal `{name}` is {place!r}, must be (x, y) or (x, y, heading), finite",
            goal=name,
            value=place,
        )
    return cast(Place, numbers)


def _checked_shape(what: str, array: NDArray[Any]) -> None:
    if array.ndim != 2 or array.size == 0:
        raise errors.WorldShapeInvalid(
            f"world: {what} has shape {array.shape}, must be (rows, cols) with a cell at least",
            what=what,
            shape=array.shape,
        )


def _checked_occupancy(cells: Any) -> NDArray[np.uint8]:
    given = np.asarray(cells)
    _checked_shape("occupancy", given)
    array = np.where(given, FREE, OCCUPIED) if given.dtype == bool else given
    bad = ~np.isin(array, (FREE, OCCUPIED, UNKNOWN))
    if bad.any():
        _refuse_cell("occupancy", array, bad, "0 free, 1 occupied or 2 unknown")
    return _frozen(array, np.uint8)


def _checked_costs(costs: Any, shape: tuple[int, int]) -> NDArray[np.floating[Any]]:
    array = np.asarray(costs)
    if array.shape != shape:
        raise errors.WorldShapeInvalid(
            f"world: costs have shape {array.shape}, occupancy {shape}",
            what="costs",
            shape=array.shape,
        )
    array = array.astype(np.float64 if array.dtype == np.float64 else np.float32)
    bad = ~(array > 0)
    if bad.any():
        _refuse_cell("costs", array, bad, "greater than 0 (inf is blocked)")
    return _frozen(array, array.dtype)


def _refuse_cell(what: str, array: NDArray[Any], bad: NDArray[np.bool_], rule: str) -> None:
    row, col = (int(v) for v in np.argwhere(bad)[0])
    raise errors.WorldCellInvalid(
        f"world: {what} is {array[row, col]} at row {row}, column {col}, must be {rule}",
        what=what,
        row=row,
        col=col,
        value=array[row, col].item(),
    )


def _frozen(array: NDArray[Any], dtype: Any) -> NDArray[Any]:
    copy = np.array(array, dtype=dtype, order="C")
    copy.setflags(write=False)
    return copy
