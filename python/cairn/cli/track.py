"""`cairn track` and `cairn tune`: how well paths are followed, and a search for better."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from cairn.cli.progress import bar
from cairn.cli.root import app, console, print_json, ready
from cairn.missions.result import EXIT_NOT_REACHED
from cairn.record import write_summary
from cairn.strict_json import plain

PATHS = ("sine", "step", "ramp", "squares", "stairs", "eights", "office")
ROBOTS = ("kinematic", "mujoco")


@app.command("track")
def track_command(
    path: Annotated[str, typer.Argument(metavar="PATH", help=f"{', '.join(PATHS)}, swap, or all.")],
    robot: Annotated[str, typer.Option(help="kinematic or mujoco.")] = "kinematic",
    speed: Annotated[float, typer.Option(min=0.05, help="Greatest speed in m/s.")] = 0.5,
    spacing: Annotated[
        float, typer.Option(min=0.02, help="Distance between waypoints in metres.")
    ] = 0.2,
    under: Annotated[
        str, typer.Option(help="What disturbs: none, slip, carpet, latency, late or noise.")
    ] = "none",
    controller: Annotated[
        str, typer.Option(help="A .toml file, or the name of a shipped one.")
    ] = "p3at",
    sweep: Annotated[
        bool, typer.Option("--sweep", help="Every spacing and speed, without baselines.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder to write; by default runs/track-PATH.")
    ] = None,
    picture: Annotated[bool, typer.Option(help="Draw the drives into the folder.")] = True,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Follow a path with the fuzzy tracker, beside pure pursuit and regulated pure pursuit.

    Both baselines drive the same path with look-aheads from 0.3 to 1.0 m; the best one counts.
    Code 3 if the tracker does not reach the goal.
    """
    from cairn.experiments import track
    from cairn.experiments.track_paths import PATHS as KNOWN

    for option, value, known in (
        ("PATH", path, (*PATHS, "all", "swap")),
        ("--robot", robot, ROBOTS),
        ("--under", under, tuple(track.CONDITIONS)),
    ):
        if value not in known:
            raise typer.BadParameter(
                f"there is no `{value}`; there are: {', '.join(known)}", param_hint=option
            )
    setting = track.Setting(robot, speed, spacing, controller, under, seed)
    folder = ready(out or Path("runs") / f"track-{path}")
    names = PATHS if path == "all" else (path,)
    records: dict[str, dict[str, Any]] = {}
    written: list[Path] = []
    with bar() as progress:
        task = progress.add_task("", total=len(names) * track.steps(sweep=sweep))
        for name in names:

            def advance(what: str, name: str = name) -> None:
                progress.update(task, advance=1, description=f"{name}: {what}")

            if name == "swap":
                records[name] = plain(track.swap(setting))
            elif sweep:
                records[name] = plain(track.sweep(KNOWN[name](), setting, advance))
            else:
                records[name] = plain(track.compare(KNOWN[name](), setting, advance))
            if picture:
                written.append(_drawn(name, records[name], folder, sweep))
    record = records[path] if path != "all" else _joined(records)
    written.insert(0, write_summary(record, folder))
    if as_json:
        print_json(record)
    else:
        _print(records, sweep)
        console.print("[dim]" + "  ".join(map(str, written)) + "[/]")
    if not sweep and path != "swap":
        reached = all(each["summary"]["ours"]["reached"] for each in records.values())
        raise typer.Exit(0 if reached else EXIT_NOT_REACHED)


