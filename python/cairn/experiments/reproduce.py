"""What `cairn reproduce` can do, by name: a study is measured, drawn and told as tables.

A new one is a `Reproduction` in `ALL`; what it needs is imported when it runs.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cairn.experiments.reproduction import Caption, Reproduction, TableOf


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
        _parallel_caption,
    )


def _parallel_caption(record: dict[str, Any]) -> Caption:
    profiles = ", ".join(dict.fromkeys(study["profile"] for study in record["studies"]))
    same = record["summary"]["same_bits_as_serial"]
    return Caption(
        "[Maalouf06 §3.3]: when DP operations may run at the same time; the study itself is "
        "named as "
        "future work.",
        f"graphs of {profiles} layers of our own, on the cores of this machine, and played out "
        "on 1 "
        "to 64 workers with the durations measured on one: docs/parallel.md.",
        ("the parallel schedules give the serial bits",) if same else (),
        (
            "in place, schedule (a) as printed is a race: ours runs fronts that are independent",
            *(() if same else ("THE BITS DIFFER FROM THE SERIAL RUN",)),
        ),
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
    return Reproduction(title, lambda: 1, measure, draw, tables, _surfaces_caption)


def _surfaces_caption(record: dict[str, Any]) -> Caption:
    told = record["summary"]["V_standing"]
    speeds = np.asarray(record["surfaces"]["standing"]["V"])
    farthest, ahead = speeds[-1], speeds[:, speeds.shape[1] // 2]
    half = len(farthest) // 2
    falls = bool((np.diff(farthest[half:]) <= 1e-9).all() and (np.diff(ahead) >= -1e-9).all())
    return Caption(
        "[Maalouf06 Fig. 9]: V over dR and dθ where C and Vc are zero.",
        "the controller shipped for the P3-AT (python/cairn/data/controllers/p3at.toml), sampled "
        f"{len(record['distances_m'])} × {len(record['bearings_rad'])}; ω and Vc = 0.5 m/s "
        "beside it.",
        (
            *(
                ("V never rises with the error of bearing, nor falls with distance",)
                if falls
                else ()
            ),
            f"outputs vary smoothly: V by at most {told['steepest_per_m']:.1f} m/s per metre and "
            f"{told['steepest_per_rad']:.1f} m/s per radian",
        ),
        (
            f"V is from {told['least']:.2f} to {told['greatest']:.2f} m/s, by rules of our own: "
            "the "
            "paper's text holds no number of its surface",
        ),
    )


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
    return Reproduction(
        title, lambda: steps, measure, draw, tables, lambda record: _tracked_caption(figure, record)
    )


TRACKED = {
    14: "a sine wave, the robot at the origin with heading 0",
    15: "the unit step: the response to a lateral discontinuity",
    16: "a ramp at 135°: the response to a discontinuity in heading",
}


def _tracked_caption(figure: int, record: dict[str, Any]) -> Caption:
    told, best = record["summary"], record["summary"]["best_baseline"]
    ours = told["ours"]
    agrees = ["the robot starts at the origin with heading 0, follows the path and arrives"]
    if figure == 15:
        agrees.append("it returns to the path after the lateral step: robust, as the paper says")
    if figure == 16:
        agrees.append("it turns into the ramp from heading 0: robust, as the paper says")
    return Caption(
        f"[Maalouf06 Fig. {figure}, §7]: {TRACKED[figure]}, driven by the fuzzy tracker on the "
        "P3-AT.",
        f"the {told['robot']} P3-AT at {told['cruise_mps']} m/s, waypoints {told['spacing_m']} m "
        "apart, "
        "pose known, loop and latency of 0.1 s; beside it the best of pure pursuit and regulated "
        "pure "
        "pursuit with look-aheads of 0.3 to 1.0 m.",
        tuple(agrees) if ours["reached"] else (),
        (
            "a simulated robot, not the one in the laboratory, and its pose is known",
            "the paper states no error, speed or spacing to compare with: "
            f"ours is off by {100 * ours['rms_m']:.2f} cm RMS in {ours['time_s']:.1f} s, "
            f"{best['kind']} by {100 * best['rms_m']:.2f} cm in {best['time_s']:.1f} s",
            *(() if ours["reached"] else ("THE GOAL WAS NOT REACHED",)),
        ),
    )


_ERRORS = ("rms_m", "max_m", "overshoot_m", "after_turn_rms_m")


def _paper(name: str, *of: int) -> Callable[[], Reproduction]:
    def made() -> Reproduction:
        from cairn.experiments.paper import reproductions

        return getattr(reproductions, name)(*of)

    return made


ALL: dict[str, Callable[[], Reproduction]] = {
    "eq4": _paper("equation_4"),
    "fig3": _paper("solution_graph", 3),
    "fig4": _paper("solution_graph", 4),
    "fig5": _paper("parameters"),
    "fig7": _paper("memberships", 7),
    "table1": _paper("table_1"),
    "fig8": _paper("memberships", 8),
    "fig9": _surfaces,
    "fig10": _paper("free_arcs"),
    "fig11": _paper("state_machine"),
    "fig12": _paper("three_cases"),
    "fig14": lambda: _tracked(14, "sine"),
    "fig15": lambda: _tracked(15, "step"),
    "fig16": lambda: _tracked(16, "ramp"),
    "parallel": _parallel,
}

NOT_MADE = {
    "fig1": "defines x, y and θ in a drawing; there is nothing to compute",
    "fig2": "defines the vector link in a drawing; `fig4` draws real ones",
    "fig6": "a block diagram of the two fuzzy modules; `fig7` and `fig8` draw what is in them",
    "fig13": "a photograph of the robot in the laboratory",
}
