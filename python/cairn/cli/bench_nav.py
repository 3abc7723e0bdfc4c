"""`cairn bench nav`: how well a stack drives where it has never been."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from cairn.cli.bench import bench
from cairn.cli.progress import bar
from cairn.cli.root import console, print_json, ready
from cairn.record import write_summary
from cairn.strict_json import plain


@bench.command("nav")
def bench_nav(
    worlds: Annotated[
        Path | None,
        typer.Option(help="Folder of world_N.json or Gazebo world_N.world files of BARN."),
    ] = None,
    generate: Annotated[
        int | None, typer.Option(min=1, help="Drive so many worlds of our own generator.")
    ] = None,
    office: Annotated[
        int | None, typer.Option(min=1, help="Drive so many office missions (P3-AT, sonars, map).")
    ] = None,
    kinematic: Annotated[
        bool, typer.Option("--kinematic", help="Office missions without physics, faster.")
    ] = False,
    indices: Annotated[
        str | None, typer.Option(help="Numbers of worlds, comma-separated; 10-20 is a range.")
    ] = None,
    stack: Annotated[
        str, typer.Option(help="cairn, cvm, dynamic-window, or module:function.")
    ] = "cairn",
    robot: Annotated[str, typer.Option(help="jackal (lidar) or p3at (sonars only).")] = "jackal",
    trials: Annotated[int, typer.Option(min=1, help="Trials of each world.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 1,
    processes: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that share the work; by default one per core."),
    ] = None,
    picture: Annotated[
        str | None, typer.Option(help="Draw one trial, WORLD or WORLD:TRIAL; nothing else is run.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-nav.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write the result as one HTML page as well.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Drive worlds nobody has seen, and count arrivals, collisions and time. Always code 0."""
    from cairn.experiments.machine import cores
    from cairn.experiments.nav import bench as measuring
    from cairn.experiments.nav.generator import generated
    from cairn.experiments.nav.worlds import load_folder

    wanted = None if indices is None else _numbers(indices)
    if sum(source is not None for source in (worlds, generate, office)) > 1:
        raise typer.BadParameter(
            "give one of --worlds, --generate and --office", param_hint="--worlds"
        )
    folder = ready(out or Path("runs/bench-nav"))
    if office is not None:
        body = "kinematic" if kinematic else "mujoco"
        numbers = wanted or tuple(range(office))
        if picture is not None:
            _draw_mission(picture, seed, body, folder)
            return
        with _watched(len(numbers)) as told:
            record = measuring.run_office(numbers, seed, body, processes or cores(), told)
        _show(record, folder, as_json, report)
        return
    if worlds is not None:
        chosen, source = load_folder(worlds, wanted), f"folder {worlds.name}"
    else:
        numbers = wanted or tuple(range(generate or 20))
        chosen = [generated(number, seed) for number in numbers]
        source = f"generated, seed {seed}"
    settings = measuring.Settings(stack, chosen, robot, trials, seed, processes or cores(), source)
    settings.check()
    if picture is not None:
        _draw(settings, picture, folder)
        return
    with _watched(len(chosen) * trials) as told:
        record = measuring.run(settings, told)
    _show(record, folder, as_json, report)


@contextmanager
def _watched(total: int) -> Iterator[Callable[[Any], None]]:
    """What to call with every trial, while a line shows how far it is."""
    good = done = 0
    with bar() as progress:
        work = progress.add_task("", total=total)

        def told(trial: Any) -> None:
            nonlocal good, done
            good, done = good + (trial.outcome == "success"), done + 1
            progress.update(work, advance=1, description=f"{good} of {done} arrived")

        yield told


def _show(record: dict[str, Any], folder: Path, as_json: bool, report: Path | None) -> None:
    record = plain(record)
    path = write_summary(record, folder)
    if report is not None:
        from cairn.view.report import write_bench

        write_bench(record, report, source=str(path))
    if as_json:
        print_json(record)
        return
    _print(record)
    console.print(f"[dim]{path}[/]")


def _draw_mission(which: str, seed: int, body: str, folder: Path) -> None:
    from cairn.experiments.nav.office import drive_office
    from cairn.view.picture import draw_run

    number = which.rpartition("_")[2]
    if not number.isdecimal():
        raise typer.BadParameter(
            f"`{which}`: the number of an office mission", param_hint="--picture"
        )
    trial, result = drive_office(int(number), seed, body)
    console.print(f"{trial.world}: {trial.outcome}, {trial.reason}")
    if result is not None:
        folder.mkdir(parents=True, exist_ok=True)
        console.print(f"[dim]{draw_run(result, folder / f'{trial.world}.png')}[/]")


