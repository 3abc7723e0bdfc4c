"""ARIA's 2-D maps, the worlds that owners of Pioneer robots have. Millimetres and degrees.

Lines and points become occupied cells: every cell that a line passes through or touches, so no wall
has a gap. Forbidden lines and areas (given in axes turned about the map's origin by their heading)
are ground of infinite cost, not things that stand there. Goals, with or without heading, and the
robot's home become named places. Other objects are read over.
"""

import math
import shlex
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.maps.source import numbers, read_text, refuse, whole
from cairn.world import FREE, OCCUPIED, Place, World

_MOST_CELLS = 400_000_000
_TOUCH = 1e-9  # in cells; a line along a border touches the cells on both sides

Segment = tuple[float, float, float, float]


class _Map:
    """What a file holds, in metres and radians."""

    def __init__(self) -> None:
        self.lines: list[Segment] = []
        self.points: list[tuple[float, float]] = []
        self.forbidden_lines: list[Segment] = []
        self.forbidden_areas: list[list[tuple[float, float]]] = []
        self.goals: dict[str, Place] = {}


def load(path: str | Path, *, resolution_m: float = 0.05) -> World:
    """Read an ARIA `.map` into cells of `resolution_m`.

    The grid covers all that the file holds, with its corner on a multiple of the resolution.

    Raises:
        MapError: one subclass per cause.
    """
    path = Path(path)
    if not (math.isfinite(resolution_m) and resolution_m > 0):
        reason = f"resolution_m is {resolution_m}, must be a finite number greater than 0"
        refuse(errors.MapKeyInvalid, path, reason, key="resolution_m", value=resolution_m)
    found = _read(path)
    if not found.lines and not found.points:
        refuse(errors.MapEmpty, path, "the map has no line and no point")

    corners = [(s[0], s[1]) for s in found.lines + found.forbidden_lines]
    corners += [(s[2], s[3]) for s in found.lines + found.forbidden_lines]
    corners += found.points + [corner for area in found.forbidden_areas for corner in area]
    corners += [(place[0], place[1]) for place in found.goals.values()]
    with np.errstate(over="ignore", invalid="ignore"):
        in_cells = np.round(np.array(corners) / resolution_m, 9)
        least = np.floor(in_cells.min(axis=0)) - 1
        size = np.floor(in_cells.max(axis=0)) + 2 - least
    if not size.prod() <= _MOST_CELLS:
        reason = f"{size[1]:g} × {size[0]:g} cells of {resolution_m:g} m, more than {_MOST_CELLS}"
        refuse(errors.MapTooLarge, path, reason, cells=float(size.prod()))
    cols, rows = (int(v) for v in size)

    stands = np.zeros((rows, cols), bool)
    forbidden = np.zeros((rows, cols), bool)
    for segment in found.lines:
        _draw(stands, _in_cells(segment, resolution_m, least))
    for x, y in found.points:
        _draw(stands, _in_cells((x, y, x, y), resolution_m, least), touch=0.0)
    for segment in found.forbidden_lines:
        _draw(forbidden, _in_cells(segment, resolution_m, least))
    for area in found.forbidden_areas:
        _fill(forbidden, (np.array(area) / resolution_m) - least)

    costs = None
    if forbidden.any():
        costs = np.where(forbidden, np.float32(np.inf), np.float32(1.0))
    x, y = (float(v) * resolution_m for v in least)
    occupancy = np.where(stands, np.uint8(OCCUPIED), np.uint8(FREE))
    return World(
        occupancy, resolution_m, (x, y, 0.0), costs=costs, name=path.stem, goals=found.goals
    )


def _in_cells(segment: Segment, resolution_m: float, least: NDArray[np.float64]) -> Segment:
    x0, y0, x1, y1 = (round(v / resolution_m, 9) for v in segment)  # 0.6 / 0.1 is 6
    return x0 - least[0], y0 - least[1], x1 - least[0], y1 - least[1]


def _draw(cells: NDArray[np.bool_], segment: Segment, touch: float = _TOUCH) -> None:
    """Marks every cell that the segment (in cells) passes through or touches."""
    x0, y0, x1, y1 = segment if segment[1] <= segment[3] else segment[2:] + segment[:2]
    for row in range(math.floor(y0 - touch), math.floor(y1 + touch) + 1):
        # The part of the segment in this row's band of y.
        if y1 - y0 > 0:
            t0 = min(max((row - touch - y0) / (y1 - y0), 0.0), 1.0)
            t1 = min(max((row + 1 + touch - y0) / (y1 - y0), 0.0), 1.0)
        else:
            t0, t1 = 0.0, 1.0
        xs = (x0 + t0 * (x1 - x0), x0 + t1 * (x1 - x0))
        cells[row, math.floor(min(xs) - touch) : math.floor(max(xs) + touch) + 1] = True