@app.command("tune")
def tune_command(
    out: Annotated[
        Path, typer.Argument(metavar="FILE", help="The controller file to write, as .toml.")
    ],
    evaluations: Annotated[int, typer.Option(min=1, help="Candidates to try.")] = 3000,
    seed: Annotated[
        int, typer.Option(min=1, help="Seed of the training paths and the search.")
    ] = 1,
    workers: Annotated[int, typer.Option(min=1, help="Processes to rehearse in.")] = 1,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Search for a better controller offline, on rehearsals of training paths drawn by seed."""
    from cairn.experiments import track_tuning
    from cairn.experiments.track_design import controller_text

    if out.is_dir():
        raise typer.BadParameter(f"{out} is a folder", param_hint="FILE")
    ready(out.parent)
    with bar() as progress:
        task = progress.add_task("tuning", total=evaluations)

        def advance(count: int, cost: float, _best: object) -> None:
            progress.update(task, completed=count, description=f"least cost {cost:.3f}")

        best, record = track_tuning.tune(
            seed=seed, evaluations=evaluations, workers=workers, advance=advance
        )
    out.write_text(controller_text(best), encoding="utf-8")
    summary = {key: record[key] for key in ("seed", "evaluations", "cost")}
    if as_json:
        whole = plain({"summary": summary, **record})
        print_json(whole)
    else:
        console.print(
            f"cost {record['history'][0][1]:.3f} → {record['cost']:.3f} after "
            f"{record['evaluations']} candidates, seed {seed}: {out}"
        )


def _drawn(name: str, record: dict[str, Any], folder: Path, sweep: bool) -> Path:
    from cairn.view import tracks

    if name == "swap":
        return tracks.draw_swap(record, folder / "swap.png")
    if sweep:
        return tracks.draw_sweep(record, folder / f"{name}-sweep.png")
    return tracks.draw_comparison(record, folder / f"{name}.png")


def _joined(records: dict[str, dict[str, Any]]) -> dict[str, Any]:
    summaries = {name: record["summary"] for name, record in records.items()}
    ahead = [name for name, told in summaries.items() if told.get("ahead")]
    return {
        "summary": {"paths": summaries, "ahead_on": len(ahead), "of": len(summaries)},
        "drives": records,
    }


def _print(records: dict[str, dict[str, Any]], sweep: bool) -> None:
    if "swap" in records:
        _print_swap(records["swap"]["summary"])
    elif sweep:
        for record in records.values():
            _print_sweep(record["summary"])
    else:
        _print_comparison(records)


def _print_comparison(records: dict[str, dict[str, Any]]) -> None:
    first = next(iter(records.values()))["summary"]
    console.print(
        f"{first['robot']} P3-AT at {first['cruise_mps']} m/s, waypoints {first['spacing_m']} m "
        f"apart; {first['conditions']}"
    )
    table = Table(
        "path", "tracker", "RMS", "in time", "most", "overshoot", "after turn", "time", "rests at",
        "∫|V̇|", "∫|ω̇|", "", box=None, pad_edge=False, header_style="dim",
    )  # fmt: skip
    for name, record in records.items():
        summary = record["summary"]
        best = summary["best_baseline"]
        verdict = "[bold green]ahead[/]" if summary["ahead"] else "[bold red]behind[/]"
        verdict += f" {summary['rms_ratio']:.2f} × RMS, {summary['time_ratio']:.2f} × time"
        table.add_row(f"[bold]{name}[/]", "fuzzy", *_row(summary["ours"]), verdict)
        short = "PP" if best["kind"] == "pure pursuit" else "RPP"
        table.add_row("", f"[dim]{short} {best['lookahead_m']} m[/]", *_row(best), "")
    console.print(table)


def _row(told: dict[str, Any]) -> list[str]:
    joins = told["overshoot_m"] is not None
    return [
        _cm(told["rms_m"]),
        _cm(told["rms_in_time_m"]),
        _cm(told["max_m"]),
        _cm(told["overshoot_m"]),
        "–" if joins else _cm(told["after_turn_rms_m"]),
        f"{told['time_s']:.1f} s" if told["reached"] else "[red]not reached[/]",
        _cm(told["arrival_error_m"]),
        f"{told['effort_v_mps']:.1f}",
        f"{told['effort_w_radps']:.1f}",
    ]


def _print_sweep(summary: dict[str, Any]) -> None:
    spacings = [f"{spacing} m" for spacing in summary["spacings_m"]]
    table = Table(
        f"{summary['path']}: waypoints apart", *spacings, box=None, pad_edge=False,
        header_style="dim",
    )  # fmt: skip
    for speed, told in summary["by_speed"].items():
        table.add_row(f"at most {speed} m/s: RMS", *map(_cm, told["rms_m"]))
        table.add_row("    time", *(f"{seconds:.1f} s" for seconds in told["time_s"]))
    console.print(table)


def _print_swap(summary: dict[str, Any]) -> None:
    for piece in summary["pieces"]:
        console.print(
            f"from {piece['from_s']:.1f} s: at most {_cm(piece['max_m'])} off the path, after "
            f"1.5 m {_cm(piece['max_after_1_5_m'])}"
        )
    console.print(
        f"greatest change from tick to tick {summary['greatest_change_v_mps']:.3f} m/s and "
        f"{summary['greatest_change_w_radps']:.3f} rad/s, "
        f"{'within' if summary['within_limits'] else 'beyond'} the robot's accelerations; rests "
        f"{_cm(summary['arrival_error_m'])} from the goal"
    )


def _cm(metres: float | None) -> str:
    return "–" if metres is None else f"{100 * metres:.2f} cm"
