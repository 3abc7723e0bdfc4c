"""Pictures: a run on its map, and a field of a plan."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D

from cairn.view.style import AMBER, DPI, FREE, INK, OCCUPIED, PALE, PAPER, POSE_BY, UNKNOWN

if TYPE_CHECKING:
    from cairn.missions.result import Result, RobotResult, Transition
    from cairn.world import World

BOX, CONTACT = AMBER, "#b3122b"
MODES = {  # part of a mode's name → what a person calls it, and its colour
    "track": ("tracking the path", "#0b7a75"),
    "avoid": ("avoiding obstacles", "#d1495b"),
    "plan": ("planning", "#22303c"),
    "stop": ("standing", "#22303c"),
}
OUTLINE_EVERY_M = 1.5
NOTES_AT_MOST = 20
NOTE_LINES_AT_MOST = 2
NOTE_POINTS, TITLE_POINTS = 8.0, 11.5
PAGE_IN, COLUMN_IN, LINE_IN = 12.0, 5.2, 0.18


@dataclass(frozen=True)
class Note:
    """Transitions of one place and moment, told under one number."""

    number: int
    transitions: list[Transition]

    @property
    def at(self) -> tuple[float, float]:
        """Where, by truth [m, world frame]."""
        return self.transitions[0].at

    @property
    def text(self) -> str:
        """When and why, in one sentence."""
        # A stop on the way says what made it stop; what follows is its consequence.
        why = next((t for t in self.transitions if "stop" in t.after), self.transitions[-1])
        return f"{self.transitions[0].time_s:.0f} s: {_without_mode(why.sentence)}"


def draw_run(result: Result, path: Path) -> Path:
    """Draw a run: the map, what it does not show, the plans, the way driven by truth, and why.

    Args:
        result: of `cairn.missions.run`.
        path: the picture to write, .png, .svg or .pdf.

    Returns:
        `path`.
    """
    known = result.map or result.world
    notes = {robot.name: _notes(robot.transitions) for robot in result.robots}
    told = {name: _told(own, len(notes)) for name, own in notes.items()}
    columns = _columns(_paragraphs(notes, told))
    figure, axes, below = _page(result.world, max(map(len, columns)))
    _draw_world(axes, result.world if result.map is None else known)
    if result.map is not None and result.map is not result.world:
        _draw_world(axes, result.world, alpha=0.25)
    for box in result.scenario.boxes:
        corners = _rectangle((box.x_m, box.y_m, box.yaw_rad), box.length_m, box.width_m)
        axes.add_patch(
            Polygon(corners, facecolor="#f6e3c4", edgecolor=BOX, hatch="////", lw=0.9, zorder=3)
        )
    several = len(result.robots) > 1
    for robot in result.robots:
        _draw_robot(axes, result, robot, several)
    for robot in result.robots:
        _draw_notes(axes, told[robot.name])
    _scale_bar(axes, result.world)
    _legend(axes, result)
    _title(figure, axes, result)
    _write_columns(below, columns)
    return _save(figure, path)


def draw_plan(
    world: World,
    cost_to_go: np.ndarray,
    goal: tuple[float, float],
    path: Path,
    *,
    start: tuple[float, float] | None = None,
    way: np.ndarray | None = None,
) -> Path:
    """Draw a field: contours of the cost-to-go, and the way from one start.

    Args:
        world: what was planned on.
        cost_to_go: (rows, cols), inf where there is no way.
        goal: [m, world frame].
        path: the picture to write.
        start: of the way [m, world frame].
        way: its points (n, 2) [m, world frame], or None where there is none.

    Returns:
        `path`.
    """
    figure, axes, _ = _page(world, 0, bar=True)
    _draw_world(axes, world)
    finite = np.where(np.isfinite(cost_to_go), cost_to_go, np.nan)
    if np.isfinite(finite).any():
        top = float(np.nanmax(finite))
        rows, cols = finite.shape
        extent = (0.0, float(cols), 0.0, float(rows))
        image = axes.imshow(
            finite, origin="lower", extent=extent, cmap="YlGnBu_r", alpha=0.85, zorder=1.5,
            interpolation="nearest", vmin=0.0, vmax=max(top, 1e-9),
        )  # fmt: skip
        image.set_transform(_world_from_pixels(world) + axes.transData)
        if min(rows, cols) > 1 and top > 0:
            x, y = _centres(world)
            levels = np.linspace(0.0, top, 26)[1:-1]
            axes.contour(x, y, finite, levels=levels, colors=PAPER, linewidths=0.6, zorder=2)
        place = axes.get_position()
        beside = figure.add_axes((place.x1 + 0.015, place.y0, 0.016, place.height))
        bar = figure.colorbar(image, cax=beside)
        bar.set_label("cost to go", color=INK)
        bar.outline.set_visible(False)  # type: ignore[operator]
    if way is not None:
        axes.plot(*way.T, color=PAPER, lw=4.0, zorder=4, solid_capstyle="round")
        axes.plot(*way.T, color="#d1495b", lw=2.0, zorder=4, solid_capstyle="round")
    if start is not None:
        _mark_start(axes, start)
    _mark_goal(axes, goal, "goal", reached=True)
    _frame(axes, world)
    _scale_bar(axes, world)
    axes.set_title(_plan_title(world, start, way), loc="left", color=INK, fontsize=12)
    return _save(figure, path)


# ---- the page ------------------------------------------------------------------------------------


def _page(world: World, lines: int, *, bar: bool = False) -> tuple[Figure, Axes, Axes | None]:
    x0, x1, y0, y1 = _view(world)
    width, right = PAGE_IN, 0.90 if bar else 0.98
    map_height = min(max(width * (right - 0.02) * (y1 - y0) / (x1 - x0), 3.0), 9.0)
    notes_height = LINE_IN * lines + 0.1 if lines else 0.0
    height = map_height + notes_height + (1.15 if bar else 1.35)
    figure = Figure(figsize=(width, height), facecolor=PAPER)
    FigureCanvasAgg(figure)
    bottom = (notes_height + 0.6) / height
    axes = figure.add_axes((0.02, bottom, right - 0.02, map_height / height))
    below = None
    if lines:
        below = figure.add_axes((0.02, 0.12 / height, 0.96, notes_height / height))
        below.set_axis_off()
    _frame(axes, world)
    return figure, axes, below


def _frame(axes: Axes, world: World) -> None:
    x0, x1, y0, y1 = _view(world)
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _view(world: World) -> tuple[float, float, float, float]:
    """Return the part of the world worth showing: all that is not unknown, and a margin."""
    rows, cols = np.nonzero(np.asarray(world.occupancy) != 2)
    if len(rows) == 0:
        return world.extent
    ends = np.array([[r, c] for r in (rows.min(), rows.max()) for c in (cols.min(), cols.max())])
    points = world.point_of(ends)
    margin = 0.02 * float(np.ptp(points, axis=0).max()) + world.resolution_m
    (x0, y0), (x1, y1) = points.min(axis=0) - margin, points.max(axis=0) + margin
    return float(x0), float(x1), float(y0), float(y1)


def _title(figure: Figure, axes: Axes, result: Result) -> None:
    summary = result.summary()
    verdict = {0: "#0b7a75", 3: "#d1495b", 4: "#d1495b"}[result.exit_code]
    top = 1.0 - 0.30 / figure.get_figheight()
    step = 0.27 / figure.get_figheight()
    name = figure.text(0.025, top, result.scenario.name, fontsize=17, weight="bold", color=INK)
    right = name.get_window_extent().x1 / figure.bbox.width
    room_in = (0.975 - right - 0.015) * PAGE_IN
    sentence = _wrapped(result.sentence, TITLE_POINTS, room_in, 1)[0]
    figure.text(
        right + 0.015, top, sentence, fontsize=TITLE_POINTS, color=verdict, parse_math=False
    )
    facts = [
        f"{summary['time_s']:.0f} s",
        f"{summary['path_length_m']:.1f} m driven",
        f"{summary['contacts'] or 'no'} contact{'s' if summary['contacts'] != 1 else ''}",
        f"clearance ≥ {summary['least_clearance_m']:.2f} m"
        if summary["least_clearance_m"] is not None
        else "nothing near",
        f"{summary['plan_count']} plan{'s' if summary['plan_count'] != 1 else ''}",
        f"pose by {POSE_BY.get(str(result.scenario.pose), '?')},"
        f" off by {summary['drift_m']:.2f} m at the end",
        f"seed {result.seed}",
    ]
    figure.text(0.025, top - step, "   ·   ".join(facts), fontsize=10, color=PALE)


def _write_columns(axes: Axes | None, columns: list[list[tuple[str, str]]]) -> None:
    """Write (number, text) lines in two columns."""
    if axes is None:
        return
    height_in = axes.bbox.height / axes.figure.dpi
    for column, lines in enumerate(columns):
        for row, (number, text) in enumerate(lines):
            y = 1.0 - row * LINE_IN / height_in
            for x, part, side in ((0.014, number, "right"), (0.022, text, "left")):
                axes.text(
                    0.5 * column + x, y, part, transform=axes.transAxes, fontsize=NOTE_POINTS,
                    color=INK, va="top", ha=side, parse_math=False,
                )  # fmt: skip


def _save(figure: Figure, path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI, facecolor=PAPER)
    return path


# ---- what is on the map --------------------------------------------------------------------------


def _world_from_pixels(world: World) -> Affine2D:
    x, y, yaw = world.origin
    return Affine2D().scale(world.resolution_m).rotate(yaw).translate(x, y)


def _centres(world: World) -> tuple[np.ndarray, np.ndarray]:
    points = world.point_of(np.moveaxis(np.indices(world.shape), 0, -1))
    return points[..., 0], points[..., 1]


def _draw_world(axes: Axes, world: World, alpha: float = 1.0) -> None:
    rows, cols = world.shape
    image = axes.imshow(
        np.asarray(world.occupancy), origin="lower", extent=(0.0, cols, 0.0, rows), vmin=0, vmax=2,
        cmap=ListedColormap([FREE, OCCUPIED, UNKNOWN]), interpolation="nearest", alpha=alpha,
    )  # fmt: skip
    image.set_transform(_world_from_pixels(world) + axes.transData)
    _frame(axes, world)


def _draw_robot(axes: Axes, result: Result, robot: RobotResult, several: bool) -> None:
    trace = robot.trace
    truth, estimate = np.array(trace.truth), np.array(trace.estimate)
    for number, plan in enumerate(trace.plans):
        if len(plan) > 1:
            label = "plan" if number == 0 else None
            axes.plot(*plan.T, color="#3f6fb5", lw=0.9, ls=(0, (5, 3)), zorder=4, label=label)
    if result.scenario.pose != "truth":
        axes.plot(*estimate[:, :2].T, color=PALE, lw=1.0, alpha=0.75, zorder=4.5)
    pieces = np.stack((truth[:-1, :2], truth[1:, :2]), axis=1)
    jumps = np.hypot(*(pieces[:, 1] - pieces[:, 0]).T) > 0.3
    colours = np.array([_mode(mode)[1] for mode in trace.mode[1:]])
    axes.add_collection(
        LineCollection(list(pieces[~jumps]), colors=list(colours[~jumps]), linewidths=2.4,
                       zorder=5, capstyle="round")
    )  # fmt: skip
    for before, after in pieces[jumps]:
        axes.annotate(
            "", xy=after, xytext=before, zorder=7,
            arrowprops={"arrowstyle": "->", "color": "#d1495b", "lw": 1.6, "shrinkA": 0},
        )  # fmt: skip
        axes.annotate(
            "shoved", xy=(before + after) / 2, xytext=(-8, -3), textcoords="offset points",
            ha="right", va="top", fontsize=8.5, color="#d1495b", zorder=7,
        )  # fmt: skip
    _draw_outlines(axes, truth, trace.mode, result)
    for contact in robot.contacts:
        row = max(int(np.searchsorted(trace.time_s, contact["time_s"] + 1e-9)) - 1, 0)
        x, y = (float(v) for v in truth[row, :2])
        axes.plot(x, y, marker="x", ms=13, mec=CONTACT, mew=3.4, zorder=8.5)
        axes.annotate(
            f"touched {contact['name']}", xy=(x, y), xytext=(10, 10), fontsize=8.5,
            textcoords="offset points", color=CONTACT, zorder=10, parse_math=False,
            bbox={"boxstyle": "round,pad=0.2", "fc": PAPER, "ec": "none", "alpha": 0.85},
        )  # fmt: skip
    _mark_start(axes, (truth[0, 0], truth[0, 1]), robot.name if several else "start")
    for number, goal in enumerate(robot.goals, start=1):
        if goal.goal is not None:
            name = goal.place or (f"goal {number}" if len(robot.goals) > 1 else "goal")
            _mark_goal(axes, goal.goal, name.replace("_", " "), goal.outcome == "reached")


def _draw_outlines(axes: Axes, truth: np.ndarray, modes: list[str], result: Result) -> None:
    """Draw the robot's outline each time it has driven a stretch, and where it ended."""
    length_m, width_m = _outline_of(result)
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T))])
    marks = np.arange(0.0, driven[-1], OUTLINE_EVERY_M)
    rows = [*np.searchsorted(driven, marks), len(truth) - 1]
    for row in rows:
        x, y, heading = truth[row]
        colour = _mode(modes[row])[1]
        corners = _rectangle((x, y, heading), length_m, width_m)
        last = row == len(truth) - 1
        axes.add_patch(
            Polygon(corners, facecolor=colour if last else "none", edgecolor=colour,
                    alpha=0.9 if last else 0.45, lw=1.2 if last else 0.7, zorder=6 if last else 4.8)
        )  # fmt: skip
        if last:
            nose = np.array([math.cos(heading), math.sin(heading)]) * length_m / 2
            axes.plot([x, x + nose[0]], [y, y + nose[1]], color=PAPER, lw=1.4, zorder=6.1)