def _numbers(text: str) -> tuple[int, ...]:
    numbers: list[int] = []
    try:
        for part in text.split(","):
            first, dash, last = part.strip().partition("-")
            numbers += range(int(first), int(last) + 1) if dash else [int(first)]
    except ValueError:
        numbers = []
    if not numbers:
        raise typer.BadParameter(
            f"`{text}`: whole numbers, comma-separated; 10-20 is a range", param_hint="--indices"
        )
    return tuple(dict.fromkeys(numbers))


def _draw(settings: Any, which: str, folder: Path) -> None:
    from cairn.experiments.nav.trial import drive, fitted
    from cairn.view.trials import draw_trial

    name, _, number = which.partition(":")
    found = [
        w
        for w in settings.worlds
        if w.name == name or w.name.rpartition("_")[2].lstrip("0") == (name.lstrip("0") or "-")
    ]
    if not found or not (number or "0").isdecimal():
        known = ", ".join(world.name for world in settings.worlds[:8])
        raise typer.BadParameter(
            f"`{which}`: WORLD or WORLD:TRIAL, of {known}", param_hint="--picture"
        )
    world = fitted(found[0], settings.robot)
    trial = drive(
        settings.stack, world, int(number or 0), settings.seed, robot=settings.robot, trace=True
    )
    path = draw_trial(
        trial, world, settings.robot, settings.stack,
        folder / f"{world.name}-{trial.trial}-{settings.stack.replace(':', '.')}.png",
    )  # fmt: skip
    console.print(f"{world.name}, trial {trial.trial}: {trial.outcome}, {trial.reason}")
    console.print(f"[dim]{path}[/]")


def _print(record: dict[str, Any]) -> None:
    table = Table(
        "world", "arrived", "touched", "too late", "error", "time s", "score", "old cap",
        box=None, pad_edge=False, header_style="dim",
    )  # fmt: skip
    for column in table.columns[1:]:
        column.justify = "right"
    for row in record["worlds"]:
        table.add_row(
            f"[bold]{row['world']}[/]"
            + (f" [dim]{row['difficulty']}[/]" if row["difficulty"] else ""),
            *(str(row[kind] or "") for kind in ("success", "collision", "timeout", "error")),
            "" if row["time_s"] is None else f"{row['time_s']:.1f}",
            f"{row['score']:.4f}",
            f"{row['score_old_cap']:.4f}",
        )
    console.print(table)
    for name, figures in [("all", record["summary"]), *record["by_difficulty"].items()]:
        console.print("\n" + summary_line(name, figures), highlight=False)
    if "office" in record:
        told = record["office"]
        console.print(
            f"contacts {told['contacts']}, {told['contacts_standing']} while the robot stood; "
            f"rightly refused {told['rightly_refused']}; "
            f"{told['transitions_per_minute']:.1f} changes of mode a minute; "
            f"{told['traps']} traps, {told['trapped_median_s']:.1f} s in the median, "
            f"{told['trapped_most_s']:.1f} s at most, {told['traps_not_left']} not left",
            highlight=False,
        )
    wall = record["wall"]
    console.print(
        f"[dim]stack {record['stack']}, robot {record['robot']}, {record['source']}, "
        f"{record['trials_per_world']} trials a world, seed {record['seed']}; a decision takes "
        f"{wall['tick_mean_ms']:.2f} ms, 99 of 100 at most {wall['tick_p99_ms']:.1f} ms[/]",
        highlight=False,
    )
    console.print(record["summary"]["caveat"])


def summary_line(name: str, figures: dict[str, Any]) -> str:
    """One line of figures with their 95 % intervals."""

    def between(key: str) -> str:
        low, high = figures[key]
        return f"[{low:.3f}, {high:.3f}]".replace("[", "\\[")

    time_s = "" if figures["time_s"] is None else f", {figures['time_s']:.1f} s"
    return (
        f"[bold]{name}[/] ({figures['worlds']} worlds, {figures['trials']} trials): success "
        f"{figures['success']:.4f} {between('success_95')}, collision {figures['collision']:.4f}, "
        f"timeout {figures['timeout']:.4f}, error {figures['error']:.4f}{time_s}; "
        f"score {figures['score']:.4f} {between('score_95')}, "
        f"old cap {figures['score_old_cap']:.4f} {between('score_old_cap_95')}"
    )
