"""Pictures of trials of the navigation benchmark."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from cairn.profile import Profile
from cairn.view.picture import BOX
from cairn.view.style import INK, OCCUPIED, PALE

if TYPE_CHECKING:
    from cairn.experiments.nav.trial import Trial
    from cairn.experiments.nav.worlds import NavWorld

OUTLINE_EVERY_M = 0.8
MARGIN_M = 1.0
DPI = 150


def draw_trial(trial: Trial, world: NavWorld, robot: str, stack: str, path: Path) -> Path:
    """Draw the world, the way driven by truth coloured by speed, and how it ended.

    Args:
        trial: driven with `trace=True`.
        world: as it was driven through.
        robot: name of the robot's profile.
        stack: its name, for the title.
        path: the picture to write, .png, .svg or .pdf.

    Returns:
        `path`.
    """
    assert trial.trace is not None
    profile = Profile.load(robot)
    truth = np.asarray(trial.trace.truth)
    moving = trial.trace.moving
    points = np.vstack(
        [truth[:, :2], [world.goal], [world.start[:2]], world.circles[:, :2], *_ends(world)]
    )
    low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    size = high - low
    height = 9.0
    width = float(np.clip(height * size[0] / size[1], 4.0, 14.0))
    figure = Figure(figsize=(width + 1.2, height), dpi=DPI)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    posts = [Circle((x, y), r) for x, y, r in world.circles]
    axes.add_collection(PatchCollection(posts, facecolor=OCCUPIED, edgecolor="none"))
    for x, y, heading, length, breadth in world.boxes:
        axes.add_patch(Polygon(_outline((x, y, heading), length, breadth), color=OCCUPIED))
    for x, y, r in moving if moving is not None else ():
        axes.add_patch(Circle((x, y), r, facecolor="#f6e3c4", edgecolor=BOX, hatch="////"))
    if len(world.reference_path):
        axes.plot(*world.reference_path.T, color=PALE, lw=0.8, ls=":", label="a way known to exist")
    if trial.trace.path is not None:
        axes.plot(*_from_odometry(trial, world).T, color="#c8862b", lw=1.0, label="last plan")
    axes.add_patch(Circle(world.goal, world.goal_tolerance_m, color="#0b7a75", alpha=0.15, lw=0))
    axes.plot(*world.goal, marker="+", color="#0b7a75", ms=10, ls="none", label="goal")
    speeds = np.hypot(*np.diff(truth[:, :2], axis=0).T) / np.maximum(
        np.diff(trial.trace.time_s), 1e-9
    )
    pieces = LineCollection(
        list(np.stack([truth[:-1, :2], truth[1:, :2]], axis=1)),
        cmap="viridis",
        array=speeds,
        lw=2.0,
    )
    pieces.set_clim(0.0, profile.limits.linear_mps)
    axes.add_collection(pieces)
    figure.colorbar(pieces, ax=axes, label="speed [m/s]", fraction=0.04, pad=0.02)
    box = profile.footprint
    driven = 0.0
    for at, gone in zip(truth, np.append(0.0, speeds * np.diff(trial.trace.time_s)), strict=True):
        driven += gone
        if driven >= OUTLINE_EVERY_M or at is truth[0]:
            driven = 0.0
            corners = _outline(at, box.length_m, box.width_m)
            axes.add_patch(Polygon(corners, fill=False, edgecolor=PALE, lw=0.6))
    good = trial.outcome == "success"
    corners = _outline(truth[-1], box.length_m, box.width_m)
    colour = "#0b7a75" if good else "#d1495b"
    axes.add_patch(Polygon(corners, fill=False, edgecolor=colour, lw=2.0))
    axes.set_title(
        f"{stack} in {world.name}, trial {trial.trial}: {trial.outcome} ({trial.reason})\n"
        f"{trial.time_s:.1f} s, score {trial.score:.4f}",
        fontsize=10,
        color=INK,
    )
    axes.legend(loc="lower left", fontsize=8, framealpha=0.9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, bbox_inches="tight")
    return path


def _ends(world: NavWorld) -> list[np.ndarray]:
    return [_outline(tuple(box[:3]), box[3], box[4]) for box in world.boxes]


def _outline(pose: tuple[float, ...] | np.ndarray, length: float, width: float) -> np.ndarray:
    x, y, heading = pose
    c, s = math.cos(heading), math.sin(heading)
    u = np.array([0.5, -0.5, -0.5, 0.5]) * length
    v = np.array([0.5, 0.5, -0.5, -0.5]) * width
    return np.column_stack([x + c * u - s * v, y + s * u + c * v])


def _from_odometry(trial: Trial, world: NavWorld) -> np.ndarray:
    """The stack's path laid into the world at the robot's last pose, as the robot has it."""
    trace = trial.trace
    assert trace is not None
    assert trace.path is not None
    ox, oy, odometry_heading = trace.odometry[-1]
    x, y, heading = trace.truth[len(trace.odometry) - 1]
    c, s = math.cos(heading - odometry_heading), math.sin(heading - odometry_heading)
    dx, dy = trace.path[:, 0] - ox, trace.path[:, 1] - oy
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy])
