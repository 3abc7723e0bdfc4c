"""`cairn run` and `cairn scenarios`."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from cairn.cli.completion import names_of
from cairn.cli.console import Browser, Host, Port, Speed, watch
from cairn.cli.progress import Progress, bar, busy
from cairn.cli.report import animated, read
from cairn.cli.root import app, complain, complaints, console, print_json, ready
from cairn.errors import CairnError
from cairn.missions import Change, Result, Scenario, coverage, run, run_many, shipped
from cairn.missions.result import EXIT_CONTACT, EXIT_NOT_REACHED, EXIT_OK, EXIT_USAGE
from cairn.record import Recorder, write_summary

VERDICT = {
    EXIT_OK: "[bold green]as expected[/]",
    EXIT_NOT_REACHED: "[bold red]not as expected[/]",
    EXIT_CONTACT: "[bold red]contact[/]",
}


@app.command("run")
def run_command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help="A .toml file, or the name of a shipped one; see `cairn scenarios`.",
            autocompletion=names_of("scenarios"),
        ),
    ],
    seed: Annotated[
        int | None,
        typer.Option(
            min=0, max=2**32 - 1, help="Seed of all that is random; by default the scenario's."
        ),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(min=1, help="Run with seeds 1 to this, in parallel, and print one table."),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(help="Folder to write; by default runs/<name>."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
    picture: Annotated[
        bool, typer.Option(help="Draw the run into the folder as picture.png.")
    ] = True,
    report: Annotated[
        bool | None,
        typer.Option(
            "--report/--no-report", help="Write report.html into the folder; with --record, always."
        ),
    ] = None,
    animate: Annotated[
        Path | None, typer.Option(help="Write the run as an animation: .gif, .webp or .png.")
    ] = None,
    live: Annotated[bool, typer.Option(help="Watch it in a browser, at real time.")] = False,
    speed: Speed = 1.0,
    host: Host = "127.0.0.1",
    port: Port = None,
    browser: Browser = None,
) -> None:
    """Run a mission; `summary.json`, the log `run.mcap` and a picture stay in runs/<name>.

    --speed, --host, --port and --browser are for --live.
    """
    if seeds is not None:
        if seed is not None:
            raise typer.BadParameter("give --seed or --seeds, not both")
        if live:
            raise typer.BadParameter("--live shows one run: give --seed")
        raise typer.Exit(_table([scenario], seeds, as_json))
    if animate is not None:
        from cairn.view.animation import check_format

        check_format(animate)
    mission = Scenario.load(scenario)
    folder = ready(record or Path("runs") / mission.name)
    recorder = Recorder(folder)
    observers: list[Any] = [recorder]
    if live:
        (result,) = watch(
            mission, seed=seed, observers=lambda _: observers, speed=speed, paused=False,
            host=host, port=port, browser=browser, open_end=False, quiet=as_json,
        )  # fmt: skip
    else:
        result = _run(mission, seed, observers)
    written = [write_summary(result.to_dict(), folder), recorder.path]
    if picture:
        from cairn.view.picture import draw_run

        with busy("drawing"):
            written.append(draw_run(result, folder / "picture.png"))
    telling = report if report is not None else record is not None
    if telling or animate is not None:
        written += _retold(folder, mission.folder, telling, animate)
    if as_json:
        print_json(result.to_dict())
    else:
        _print_result(result)
        console.print("[dim]" + "  ".join(str(path) for path in written) + "[/]")
    raise typer.Exit(result.exit_code)


def _retold(
    folder: Path, maps_from: Path | None, report: bool, animation: Path | None
) -> list[Path]:
    """Write the report and the animation of a run that has just been recorded."""
    from cairn.view.report import write_run

    written = []
    story = read(folder, maps_from)
    if report:
        with busy("writing the page"):
            written.append(write_run(story, folder / "report.html"))
    if animation is not None:
        written.append(animated(story, animation))
    return written


def _run(mission: Scenario, seed: int | None, observers: list[Any]) -> Result:
    """Run a mission with its progress on the terminal."""
    with contextlib.ExitStack() as stack:
        if complaints.is_terminal:
            observers = [Progress(mission), *observers]
        for each in observers:
            if isinstance(each, contextlib.AbstractContextManager):
                stack.enter_context(each)
        return run(mission, seed=seed, observers=observers)


@app.command()
def scenarios(
    seeds: Annotated[
        int, typer.Option(min=0, help="Run them all with seeds 1 to this; 0: only list them.")
    ] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, nothing else.")] = False,
) -> None:
    """List the shipped scenarios, or run them all with several seeds and print one table."""
    if seeds:
        raise typer.Exit(_table(shipped(), seeds, as_json))
    missions = [Scenario.load(name) for name in shipped()]
    if as_json:
        listed = {mission.name: mission.description for mission in missions}
        print_json({"summary": listed})
        return
    table = Table("scenario", "robot", "what happens", box=None, pad_edge=False)
    for mission in missions:
        table.add_row(f"[bold]{mission.name}[/]", mission.robot, mission.description)
    console.print(table)


def _print_result(result: Result) -> None:
    summary = result.summary()
    console.print(f"\n{VERDICT[result.exit_code]}  ", end="")
    console.print(result.sentence, markup=False, highlight=False, soft_wrap=True)
    for robot in result.robots:
        table = Table("time", "from", "to", "why", box=None, pad_edge=False, header_style="dim")
        for transition in robot.transitions:
            table.add_row(
                f"{transition.time_s:7.1f} s",
                transition.before,
                transition.after,
                transition.sentence,
            )
        console.print(f"\n[bold]{robot.name}[/]")
        console.print(table)
    rows = {
        "time": f"{summary['time_s']:.1f} s",
        "driven": _metres(summary["path_length_m"]),
        "planned": _metres(summary["planned_length_m"]),
        "off the goal": _metres(summary["arrival_error_m"]),
        "least clearance": _metres(summary["least_clearance_m"]),
        "contacts": str(summary["contacts"]),
        "drift, at the end / most": f"{_metres(summary['drift_m'])} / "
        f"{_metres(summary['drift_max_m'])}",
        "plans": str(summary["plan_count"]),
        "real time factor": f"{result.wall['real_time_factor']:.1f}",
    }
    table = Table(box=None, show_header=False, pad_edge=False)
    for name, value in rows.items():
        table.add_row(f"[dim]{name}[/]", value)
    console.print()
    console.print(table)


def _table(names: list[str], seeds: int, as_json: bool) -> int:
    """Run scenarios × seeds, print two tables, and return the worst exit code."""
    for name in names:
        Scenario.load(name)  # bad input is refused before anything runs
    records: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    summaries: dict[str, list[dict[str, Any]]] = {}
    failures: list[Exception] = []
    with bar() as progress:
        work = progress.add_task("", total=len(names) * seeds)
        for (name, seed), record in run_many(names, range(1, seeds + 1)):
            if isinstance(record, Exception):
                failures.append(record)
            else:
                records[name].append(record)
            progress.update(work, advance=1, description=f"{name}, seed {seed}")
    for name, runs in records.items():
        summaries[name] = sorted((run["summary"] for run in runs), key=lambda s: s["seed"])
    counts = coverage(records)
    if as_json:
        seen = [change._asdict() | {"reached": places} for change, places in counts.items()]
        both = {"summary": summaries, "transitions": seen}
        print_json(both)
    elif len(names) == 1:
        console.print(_seeds_table(summaries))
    else:
        console.print(_all_table(summaries, seeds))
        console.print()
        console.print(_transitions_table(counts))
    for error in failures:
        if not isinstance(error, CairnError):
            raise error
        complain(error)
    codes = {summary["exit_code"] for rows in summaries.values() for summary in rows}
    return EXIT_USAGE if failures else max(codes, default=EXIT_OK)


def _seeds_table(records: dict[str, list[dict[str, Any]]]) -> Table:
    table = Table(
        "seed", "reached", "contacts", "time", "driven", "off the goal", "clearance", "drift",
        "plans", "result", box=None, pad_edge=False,
    )  # fmt: skip
    for summary in next(iter(records.values())):
        table.add_row(
            str(summary["seed"]),
            "yes" if summary["reached"] else "[red]no[/]",
            str(summary["contacts"])
            if not summary["contacts"]
            else f"[red]{summary['contacts']}[/]",
            f"{summary['time_s']:.1f} s",
            _metres(summary["path_length_m"]),
            _metres(summary["arrival_error_m"]),
            _metres(summary["least_clearance_m"]),
            _metres(summary["drift_m"]),
            str(summary["plan_count"]),
            summary["sentence"],
        )
    return table


def _all_table(records: dict[str, list[dict[str, Any]]], seeds: int) -> Table:
    table = Table(
        "scenario", "as expected", "contacts", "time", "driven", "off the goal", "clearance",
        "drift at the end / most", "plans", box=None, pad_edge=False,
    )  # fmt: skip
    for name, summaries in records.items():
        good = sum(summary["exit_code"] == EXIT_OK for summary in summaries)
        table.add_row(
            f"[bold]{name}[/]",
            f"[{'green' if good == seeds else 'red'}]{good} of {seeds}[/]",
            str(sum(summary["contacts"] for summary in summaries)),
            _span(summaries, "time_s", "s", 0),
            _span(summaries, "path_length_m", "m", 1),
            _span(summaries, "arrival_error_m", "m", 2),
            _span(summaries, "least_clearance_m", "m", 2),
            f"{_span(summaries, 'drift_m', 'm', 2)} / {_span(summaries, 'drift_max_m', 'm', 2)}",
            _span(summaries, "plan_count", "", 0),
        )
    return table


def _transitions_table(counts: dict[Change, dict[str, int]]) -> Table:
    reached = sum(map(bool, counts.values()))
    table = Table(
        "from", "perceived", "to", f"reached ({reached} of {len(counts)}) in", box=None,
        pad_edge=False,
    )  # fmt: skip
    for change, places in counts.items():
        names = sorted(places)
        more = f" and {len(names) - 4} more" if len(names) > 4 else ""
        table.add_row(*change, ", ".join(names[:4]) + more or "[red]not reached[/]")
    return table


def _span(summaries: list[dict[str, Any]], key: str, unit: str, digits: int) -> str:
    values = [summary[key] for summary in summaries if summary[key] is not None]
    if not values:
        return "–"
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return (low if low == high else f"{low}–{high}") + (f" {unit}" if unit else "")


def _metres(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f} m"
