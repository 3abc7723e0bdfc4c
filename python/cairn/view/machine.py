"""The picture of the state machine: every arrow is a pair of modes that the table has rows for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from cairn.view.style import INK, PALE, PAPER, RED, TEAL, page, save

Point = tuple[float, float]
BOX = (0.2, 0.105)
PLACES = {
    "stop": (0.15, 0.5),
    "path_planning": (0.5, 0.84),
    "path_tracking": (0.85, 0.5),
    "obstacle_avoidance": (0.5, 0.16),
}
COLOURS = {"stop": INK, "path_planning": INK, "path_tracking": TEAL, "obstacle_avoidance": RED}
# (from, to): where the arrow leaves, where it ends, its bend; where its lines stand, and how
WAYS: dict[tuple[str, str], tuple[Point, Point, float, Point, str]] = {
    ("stop", "path_planning"): ((0.12, 0.56), (0.395, 0.86), -0.25, (0.19, 0.80), "right"),
    ("path_planning", "stop"): ((0.42, 0.785), (0.21, 0.56), 0.0, (0.378, 0.675), "left"),
    ("path_planning", "path_tracking"): ((0.605, 0.86), (0.88, 0.56), -0.25, (0.835, 0.80), "left"),
    ("path_tracking", "obstacle_avoidance"): (
        (0.88, 0.44), (0.605, 0.14), -0.25, (0.835, 0.20), "left",
    ),
    ("obstacle_avoidance", "path_tracking"): (
        (0.58, 0.215), (0.79, 0.44), 0.0, (0.665, 0.345), "right",
    ),
    ("stop", "obstacle_avoidance"): ((0.12, 0.44), (0.395, 0.14), 0.25, (0.19, 0.20), "right"),
    ("obstacle_avoidance", "stop"): ((0.42, 0.215), (0.21, 0.44), 0.0, (0.372, 0.375), "left"),
    ("path_tracking", "stop"): ((0.745, 0.5), (0.255, 0.5), 0.0, (0.60, 0.61), "center"),
}  # fmt: skip


def draw_machine(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.machine.measure`, after Fig. 11.

    Every row of the table that changes the mode is a line beside its arrow: what was perceived, and
    the reason given for it. Rows that keep the mode are counted in the state.
    """
    told = record["summary"]
    figure, room = page(
        (13.0, 8.2), "Fig. 11: state machine of the navigation strategy",
        f"generated from the transition table: {told['modes']} modes × {told['events']} events = "
        f"{told['rows']} rows, {told['changes_of_mode']} of them change the mode; event (reason); "
        "· never perceived there, answered all the same",
    )  # fmt: skip
    axes = figure.add_axes(room)
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    places = _places(record["modes"])
    for mode, (x, y) in places.items():
        width, height = BOX
        axes.add_patch(FancyBboxPatch(
            (x - width / 2, y - height / 2), width, height, facecolor=PAPER,
            edgecolor=COLOURS.get(mode, INK), lw=2.2, boxstyle="round,pad=0,rounding_size=0.03",
            zorder=3,
        ))  # fmt: skip
        axes.text(x, y + 0.018, mode.replace("_", " ").capitalize(), ha="center", va="center",
                  fontsize=13, weight="bold", color=COLOURS.get(mode, INK), zorder=4)  # fmt: skip
        stays = len(record["stays"][mode])
        axes.text(x, y - 0.026, f"{stays} events keep it", ha="center", va="center", fontsize=9,
                  color=PALE, zorder=4)  # fmt: skip
    for arrow in record["arrows"]:
        _draw_arrow(axes, arrow, places)
    return save(figure, path)


def _places(modes: list[str]) -> dict[str, Point]:
    """Return where modes stand; ones unknown here stand on a row of their own."""
    others = [mode for mode in modes if mode not in PLACES]
    row = {mode: ((n + 1) / (len(others) + 1), 0.0) for n, mode in enumerate(others)}
    return {mode: PLACES.get(mode) or row[mode] for mode in modes}


def _draw_arrow(axes: Any, arrow: dict[str, Any], places: dict[str, Point]) -> None:
    pair = (arrow["from"], arrow["to"])
    colour = COLOURS.get(arrow["to"], INK)
    start, end, bend, at, side = WAYS.get(pair) or _way_between(*(places[mode] for mode in pair))
    axes.add_patch(FancyArrowPatch(
        start, end, connectionstyle=f"arc3,rad={bend}", arrowstyle="-|>", mutation_scale=20, lw=2.0,
        color=colour, shrinkA=2, shrinkB=2, zorder=2,
    ))  # fmt: skip
    lines = [
        f"{'· ' if not row['perceived'] else ''}{row['event'].replace('_', ' ')}"
        + (f" ({row['reason'].replace('_', ' ')})" if row["reason"] != row["event"] else "")
        for row in arrow["rows"]
    ]
    axes.text(*at, "\n".join(lines), ha=side, va="center", fontsize=9, color=colour, zorder=5,
              linespacing=1.4)  # fmt: skip


def _way_between(start: Point, end: Point) -> tuple[Point, Point, float, Point, str]:
    """The arrow of a pair that nobody has given a place: a bent one between the boxes."""
    middle = np.mean([start, end], axis=0)
    return start, end, 0.2, (float(middle[0]), float(middle[1])), "center"
