"""The picture of the fuzzy controller's parameters in one posture, after Fig. 5."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Arc, Polygon

from cairn.view.style import AMBER, BLUE, INK, PALE, PAPER, RED, TEAL, calm, label, page, save

OUTLINE_M = (0.508, 0.497)


def draw_parameters(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.parameters.measure`."""
    told = record["summary"]
    figure, room = page(
        (11.5, 6.8), "Fig. 5: parameters of the fuzzy controller",
        f"one step of the tracker: dR {told['dR']:.2f} m, dθ {told['dtheta']:.2f} rad, "
        f"α₁ {told['alpha1']:.2f} rad, α₂ {told['alpha2']:.2f} rad → C {told['C']:.2f} → "
        f"{told['twist']['linear_mps']:.2f} m/s, {told['twist']['angular_radps']:.2f} rad/s",
    )  # fmt: skip
    left, bottom, width, height = room
    axes = calm(figure.add_axes((left + 0.05, bottom + 0.05, width - 0.06, height - 0.06)))
    points = np.asarray(record["waypoints"])
    index = record["index"]
    axes.plot(*points.T, "-", color=PALE, lw=1.2, zorder=1)
    axes.plot(*points.T, "o", color=INK, ms=7, zorder=4)
    for offset in range(4):
        at = points[index + offset]
        name = "$N_i$" if offset == 0 else f"$N_{{i+{offset}}}$"
        beside = (-12, 12) if offset == 0 else (9, -15)
        axes.annotate(name, at, xytext=beside, textcoords="offset points", fontsize=13, color=INK)
    _robot(axes, record["pose"], PALE, "now", 0.25)
    _robot(axes, record["ahead"], TEAL, "when the command takes hold", 0.4)
    x, y, heading = record["ahead"]
    goal = points[index + 1]
    axes.plot([x, goal[0]], [y, goal[1]], color=RED, lw=2.2, zorder=3)
    _beside(axes, (np.array([x, y]) + goal) / 2, "dR", RED, (8, -16))
    bearing = math.atan2(goal[1] - y, goal[0] - x)
    _angle(axes, (x, y), heading, bearing, 0.5, "dθ", BLUE)
    axes.plot([x, x + 0.8 * math.cos(heading)], [y, y + 0.8 * math.sin(heading)],
              color=BLUE, lw=1.0, ls=(0, (5, 3)), zorder=2)  # fmt: skip
    for corner, name in ((index + 1, "α₁"), (index + 2, "α₂")):
        before, at, after = points[corner - 1 : corner + 2]
        onwards = at + 0.45 * (at - before) / np.hypot(*(at - before))
        axes.plot(*np.stack([at, onwards]).T, color=AMBER, lw=1.0, ls=(0, (5, 3)), zorder=2)
        first = math.atan2(*(at - before)[::-1])
        _angle(axes, at, first, math.atan2(*(after - at)[::-1]), 0.32, name, AMBER)
    axes.set_aspect("equal")
    axes.margins(0.12)
    label(axes, "x [m]", "y [m]")
    return save(figure, path)


def _robot(axes: Any, pose: Any, colour: str, name: str, alpha: float) -> None:
    x, y, heading = pose
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * OUTLINE_M / np.array([2, 2])
    c, s = math.cos(heading), math.sin(heading)
    corners = half @ np.array([[c, s], [-s, c]]) + (x, y)
    axes.add_patch(Polygon(corners, facecolor=colour, alpha=alpha, edgecolor=INK, lw=1.0, zorder=2))
    axes.annotate("", (x + 0.25 * c, y + 0.25 * s), (x, y), zorder=5,
                  arrowprops={"arrowstyle": "-|>", "color": INK})  # fmt: skip
    low = corners[corners[:, 1].argmin()]
    side = (-10, -13) if colour == PALE else (28, -13)
    axes.annotate(name, low, xytext=side, textcoords="offset points", fontsize=9, color=INK,
                  ha="right" if colour == PALE else "left")  # fmt: skip


def _angle(
    axes: Any, at: Any, begin: float, end: float, radius: float, name: str, colour: str
) -> None:
    turn = math.remainder(end - begin, math.tau)
    low, high = sorted((begin, begin + turn))
    axes.add_patch(Arc(at, 2 * radius, 2 * radius, theta1=math.degrees(low),
                       theta2=math.degrees(high), color=colour, lw=2.0, zorder=3))  # fmt: skip
    middle = begin + turn / 2
    place = np.asarray(at) + 1.22 * radius * np.array([math.cos(middle), math.sin(middle)])
    paper = {"boxstyle": "round,pad=0.1", "fc": PAPER, "ec": "none", "alpha": 0.8}
    x, y = (float(value) for value in place)
    axes.text(x, y, name, color=colour, fontsize=13, ha="center", va="center", zorder=6, bbox=paper)


def _beside(axes: Any, at: Any, name: str, colour: str, offset: tuple[int, int]) -> None:
    axes.annotate(name, at, xytext=offset, textcoords="offset points", color=colour, fontsize=13)
