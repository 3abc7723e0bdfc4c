"""The picture of free arcs beside obstacles, after Fig. 10."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Circle, Polygon

from cairn.view.style import AMBER, BLUE, INK, OCCUPIED, PALE, RED, TEAL, grid_of, label, page, save


def draw_arcs(record: dict[str, Any], along: Any, path: Path) -> Path:
    """Draw `experiments.paper.arcs.measure`: arcs to their first contact, and free lengths.

    Args:
        record: what `measure` returned.
        along: (curvature, way) → points of an arc.
        path: the picture.
    """
    told = record["summary"]
    figure, room = page(
        (13.0, 5.9), "Fig. 10: how far an arc is free before it touches",
        f"left: arcs of the round robot (r + obstacle = {record['radius_m']:.2f} m) to their first "
        "contact; right: free length of every curvature interval, with the published estimate",
    )  # fmt: skip
    room = (room[0], room[1], room[2] - 0.045, room[3] - 0.02)
    ((left, right),) = grid_of(figure, room, 1, 2, wspace=0.16, width_ratios=(1, 1.1))
    _draw_plane(left, record, along)
    _draw_lengths(right, record)
    v, w = told["twist"]["linear_mps"], told["twist"]["angular_radps"]
    right.axvline(w / v, color=TEAL, lw=2.6, alpha=0.8,
                  label=f"chosen: {v:.2f} m/s, {w:.2f} rad/s")  # fmt: skip
    right.legend(loc="lower left", fontsize=8.5, frameon=True, framealpha=0.9, edgecolor="none")
    return save(figure, path)


def _draw_plane(axes: Any, record: dict[str, Any], along: Any) -> None:
    radius = record["radius_m"]
    for x, y in record["obstacles"]:
        axes.add_patch(Circle((x, y), radius, facecolor="#eceef0", edgecolor=PALE, lw=0.8))
        axes.add_patch(Circle((x, y), 0.05, facecolor=OCCUPIED, zorder=3))
    shown = record["intervals"][:: max(len(record["intervals"]) // 28, 1)]
    for one in shown:
        curvature = (one["curvature_lo"] + one["curvature_hi"]) / 2
        if one["curvature_hi"] - one["curvature_lo"] > 0.5:  # one long free interval: its inner end
            ends = (one["curvature_lo"], one["curvature_hi"])
            curvature = min(ends, key=abs)
        free = one["distance_m"]
        points = along(curvature, np.linspace(0, free, 80))
        full = free >= record["horizon_m"] - 1e-9
        axes.plot(*points.T, color=PALE if full else AMBER, lw=0.8, alpha=0.9)
        if not full:
            axes.plot(*points[-1], ".", color=AMBER, ms=4)
    v, w = record["twist"]["linear_mps"], record["twist"]["angular_radps"]
    chosen = next(
        one for one in record["intervals"]
        if one["curvature_lo"] - 1e-9 <= w / v <= one["curvature_hi"] + 1e-9
    )  # fmt: skip
    axes.plot(
        *along(w / v, np.linspace(0, chosen["distance_m"], 80)).T, color=TEAL, lw=2.6, zorder=4
    )
    length, width = record["outline_m"]
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length / 2, width / 2)
    axes.add_patch(Polygon(half, facecolor="#d5e6e4", edgecolor=INK, lw=1.2, zorder=5))
    axes.annotate("", (0.45, 0), (0, 0), arrowprops={"arrowstyle": "-|>", "color": INK}, zorder=6)
    bearing = record["goal_bearing_rad"]
    towards = np.array([np.cos(bearing), np.sin(bearing)])
    axes.annotate("", 3.1 * towards, 2.6 * towards, arrowprops={"arrowstyle": "-|>", "color": BLUE})
    axes.text(*(2.55 * towards), "to the goal", color=BLUE, fontsize=9, ha="right", va="center")
    _mark_distance(axes, record, along)
    axes.set_aspect("equal")
    axes.set_xlim(-0.55, 3.25)
    axes.set_ylim(-1.75, 1.75)
    label(axes, "ahead [m]", "left [m]")


def _mark_distance(axes: Any, record: dict[str, Any], along: Any) -> None:
    """Name the free length d_c of one arc that hits, as the figure of the paper does."""
    low, high, _ = record["tangents"][1]
    curvature = (low + high) / 2
    hit = next(
        one for one in record["intervals"]
        if one["curvature_lo"] <= curvature <= one["curvature_hi"]
    )  # fmt: skip
    points = along(curvature, np.linspace(0, hit["distance_m"], 60))
    axes.plot(*points.T, color=RED, lw=2.0, zorder=4)
    axes.plot(*points[-1], "o", color=RED, ms=6, zorder=5)
    axes.annotate("$d_c$", points[42], xytext=(-14, -9), textcoords="offset points", color=RED,
                  fontsize=13)  # fmt: skip


def _draw_lengths(axes: Any, record: dict[str, Any]) -> None:
    lows = [one["curvature_lo"] for one in record["intervals"]]
    edges = [*lows, record["intervals"][-1]["curvature_hi"]]
    free = [one["distance_m"] for one in record["intervals"]]
    axes.stairs(free, edges, fill=True, color=TEAL, alpha=0.18)
    axes.stairs(free, edges, color=TEAL, lw=1.6, label="D of every interval, exact")
    for number, (low, high, estimate) in enumerate(record["tangents"]):
        name = "one obstacle as published: between its tangents" if number == 0 else None
        axes.plot([low, low, high, high], [3.25, estimate, estimate, 3.25], color=RED, lw=1.1,
                  ls=(0, (4, 2)), label=name)  # fmt: skip
    best = [
        c for c in record["candidates"] if c["refused"] is None and c["twist"]["linear_mps"] > 0
    ]
    curvatures = [c["twist"]["angular_radps"] / c["twist"]["linear_mps"] for c in best]
    beside = axes.twinx()
    beside.plot(curvatures, [c["total"] for c in best], ".", color=BLUE, ms=5)
    beside.set_ylim(0, 1.05)
    beside.set_ylabel("score of a candidate by (7), dots", color=BLUE, fontsize=9)
    beside.tick_params(colors=BLUE, labelsize=8.5)
    beside.spines[["top", "left"]].set_visible(False)
    axes.set_ylim(0, 3.3)
    axes.set_xlim(-1.6, 1.2)
    label(axes, "curvature rv/tv [1/m], left positive", "free length D [m]")
