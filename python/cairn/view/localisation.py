"""A picture of a robot that is carried away and finds itself again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from cairn.localisation import Localiser
from cairn.view.style import FREE, INK, OCCUPIED, PALE, UNKNOWN

if TYPE_CHECKING:
    from cairn.experiments.streams import Stream
    from cairn.profile import Profile
    from cairn.world import World

TRUTH, ESTIMATE, POSES = "#0b7a75", "#d1495b", "#3066be"
TICK_S = 0.1
DPI = 130


def draw_kidnapping(
    world: World, profile: Profile, stream: Stream, carried_at: int, *, path: Path
) -> Path:
    """Play a drive to a localiser and draw four moments of it and its course.

    Args:
        world: the map.
        profile: whose ranges they are.
        stream: the drive.
        carried_at: the tick at which the robot was carried away.
        path: of the PNG file.
    """
    localiser = Localiser(world, profile, start=stream.truth[0])
    shots: dict[str, tuple[int, Any, Any]] = {}
    rows = []
    for tick in range(len(stream)):
        was_found = localiser.is_found
        report = localiser.step(
            stream.ranges_m[tick],
            tuple(stream.wheels_m[tick]),
            float(stream.gyro_radps[tick]),
            TICK_S,
        )
        where = localiser.particles[0]
        x, y, _ = localiser.pose
        away_m = float(np.hypot(x - stream.truth[tick, 0], y - stream.truth[tick, 1]))
        rows.append((tick * TICK_S, report.fit, report.candidate_fit, away_m, report.is_found))
        if tick == carried_at - 1:
            shots["tracking, just before it is carried away"] = (tick, where, localiser.pose)
        elif was_found and not report.is_found and len(shots) == 1:
            shots["lost: the whole map is searched"] = (tick, where, localiser.pose)
            lost_at = tick
        elif len(shots) == 2 and len(where) and tick > lost_at + 8 and not report.is_found:
            shots["poses that agree with what was heard since"] = (tick, where, localiser.pose)
        elif not was_found and report.is_found and len(shots) > 1:
            shots["found"] = (tick, where, localiser.pose)
            break
    figure = Figure(figsize=(13, 11.5))
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(3, 2, height_ratios=[1, 1, 0.5], hspace=0.16, wspace=0.04)
    for k, (title, (tick, where, pose)) in enumerate(shots.items()):
        axes = figure.add_subplot(grid[k // 2, k % 2])
        _map(axes, world)
        axes.plot(where[:, 0], where[:, 1], ".", ms=2.2, color=POSES, alpha=0.35, zorder=2)
        begin = carried_at if tick >= carried_at else 0
        axes.plot(*stream.truth[begin : tick + 1, :2].T, color=TRUTH, lw=2, zorder=3)
        _arrow(axes, stream.truth[tick], TRUTH)
        _arrow(axes, pose, ESTIMATE)
        axes.set_title(f"{tick * TICK_S:.1f} s: {title}", loc="left", color=INK, fontsize=11)
    times, fits, candidates, away, found = map(np.array, zip(*rows, strict=True))
    axes = figure.add_subplot(grid[2, :])
    axes.plot(times, fits, color=ESTIMATE, label="explained at the pose")
    axes.plot(times, candidates, color=POSES, label="explained at the heaviest of the poses")
    axes.plot(times, np.minimum(away, 1.0), color=INK, lw=1, label="off by truth, at most 1 [m]")
    axes.fill_between(times, 0, 1, where=~found.astype(bool), color=PALE, alpha=0.25, lw=0)
    axes.axvline(carried_at * TICK_S, color=INK, lw=0.8, ls="--")
    axes.set_xlabel("time [s]; shaded: not vouched for; dashed: carried away", color=INK)
    axes.set_ylim(0, 1.05)
    axes.legend(loc="lower left", frameon=False, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(
        handles=[
            Line2D([], [], color=TRUTH, lw=2, label="truth"),
            Line2D([], [], color=ESTIMATE, lw=2, label="the pose it gives"),
            Line2D([], [], color=POSES, marker=".", lw=0, label="set of poses"),
        ],
        loc="upper center", ncols=3, frameon=False, bbox_to_anchor=(0.5, 0.935),
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI, bbox_inches="tight")
    return path


def _map(axes: Any, world: World) -> None:
    x_lo, x_hi, y_lo, y_hi = world.extent
    axes.imshow(
        world.occupancy,
        origin="lower",
        extent=(x_lo, x_hi, y_lo, y_hi),
        cmap=ListedColormap([FREE, OCCUPIED, UNKNOWN]),
        vmin=0,
        vmax=2,
        interpolation="nearest",
    )
    axes.set_aspect("equal")
    axes.set_axis_off()


def _arrow(axes: Any, pose: Any, color: str) -> None:
    x, y, heading = (float(v) for v in pose)
    axes.plot(x, y, "o", ms=9, mfc="none", mec=color, mew=2, zorder=4)
    axes.annotate(
        "",
        (x + 1.2 * np.cos(heading), y + 1.2 * np.sin(heading)),
        (x, y),
        arrowprops={"arrowstyle": "-|>", "color": color, "lw": 2},
        zorder=4,
    )