def _outline_of(result: Result) -> tuple[float, float]:
    from cairn.profile import Profile

    footprint = Profile.load(result.scenario.profile).footprint
    return footprint.length_m, footprint.width_m


def _draw_notes(axes: Axes, notes: list[Note]) -> None:
    placed: list[tuple[float, float]] = []
    x0, x1 = axes.get_xlim()
    step = 0.017 * (x1 - x0)
    for note in notes:
        x, y = note.at[0] + 0.6 * step, note.at[1] + 0.8 * step
        while any(math.dist((x, y), other) < step for other in placed):
            x += 0.6 * step
            y += 0.35 * step
        placed.append((x, y))
        axes.annotate(
            str(note.number), xy=note.at, xytext=(x, y), fontsize=7.5, color=PAPER, ha="center",
            va="center", zorder=9, fontweight="bold",
            bbox={"boxstyle": "circle,pad=0.22", "fc": INK, "ec": PAPER, "lw": 0.8},
            arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.6},
        )  # fmt: skip


def _mark_start(axes: Axes, at: tuple[float, float], name: str = "start") -> None:
    axes.plot(*at, marker="o", ms=9, mfc=PAPER, mec=INK, mew=2.0, zorder=8)
    _name(axes, at, name)


def _mark_goal(axes: Axes, at: tuple[float, float], name: str, reached: bool) -> None:
    colour = "#0b7a75" if reached else "#d1495b"
    axes.plot(*at, marker="*" if reached else "X", ms=17 if reached else 11, mfc=colour, mec=PAPER,
              mew=1.2, zorder=8)  # fmt: skip
    _name(axes, at, name)