def _fill(cells: NDArray[np.bool_], corners: NDArray[np.float64]) -> None:
    """Marks the cells whose centre lies in a convex polygon, and those on its border."""
    rows, cols = np.arange(cells.shape[0])[:, None], np.arange(cells.shape[1])
    side = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        _draw(cells, (*a, *b))
        side.append((b[0] - a[0]) * (rows + 0.5 - a[1]) - (b[1] - a[1]) * (cols + 0.5 - a[0]))
    left = np.logical_and.reduce([s >= 0 for s in side])
    right = np.logical_and.reduce([s <= 0 for s in side])
    cells |= left ^ right


def _read(path: Path) -> _Map:
    lines = read_text(path).splitlines()
    if not any(line.strip() for line in lines):
        refuse(errors.MapEmpty, path, "the file is empty")
    if lines[0].strip() != "2D-Map":
        reason = f"begins with `{lines[0].strip()[:40]}`, must be `2D-Map`"
        refuse(errors.MapFormatUnknown, path, reason, line=1)
    found = _Map()
    counts: dict[str, tuple[int, int]] = {}
    section = "header"
    for number, line in enumerate(lines[1:], start=2):
        text = line.strip()
        if not text:
            continue
        if text in ("LINES", "DATA"):
            section = text
        elif section == "LINES":
            x0, y0, x1, y1 = (v / 1000 for v in numbers(path, number, text, 4, "a line x y x y"))
            found.lines.append((x0, y0, x1, y1))
        elif section == "DATA":
            x, y = (v / 1000 for v in numbers(path, number, text, 2, "a point x y"))
            found.points.append((x, y))
        elif text.startswith("Cairn:"):
            _read_cairn(path, number, text, found)
        else:
            _read_header(path, number, text, counts)

    for key, section, things in (
        ("NumLines", "LINES", found.lines),
        ("NumPoints", "DATA", found.points),
    ):
        number, expected = counts.get(key, (None, len(things)))
        if len(things) == expected:
            continue
        reason = f"{key} is {expected}, but {len(things)} follow under {section}"
        if len(things) < expected:
            refuse(errors.MapTruncated, path, reason, line=number)
        refuse(
            errors.MapCountMismatch,
            path,
            reason,
            line=number,
            expected=expected,
            found=len(things),
        )
    return found


def _read_header(path: Path, number: int, text: str, counts: dict[str, tuple[int, int]]) -> None:
    key, colon, value = text.partition(":")
    if not colon:
        reason = f"`{text[:40]}` is neither `Key: value` nor LINES nor DATA"
        refuse(errors.MapLineInvalid, path, reason, line=number)
    if key in ("NumLines", "NumPoints"):
        counts[key] = (number, whole(path, number, key, value))
    elif key in ("LineMinPos", "LineMaxPos", "MinPos", "MaxPos"):
        numbers(path, number, value, 2, f"{key}, a position x y")


def _read_cairn(path: Path, number: int, text: str, found: _Map) -> None:
    """`Cairn: Kind x y th "description" ICON "name" [x1 y1 x2 y2]`."""
    try:
        words = shlex.split(text)[1:]
    except ValueError:
        refuse(errors.MapLineInvalid, path, "a quote is not closed", line=number)
    if len(words) < 7 or words[5] != "ICON":
        reason = f'`{text[:60]}` is not `Cairn: Kind x y th "" ICON "name"`'
        refuse(errors.MapLineInvalid, path, reason, line=number)
    kind, name, ends = words[0], words[6], words[7:]
    x, y, degrees = numbers(path, number, " ".join(words[1:4]), 3, f"the pose of {kind} `{name}`")
    x, y, heading = x / 1000, y / 1000, math.radians(degrees)
    match kind:
        case "Goal":
            _add_goal(path, number, found, name, (x, y))
        case "GoalWithHeading":
            _add_goal(path, number, found, name, (x, y, heading))
        case "RobotHome" | "Home":
            _add_goal(path, number, found, name or "home", (x, y, heading))
        case "ForbiddenLine" | "ForbiddenArea":
            what = f"the ends x1 y1 x2 y2 of {kind} `{name}`"
            values = numbers(path, number, " ".join(ends), 4, what)
            x0, y0, x1, y1 = (v / 1000 for v in values)
            if kind == "ForbiddenLine":
                found.forbidden_lines.append((x0, y0, x1, y1))
                return
            c, s = math.cos(heading), math.sin(heading)
            square = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
            found.forbidden_areas.append([(c * u - s * v, s * u + c * v) for u, v in square])


def _add_goal(path: Path, number: int, found: _Map, name: str, place: Place) -> None:
    if name in found.goals:
        refuse(errors.MapLineInvalid, path, f"a second goal `{name}`", line=number)
    found.goals[name] = place
