"""What `cairn reproduce` can do, by name: a study is measured, drawn and told as tables.

A new one is a `Reproduction` in `ALL`; what it needs is imported when it runs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class TableOf:
    """A table to print: a title, column names, and rows of text."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]]


@dataclass(frozen=True)
class Reproduction:
    """A figure or study of the paper, or one it leaves to be done.

    Args:
        title: what it shows, in a line.
        steps: how often `measure` calls what it is given.
        measure: (seed, advance) → the record, with a top-level `summary`.
        draw: (record, folder) → the pictures drawn.
        tables: record → what to print.
    """

    title: str
    steps: Callable[[], int]
    measure: Callable[[int, Callable[[str], None]], dict[str, Any]]
    draw: Callable[[dict[str, Any], Path], list[Path]]
    tables: Callable[[dict[str, Any]], list[TableOf]]


def _parallel() -> Reproduction:
    from cairn.experiments import parallel

    def draw(record: dict[str, Any], folder: Path) -> list[Path]:
        from cairn.view.schedules import draw_schedules

        return [draw_schedules(record, parallel.BUSY_ON, folder / "parallel.png")]

    return Reproduction(
        "parallel schedules of the layered planner [Maalouf06 §3.3]: work, bounds, speed-up",
        parallel.steps,
        lambda seed, advance: parallel.measure(seed=seed, advance=advance),
        draw,
        _parallel_tables,
    )


def _parallel_tables(record: dict[str, Any]) -> list[TableOf]:
    work, speed = [], []
    for study in record["studies"]:
        names = (study["profile"], study["engine"].replace("_", " "))
        work.append(
            (
                *names,
                f"{study['layers']} × {study['widest_layer']}",
                f"{study['levels']} of {study['levels_bound']}",
                f"{study['operations']} of {study['operations_bound']}",
                f"{study['operations_equation_4']} of {study['operations_bound_equation_4']}",
                f"{study['tasks']}",
                f"{study['task_us']:.1f} + {study['hand_out_us']:.1f} µs",
                f"{study['one_thread_ms']:.1f} ms",
            )
        )
        for name, plan in study["schedules"].items():
            label = {"fronts": "(a) fronts", "wavefront": "(b) wavefront"}[name]
            measured = [
                f"{value:.2f}" for count, value in plan["measured"].items() if int(count) > 1
            ]
            played = [f"{value:.1f}" for count, value in plan["played"].items() if int(count) > 1]
            speed.append((*names, label, *measured, *played))
    plan = record["studies"][0]["schedules"]["fronts"]
    threads = [f"{count} threads" for count in plan["measured"] if int(count) > 1]
    workers = [f"{count}" for count in plan["played"] if int(count) > 1]
    return [
        TableOf(
            "work done, of the bound",
            (
                "profile", "engine", "K × M", "levels, of K·M", "operations, of worst case",
                "equation (4)", "tasks", "a task + its hand-out", "one thread",
            ),
            work,
        ),
        TableOf(
            "speed-up: measured on threads, then played out on workers",
            ("profile", "engine", "schedule", *threads, *workers),
            speed,
        ),
    ]  # fmt: skip


def _surfaces() -> Reproduction:
    from cairn.experiments import track_surface

    def draw(record: dict[str, Any], folder: Path) -> list[Path]:
        from cairn.view.tracks import draw_surfaces

        return [draw_surfaces(record, folder / "fig9.png")]

    def measure(seed: int, advance: Callable[[str], None]) -> dict[str, Any]:
        advance("surfaces")
        return track_surface.measure()

    def tables(record: dict[str, Any]) -> list[TableOf]:
        rows = [
            (name, *(f"{told[key]:.2f}" for key in told))
            for name, told in record["summary"].items()
        ]
        columns = ("surface at C = 0", "least", "greatest", "steepest per m", "per rad")
        return [TableOf("the tracker's surfaces", columns, rows)]

    title = "surfaces of the path tracker over dR and dθ [Maalouf06 Fig. 9]"
    return Reproduction(title, lambda: 1, measure, draw, tables)


def _tracked(figure: int, name: str) -> Reproduction:
    from cairn.experiments import track
    from cairn.experiments.track_paths import PATHS

    def measure(seed: int, advance: Callable[[str], None]) -> dict[str, Any]:
        return track.compare(PATHS[name](), track.Setting(seed=seed), advance)

    def draw(record: dict[str, Any], folder: Path) -> list[Path]:
        from cairn.view.tracks import draw_comparison

        return [draw_comparison(record, folder / f"fig{figure}.png")]

    def tables(record: dict[str, Any]) -> list[TableOf]:
        told = record["summary"]
        best = told["best_baseline"]
        rows = [
            (who, *("–" if v is None else f"{100 * v:.2f} cm" for v in values), f"{time:.1f} s")
            for who, values, time in (
                ("fuzzy tracker", [told["ours"][k] for k in _ERRORS], told["ours"]["time_s"]),
                (f"{best['kind']}, {best['lookahead_m']} m", [best[k] for k in _ERRORS],
                 best["time_s"]),
            )
        ]  # fmt: skip
        columns = ("tracker", "RMS", "most", "overshoot", "RMS after the turn", "time")
        return [TableOf(f"{name} at {told['cruise_mps']} m/s", columns, rows)]

    title = f"the {name} driven by the fuzzy tracker and by pure pursuit [Maalouf06 Fig. {figure}]"
    steps = 1 + len(track.BASELINES) * len(track.LOOKAHEADS_M)
    return Reproduction(title, lambda: steps, measure, draw, tables)


_ERRORS = ("rms_m", "max_m", "overshoot_m", "after_turn_rms_m")

ALL: dict[str, Callable[[], Reproduction]] = {
    "fig9": _surfaces,
    "fig14": lambda: _tracked(14, "sine"),
    "fig15": lambda: _tracked(15, "step"),
    "fig16": lambda: _tracked(16, "ramp"),
    "parallel": _parallel,
}
