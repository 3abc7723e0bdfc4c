"""The picture of the parallel study: speed-up against workers, and how many work when."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from cairn.view.style import DPI, INK, PALE

COLOURS = {"fronts": "#c8862b", "wavefront": "#0b7a75"}
NAMES = {"fronts": "(a) fronts", "wavefront": "(b) wavefront"}
ENGINES: dict[str, tuple[Any, str, str]] = {
    "levelled": ("-", "o", "levelled"),
    "in_place": ("--", "s", "in place"),
}


def draw_schedules(record: dict[str, Any], workers: int, path: Path) -> Path:
    """Draw the record of `cairn.experiments.parallel.measure` as PNG.

    Args:
        record: what `measure` returned.
        workers: how many the lower row shows at work.
        path: the file; its folder is made if need be.
    """
    profiles = list(dict.fromkeys(study["profile"] for study in record["studies"]))
    figure = Figure(figsize=(12.0, 7.4), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(profiles), sharey="row", gridspec_kw={"height_ratios": [3, 2]})
    for column, profile in enumerate(profiles):
        studies = [study for study in record["studies"] if study["profile"] == profile]
        upper, lower = axes[0][column], axes[1][column]
        _speed_up(upper, studies)
        _at_work(lower, studies, workers)
        first = studies[0]
        upper.set_title(
            f"{profile}: {first['layers']} layers of {first['widest_layer']}",
            loc="left", color=INK, fontweight="bold", fontsize=11,
        )  # fmt: skip
        upper.set_xlabel("workers")
        lower.set_xlabel("share of the time taken")
        for axis in (upper, lower):
            axis.spines[["top", "right"]].set_visible(False)
            axis.tick_params(colors=INK, labelsize=9)
            axis.grid(color=PALE, alpha=0.25, linewidth=0.6)
    axes[0][0].set_ylabel("speed-up over one worker")
    axes[1][0].set_ylabel(f"of {workers} workers, at work")
    figure.legend(handles=_legend(), loc="outside lower center", ncols=6, frameon=False, fontsize=9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


def _speed_up(axis: Any, studies: list[dict[str, Any]]) -> None:
    most = 1
    for study in studies:
        line, marker, _ = ENGINES[study["engine"]]
        for name, plan in study["schedules"].items():
            played = {int(workers): value for workers, value in plan["played"].items()}
            most = max(most, *played)
            axis.plot(list(played), list(played.values()), line, color=COLOURS[name], linewidth=1.8)
            measured = {int(n): value for n, value in plan["measured"].items() if int(n) > 1}
            axis.plot(
                list(measured), list(measured.values()), marker, color=COLOURS[name],
                markerfacecolor="white", markersize=6,
            )  # fmt: skip
    ideal = 2.0 ** np.arange(0, np.log2(most) + 1)
    axis.plot(ideal, ideal, ":", color=PALE, linewidth=1.2, zorder=0)
    axis.set_xscale("log", base=2)
    axis.set_yscale("log", base=2)
    axis.set_xticks(ideal, [f"{workers:.0f}" for workers in ideal])
    axis.set_yticks(ideal, [f"{workers:.0f}" for workers in ideal])
    axis.minorticks_off()
    axis.set_ylim(0.5, most * 1.1)


def _at_work(axis: Any, studies: list[dict[str, Any]], workers: int) -> None:
    for study in studies:
        line, _, _ = ENGINES[study["engine"]]
        for name, plan in study["schedules"].items():
            busy = np.array(plan["busy"])
            share = (np.arange(len(busy)) + 0.5) / len(busy)
            axis.plot(share, busy, line, color=COLOURS[name], linewidth=1.2)
    axis.set_xlim(0, 1)
    axis.set_ylim(0, workers * 1.05)


def _legend() -> list[Line2D]:
    schedules = [Line2D([], [], color=COLOURS[name], label=NAMES[name]) for name in COLOURS]
    engines = [
        Line2D([], [], color=INK, linestyle=line, label=name) for line, _, name in ENGINES.values()
    ]
    measured = Line2D(
        [], [], color=INK, linestyle="", marker="o", markerfacecolor="white",
        label="measured on the cores there are (□ in place)",
    )  # fmt: skip
    return [
        *schedules,
        *engines,
        measured,
        Line2D([], [], color=PALE, linestyle=":", label="ideal"),
    ]