def _name(axes: Axes, at: tuple[float, float], name: str) -> None:
    axes.annotate(
        name, xy=at, xytext=(0, -15), textcoords="offset points", fontsize=8.5, color=INK,
        ha="center", va="center", zorder=10, parse_math=False,
        bbox={"boxstyle": "round,pad=0.2", "fc": PAPER, "ec": "none", "alpha": 0.8},
    )  # fmt: skip


def _scale_bar(axes: Axes, world: World) -> None:
    x0, x1, y0, y1 = _view(world)
    wanted = 0.15 * (x1 - x0)
    length = max(
        (m * 10.0**e for e in range(-2, 5) for m in (1, 2, 5) if m * 10.0**e <= wanted), default=1.0
    )
    right, y = x1 - 0.02 * (x1 - x0), y0 - 0.018 * (y1 - y0)
    axes.plot([right - length, right], [y, y], color=INK, lw=2.5, clip_on=False, zorder=9,
              solid_capstyle="butt")  # fmt: skip
    axes.text(right - length - 0.01 * (x1 - x0), y, f"{length:g} m", ha="right", va="center",
              fontsize=9, color=INK)  # fmt: skip


def _legend(axes: Axes, result: Result) -> None:
    seen = {_mode(mode) for robot in result.robots for mode in robot.trace.mode}
    moving = [MODES[part] for part in ("track", "avoid") if MODES[part] in seen]
    handles: list[Any] = [Line2D([], [], color=c, lw=2.6, label=name) for name, c in moving]
    if any(len(plan) > 1 for robot in result.robots for plan in robot.trace.plans):
        handles.append(Line2D([], [], color="#3f6fb5", lw=0.9, ls=(0, (5, 3)), label="plan"))
    if result.scenario.pose != "truth":
        handles.append(Line2D([], [], color=PALE, lw=1.0, label="where it believes it is"))
    if result.scenario.boxes:
        handles.append(Patch(fc="#f6e3c4", ec=BOX, hatch="////", label="not on the map"))
    axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(0.0, -0.005), ncols=6, frameon=False,
        fontsize=9, labelcolor=INK, handlelength=1.8, columnspacing=1.4, borderaxespad=0.2,
    )  # fmt: skip


