"""What is drawn, as points and colours: no browser needed.

Points are (n, 2) [m]; a mesh is vertices (v, 2) and faces (f, 3) of their numbers; segments are
(n, 2, 2). Frames are the world's unless a name says otherwise.
"""

from __future__ import annotations

import math
from typing import Any

import contourpy
import numpy as np
from numpy.typing import NDArray

from cairn.view.console.snapshot import Body, Floats, Grid, Pose

Colour = tuple[int, int, int]
Pixels = NDArray[np.uint8]
Faces = NDArray[np.int64]
Mesh = tuple[Floats, Faces]

# The palette of `cairn.view.picture`.
INK: Colour = (34, 48, 60)
PALE: Colour = (138, 151, 163)
FREE: Colour = (251, 250, 246)
OCCUPIED: Colour = (61, 74, 87)
UNKNOWN: Colour = (216, 219, 218)
TEAL: Colour = (11, 122, 117)
RED: Colour = (209, 73, 91)
BLUE: Colour = (63, 111, 181)
AMBER: Colour = (200, 134, 43)
GREEN: Colour = (76, 153, 84)

MODES: dict[str, tuple[str, Colour]] = {
    "stop": ("Stop", INK),
    "path_planning": ("Path planning", (122, 81, 149)),
    "path_tracking": ("Path tracking", TEAL),
    "obstacle_avoidance": ("Obstacle avoidance", RED),
}

_CONE_STEPS = 5
CONE_POINTS = _CONE_STEPS + 1  # of each cone of `cones`: its tip and its rim
_ARC_STEPS = 10
# Nothing of an arc beyond half a turn helps the eye.
_ARC_TURN = math.pi
_PIXELS_AT_LEAST = (
    900  # along an image's longer side: cells keep sharp edges when looked at closely
)
_FIELD_CELLS = 220  # along a field's longer side at most
_LEVELS = 40
_QUANTILE = 0.9
_ARROWS = 36  # along a field's longer side
NEAR_M = (0.5, 1.5)  # free arcs up to these are drawn as near and as middling


def mode_of(mode: str) -> tuple[str, Colour]:
    """What a person calls a mode, and its colour; also for modes added by others."""
    return MODES.get(mode, (mode.replace("_", " ").capitalize(), BLUE))


