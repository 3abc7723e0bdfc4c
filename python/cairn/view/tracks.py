"""Pictures of `cairn track`: where each tracker drove, how far off the path, and how it steered."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from cairn.tracking import deviations
from cairn.view.style import DPI, INK, PALE

OURS, OTHER, WAY = "#0b7a75", "#c8862b", "#b9bec6"


def draw_comparison(record: dict[str, Any], path: Path) -> Path:
    """Draw the record of `cairn.experiments.track.compare` as PNG."""
    summary = record["summary"]
    best = summary["best_baseline"]
    names = {
        "ours": ("fuzzy tracker", OURS),
        "best": (f"{best['kind']}, L = {best['lookahead_m']} m", OTHER),
    }
    reference = np.asarray(record["reference_m"])
    figure, axes = _figure(
        [["path", "off"], ["path", "speed"], ["sweep", "turn"]], (12.5, 8.2), (4, 5), (3, 2.2, 3)
    )
    _way(axes["path"], reference)
    for key, (label, colour) in names.items():
        poses, times = np.asarray(record[key]["poses"]), np.asarray(record[key]["times_s"])
        twists = np.asarray(record[key]["twists"])
        left_m, along_m = deviations(reference, poses[:, :2])
        axes["path"].plot(*poses[:, :2].T, color=colour, linewidth=1.4, label=label)
        axes["off"].plot(along_m, 100 * left_m, color=colour, linewidth=1.3)
        axes["speed"].plot(times, twists[:, 0], color=colour, linewidth=1.2)
        axes["turn"].plot(times, twists[:, 1], color=colour, linewidth=1.2)
    axes["path"].legend(
        loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False, fontsize=8.5
    )
    _label(axes["off"], "along the path [m]", "off it, left [cm]")
    _label(axes["speed"], "", "V [m/s]")
    _label(axes["turn"], "time [s]", "ω [rad/s]")
    _look_aheads(axes["sweep"], record)
    ours, (key, kind) = summary["ours"], _judged_by(summary)
    rivals = [entry for entry in record["baselines"] if entry["measures"]["reached"]]
    rival = min((entry["measures"] for entry in rivals or [{"measures": best}]), key=_worth(key))
    figure.suptitle(
        f"{summary['path']} at {summary['cruise_mps']} m/s, {summary['robot']} P3-AT, "
        f"waypoints {summary['spacing_m']} m apart: {kind} {_cm(ours[key])} in "
        f"{ours['time_s']:.1f} s, best baseline {_cm(rival[key])} in {rival['time_s']:.1f} s",
        x=0.01, ha="left", color=INK, fontweight="bold", fontsize=11,
    )  # fmt: skip
    return _saved(figure, path)


def draw_sweep(record: dict[str, Any], path: Path) -> Path:
    """Draw the record of `cairn.experiments.track.sweep` as PNG."""
    summary = record["summary"]
    spacings = summary["spacings_m"]
    figure, axes = _figure([["rms", "time"]], (11.0, 4.2))
    for (speed, told), colour in zip(
        summary["by_speed"].items(), ("#7c5cbf", OURS, OTHER), strict=True
    ):
        label = f"at most {speed} m/s"
        axes["rms"].plot(spacings, 100 * _floats(told["rms_m"]), "o-", color=colour, label=label)
        axes["time"].plot(spacings, _floats(told["time_s"]), "o-", color=colour)
    axes["rms"].legend(frameon=False, fontsize=9)
    _label(axes["rms"], "waypoints apart [m]", "RMS error [cm]")
    _label(axes["time"], "waypoints apart [m]", "time [s]")
    for axis in axes.values():
        axis.set_ylim(bottom=0)
    figure.suptitle(
        f"{summary['path']}: close together is precise and slow, far apart is fast",
        x=0.01, ha="left", color=INK, fontweight="bold", fontsize=11,
    )  # fmt: skip
    return _saved(figure, path)


def draw_swap(record: dict[str, Any], path: Path) -> Path:
    """Draw the record of `cairn.experiments.track.swap` as PNG."""
    figure, axes = _figure([["path", "speed"], ["path", "turn"]], (12.0, 5.2), (1, 1))
    for way in record["paths_m"]:
        _way(axes["path"], np.asarray(way))
    ours = record["ours"]
    axes["path"].plot(*np.asarray(ours["poses"])[:, :2].T, color=OURS, linewidth=1.4)
    times, commands = np.asarray(ours["times_s"]), np.asarray(ours["commands"])
    axes["speed"].plot(times, commands[:, 0], color=OURS, linewidth=1.2)
    axes["turn"].plot(times, commands[:, 1], color=OURS, linewidth=1.2)
    for piece in record["summary"]["pieces"][1:]:
        for key in ("speed", "turn"):
            axes[key].axvline(piece["from_s"], color=OTHER, linewidth=1.0, linestyle="--")
    _label(axes["speed"], "", "V commanded [m/s]")
    _label(axes["turn"], "time [s]", "ω commanded [rad/s]")
    figure.suptitle(
        "paths exchanged while driving (dashed: when)",
        x=0.01, ha="left", color=INK, fontweight="bold", fontsize=11,
    )  # fmt: skip
    return _saved(figure, path)


def draw_surfaces(record: dict[str, Any], path: Path) -> Path:
    """Draw the record of `cairn.experiments.track_surface.measure` as PNG, after Fig. 9."""
    figure = Figure(figsize=(11.5, 8.6), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    bearings, distances = np.meshgrid(record["bearings_rad"], record["distances_m"])
    place = 0
    for name, said in (("standing", "Vc = 0"), ("cruising", "Vc = 0.5 m/s")):
        for output, unit in (("V", "m/s"), ("omega", "rad/s")):
            place += 1
            axis: Any = figure.add_subplot(2, 2, place, projection="3d")
            values = np.asarray(record["surfaces"][name][output])
            axis.plot_surface(
                distances, bearings, values, cmap="viridis", rcount=61, ccount=61,
                linewidth=0.15, edgecolor=(1, 1, 1, 0.25),
            )  # fmt: skip
            axis.view_init(elev=32, azim=-128)
            axis.set_xlabel("dR [m]", fontsize=8, color=INK)
            axis.set_ylabel("dθ [rad]", fontsize=8, color=INK)
            axis.tick_params(labelsize=7, colors=INK)
            symbol = "ω" if output == "omega" else output
            axis.set_title(f"{symbol} [{unit}] at C = 0, {said}", fontsize=10, color=INK)
    return _saved(figure, path)


def _figure(
    mosaic: list[list[str]],
    size: tuple[float, float],
    widths: tuple[float, ...] | None = None,
    heights: tuple[float, ...] | None = None,
) -> tuple[Figure, dict[str, Any]]:
    figure = Figure(figsize=size, dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic(mosaic, width_ratios=widths, height_ratios=heights)  # type: ignore[arg-type]
    for axis in axes.values():
        axis.spines[["top", "right"]].set_visible(False)
        axis.tick_params(colors=INK, labelsize=9)
        axis.grid(color=PALE, alpha=0.25, linewidth=0.6)
    return figure, axes


def _way(axis: Any, way: np.ndarray[Any, Any]) -> None:
    axis.plot(*way.T, color=WAY, linewidth=4.0, solid_capstyle="round", zorder=0)
    axis.set_aspect("equal", adjustable="datalim")
    _label(axis, "x [m]", "y [m]")


def _judged_by(summary: dict[str, Any]) -> tuple[str, str]:
    """The measure that says most of a drive, and its name."""
    if not summary["joins"]:
        return "rms_m", "RMS error"
    if summary["ours"]["overshoot_m"] is None:
        return "after_turn_rms_m", "RMS error after the turn"
    return "overshoot_m", "overshoot"


def _worth(key: str) -> Callable[[dict[str, Any]], float]:
    return lambda told: math.inf if told[key] is None else told[key]


def _look_aheads(axis: Any, record: dict[str, Any]) -> None:
    key, name = _judged_by(record["summary"])
    for kind, (line, marker) in zip(
        dict.fromkeys(entry["kind"] for entry in record["baselines"]),
        (("-", "o"), ("--", "s")),
        strict=True,
    ):
        swept = [entry for entry in record["baselines"] if entry["kind"] == kind]
        good = [entry for entry in swept if entry["measures"]["reached"]]
        axis.plot(
            [entry["lookahead_m"] for entry in good],
            [100 * _worth(key)(entry["measures"]) for entry in good],
            line, marker=marker, color=OTHER, markersize=4, linewidth=1.2, label=kind,
        )  # fmt: skip
    ours = 100 * record["summary"]["ours"][key]
    axis.axhline(ours, color=OURS, linewidth=1.6, label="fuzzy tracker")
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.legend(frameon=False, fontsize=8)
    _label(axis, "look-ahead of the baselines [m]", f"{name} [cm]")


def _label(axis: Any, x: str, y: str) -> None:
    axis.set_xlabel(x, color=INK, fontsize=9)
    axis.set_ylabel(y, color=INK, fontsize=9)


def _floats(values: list[float | None]) -> np.ndarray[Any, Any]:
    return np.array([np.nan if value is None else value for value in values], float)


def _cm(metres: float) -> str:
    return f"{100 * metres:.2f} cm"


def _saved(figure: Figure, path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path