# ---- small things --------------------------------------------------------------------------------


def _notes(transitions: list[Transition]) -> list[Note]:
    """Put transitions of one place and moment under one number."""
    groups: list[list[Transition]] = []
    for transition in transitions:
        last = groups[-1][-1] if groups else None
        near = last is not None and math.dist(last.at, transition.at) < 0.15
        if near and last is not None and transition.time_s - last.time_s < 3.0:
            groups[-1].append(transition)
        else:
            groups.append([transition])
    return [Note(number, group) for number, group in enumerate(groups, start=1)]


def _told(notes: list[Note], robots: int) -> list[Note]:
    """Return the notes to show: all, or the first and the last few."""
    most = max(NOTES_AT_MOST // robots, 4)
    if len(notes) <= most:
        return notes
    return [*notes[: most // 2], *notes[most // 2 - most :]]


def _paragraphs(
    notes: dict[str, list[Note]], told: dict[str, list[Note]]
) -> list[list[tuple[str, str]]]:
    """Return for every note told its lines, (number, text); what is left out is counted."""
    paragraphs = []
    for name, own in told.items():
        who = f"{name}, " if len(told) > 1 else ""
        for before, note in zip([None, *own], own, strict=False):
            if before is not None and note.number > before.number + 1:
                left_out = note.number - before.number - 1
                paragraphs.append([("…", f"{left_out} more in summary.json")])
            lines = _wrapped(who + note.text, NOTE_POINTS, COLUMN_IN, NOTE_LINES_AT_MOST)
            numbers = [str(note.number), *[""] * (len(lines) - 1)]
            paragraphs.append(list(zip(numbers, lines, strict=True)))
    return paragraphs


def _columns(paragraphs: list[list[tuple[str, str]]]) -> list[list[tuple[str, str]]]:
    """Return two columns of lines, about equally long, no paragraph torn."""
    total = sum(map(len, paragraphs))
    left: list[tuple[str, str]] = []
    right: list[tuple[str, str]] = []
    for paragraph in paragraphs:
        here = right if right or len(left) + len(paragraph) > (total + 1) // 2 else left
        here += paragraph
    return [left, right] if left else [right, left]


def _wrapped(text: str, points: float, width_in: float, at_most: int) -> list[str]:
    """Return `text` in lines that fit `width_in` as drawn; what exceeds `at_most` lines is cut."""
    words, lines = text.split(), [""]
    for number, word in enumerate(words):
        longer = f"{lines[-1]} {word}".lstrip()
        last = len(lines) == at_most
        ending = " …" if last and number < len(words) - 1 else ""
        if not lines[-1] or _width_in(longer + ending, points) <= width_in:
            lines[-1] = longer
        elif last:
            lines[-1] += " …"
            break
        else:
            lines.append(word)
    return lines


def _width_in(text: str, points: float) -> float:
    """Width of a text as drawn."""
    width, _, _ = text_to_path.get_text_width_height_descent(
        text, FontProperties(size=points), ismath=False
    )
    return width / 72


def _without_mode(sentence: str) -> str:
    """Return a navigator's sentence without the mode that it begins with; the colour says it."""
    mode, colon, why = sentence.partition(": ")
    named = colon and any(part in mode.lower() for part in MODES)
    return (why if named else sentence).rstrip(".")


def _mode(name: str) -> tuple[str, str]:
    lower = name.lower()
    return next((pair for part, pair in MODES.items() if part in lower), (name, "#555555"))


def _plan_title(world: World, start: tuple[float, float] | None, way: np.ndarray | None) -> str:
    if way is not None:
        return f"{world.name}: {np.hypot(*np.diff(way, axis=0).T).sum():.2f} m to the goal"
    return f"{world.name}: cost to go" if start is None else f"{world.name}: no way to the goal"


def _rectangle(pose: tuple[float, float, float], length_m: float, width_m: float) -> np.ndarray:
    x, y, heading = pose
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length_m / 2, width_m / 2)
    c, s = math.cos(heading), math.sin(heading)
    return half @ np.array([[c, s], [-s, c]]) + (x, y)