def placed(points: Floats, pose: Pose) -> Floats:
    """Points (..., 2) of a frame at `pose`, in the world."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return points @ np.array([[c, s], [-s, c]]) + pose[:2]


# ---- grids ---------------------------------------------------------------------------------------


def map_pixels(grid: Grid) -> Pixels:
    """An occupancy as a picture (rows, cols, 3), top row first; cells are blocks of pixels."""
    colours = np.array([FREE, OCCUPIED, UNKNOWN], dtype=np.uint8)
    return enlarged(colours[np.flipud(grid.values)])


def missing_pixels(world: Grid, known: Grid) -> Pixels:
    """What stands in the world (rows, cols, 4), top row first; clear where nothing does."""
    del known
    picture = np.zeros((*world.values.shape, 4), dtype=np.uint8)
    picture[np.flipud(world.values) == 1] = (*OCCUPIED, 70)
    return enlarged(picture)


def enlarged(picture: Pixels) -> Pixels:
    """Every pixel repeated, so that smoothing does not blur few large cells."""
    times = max(1, math.ceil(_PIXELS_AT_LEAST / max(picture.shape[:2])))
    return picture.repeat(times, axis=0).repeat(times, axis=1)


def size_m(grid: Grid) -> tuple[float, float]:
    """Length along the columns and along the rows."""
    rows, cols = grid.values.shape
    return cols * grid.resolution_m, rows * grid.resolution_m


def centre(grid: Grid) -> tuple[float, float]:
    """Middle of a grid."""
    x, y = placed(np.array(size_m(grid)) / 2, grid.origin)
    return float(x), float(y)


def view(grid: Grid) -> tuple[float, float, float, float]:
    """Least and greatest x, least and greatest y of what is not unknown in an occupancy."""
    rows, cols = np.nonzero(grid.values != 2)
    if len(rows) == 0:
        rows, cols = np.array([0, grid.values.shape[0]]), np.array([0, grid.values.shape[1]])
    corners = [(c, r) for r in (rows.min(), rows.max() + 1) for c in (cols.min(), cols.max() + 1)]
    points = placed(np.array(corners, float) * grid.resolution_m, grid.origin)
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return float(x0), float(x1), float(y0), float(y1)


def _thinned(costs: Grid, most: int) -> tuple[Floats, Floats, Floats]:
    """Columns, rows [m, the grid's frame] and values of a field, at most `most` cells a side."""
    every = max(1, math.ceil(max(costs.values.shape) / most))
    rows = np.arange(every // 2, costs.values.shape[0], every)
    cols = np.arange(every // 2, costs.values.shape[1], every)
    values = costs.values[np.ix_(rows, cols)].astype(float)
    return (cols + 0.5) * costs.resolution_m, (rows + 0.5) * costs.resolution_m, values


def contours(costs: Grid) -> tuple[Floats, Floats]:
    """Lines of equal cost-to-go: segments (n, 2, 2), and each one's level as a share, (n,)."""
    x, y, values = _thinned(costs, _FIELD_CELLS)
    finite = np.isfinite(values)
    if not finite.any() or min(values.shape) < 2:
        return np.empty((0, 2, 2)), np.empty(0)
    # Pockets beside walls cost far more than all the rest: they get no levels of their own.
    top = float(np.quantile(values[finite], _QUANTILE))
    if top <= 0:
        return np.empty((0, 2, 2)), np.empty(0)
    step = _round_step(top / _LEVELS)
    lines = contourpy.contour_generator(
        x, y, np.ma.masked_invalid(values), line_type=contourpy.LineType.Separate
    )
    pieces, shares = [], []
    for level in np.arange(step, 1.15 * top, step):
        for line in lines.lines(float(level)):
            points = placed(np.asarray(line, float), costs.origin)
            segments = np.stack([points[:-1], points[1:]], axis=1)
            pieces.append(segments)
            shares.append(np.full(len(segments), level / top))
    if not pieces:
        return np.empty((0, 2, 2)), np.empty(0)
    return np.concatenate(pieces), np.concatenate(shares)


def arrows(costs: Grid) -> tuple[Floats, Floats]:
    """Ways down the cost-to-go: segments (n, 2, 2) from tail to head, and share of the cost."""
    x, y, values = _thinned(costs, _FIELD_CELLS)
    finite = np.isfinite(values)
    if finite.sum() < 4 or min(values.shape) < 3:
        return np.empty((0, 2, 2)), np.empty(0)
    filled = np.where(finite, values, np.nan)
    down_y, down_x = (-each for each in np.gradient(filled, y, x))
    length = np.hypot(down_x, down_y)
    every = max(1, round(max(values.shape) / _ARROWS))
    pick = np.zeros_like(finite)
    pick[every // 2 :: every, every // 2 :: every] = True
    good = pick & np.isfinite(length) & (length > 1e-6)
    rows, cols = np.nonzero(good)
    way = np.column_stack([down_x[good], down_y[good]]) / length[good][:, None]
    reach = 0.36 * every * float(x[1] - x[0])
    middle = np.column_stack([x[cols], y[rows]])
    ends = np.stack([middle - way * reach, middle + way * reach], axis=1)
    return placed(ends, costs.origin), values[good] / max(
        float(np.quantile(values[finite], _QUANTILE)), 1e-9
    )


def in_linear_light(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Colours of points as a shader wants them that takes them for linear light."""
    share = colours.astype(float) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.round(255 * linear).astype(np.uint8)


def _round_step(step: float) -> float:
    """1, 2 or 5 times a power of ten, at least `step`."""
    power = 10.0 ** math.floor(math.log10(max(step, 1e-9)))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= step * 0.999)


def shaded(shares: Floats) -> NDArray[np.uint8]:
    """Colours (n, 3) of a field: deep blue at the goal, pale green far away."""
    near, middle, far = np.array([[23, 64, 116], [47, 141, 165], [168, 206, 165]], float)
    t = np.clip(shares, 0.0, 1.0)[:, None]
    low, high = near + (middle - near) * 2 * t, middle + (far - middle) * (2 * t - 1)
    return np.where(t < 0.5, low, high).astype(np.uint8)


# ---- the robot -----------------------------------------------------------------------------------


def outline(length_m: float, width_m: float) -> Floats:
    """Corners (4, 2) of a box in its own frame, counter-clockwise from front left."""
    half = np.array([length_m, width_m]) / 2
    return half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])


def closed(corners: Floats) -> Floats:
    """Segments (n, 2, 2) around corners (n, 2)."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def strip(points: Floats) -> Floats:
    """Segments (n - 1, 2, 2) along points (n, 2)."""
    return np.stack([points[:-1], points[1:]], axis=1)


def dashed(points: Floats, dash_m: float) -> Floats:
    """Segments of a dashed line along points (n, 2)."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    starts = np.arange(0.0, along[-1], 2 * dash_m)
    ends = np.minimum(starts + dash_m, along[-1])
    at = lambda where: np.column_stack([np.interp(where, along, axis) for axis in points.T])  # noqa: E731
    return np.stack([at(starts), at(ends)], axis=1)


def cones(body: Body, ranges_m: Floats, pose: Pose) -> tuple[Mesh, Mesh]:
    """Sonar cones in the world: those that heard something, up to it, and those that did not."""
    heard: list[Floats] = []
    silent: list[Floats] = []
    for sonar, measured in zip(body.sonars, ranges_m[: len(body.sonars)], strict=True):
        if math.isnan(measured):
            continue
        reach = min(measured, sonar.max_range_m)
        angles = np.linspace(-sonar.beam_rad / 2, sonar.beam_rad / 2, _CONE_STEPS)
        rim = reach * np.column_stack([np.cos(angles), np.sin(angles)])
        corners = placed(np.vstack([[(0.0, 0.0)], rim]), sonar.pose)
        (heard if math.isfinite(measured) else silent).append(placed(corners, pose))
    return _fans(heard), _fans(silent)


def _fans(fans: list[Floats]) -> Mesh:
    """Triangles about the first point of each fan of points, all fans of one size."""
    if not fans:
        return np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
    count = len(fans[0])
    one = np.array([(0, i, i + 1) for i in range(1, count - 1)])
    faces = np.concatenate([one + i * count for i in range(len(fans))])
    return np.concatenate(fans), faces


def scan_points(body: Body, ranges_m: Floats, pose: Pose) -> Floats:
    """Points (n, 2) that a lidar saw."""
    if body.lidar is None:
        return np.empty((0, 2))
    beams = ranges_m[len(body.sonars) :]
    angles = body.lidar.first_rad + body.lidar.step_rad * np.arange(len(beams))
    seen = np.isfinite(beams)
    points = beams[seen, None] * np.column_stack([np.cos(angles[seen]), np.sin(angles[seen])])
    return placed(placed(points, body.lidar.pose), pose)


# ---- curvature intervals -------------------------------------------------------------------------


def arc(curvature: float, length_m: float) -> Floats:
    """Points (n, 2) of an arc from the origin along +x."""
    if abs(curvature) * length_m > _ARC_TURN:
        length_m = _ARC_TURN / abs(curvature)
    s = np.linspace(0.0, length_m, _ARC_STEPS)
    if abs(curvature) < 1e-6:
        return np.column_stack([s, np.zeros_like(s)])
    turn = s * curvature
    return np.column_stack([np.sin(turn), 1 - np.cos(turn)]) / curvature


def free_arcs(avoidance: dict[str, Any], pose: Pose) -> tuple[Mesh, Mesh, Mesh]:
    """What is free of each curvature interval, in the world: near, middling and far ones."""
    kinds: tuple[list[Floats], ...] = ([], [], [])
    for interval in avoidance["intervals"]:
        distance = interval["distance_m"]
        low, high = interval["curvature_lo"], interval["curvature_hi"]
        if distance is None or not all(map(math.isfinite, (distance, low, high))):
            continue
        kind = sum(distance > limit for limit in NEAR_M)
        strip_points = np.vstack([arc(low, distance), arc(high, distance)])
        kinds[kind].append(placed(strip_points, pose))
    near, middling, far = (_ribbons(kind) for kind in kinds)
    return near, middling, far


def _ribbons(ribbons: list[Floats]) -> Mesh:
    """Triangles between two lines of `_ARC_STEPS` points each."""
    if not ribbons:
        return np.empty((0, 2)), np.empty((0, 3), dtype=np.int64)
    n = _ARC_STEPS
    one = np.array(
        [face for i in range(n - 1) for face in ((i, i + 1, n + i), (i + 1, n + i + 1, n + i))]
    )
    faces = np.concatenate([one + i * 2 * n for i in range(len(ribbons))])
    return np.concatenate(ribbons), faces


def chosen_arc(twist: dict[str, float], pose: Pose, seconds: float = 2.5) -> Floats:
    """Points (n, 2) of where a command leads in the next seconds; empty for a turn in place."""
    linear, angular = twist["linear_mps"], twist["angular_radps"]
    if abs(linear) < 0.02:
        return np.empty((0, 2))
    points = arc(angular / linear, abs(linear) * seconds)
    return placed(points if linear > 0 else points * (-1, -1), pose)
