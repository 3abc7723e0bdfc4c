"""`cairn spin-test`, `cairn bench localise` and `cairn bench odometry`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from cairn.cli.bench import _names, _print_machine, bench
from cairn.cli.progress import bar, busy
from cairn.cli.root import app, console, print_json, ready
from cairn.record import write_summary
from cairn.strict_json import plain


def _robot_kind(robot: str) -> str:
    if robot not in ("kinematic", "mujoco"):
        raise typer.BadParameter(f"`{robot}` is none of kinematic, mujoco")
    return robot


AsJson = Annotated[bool, typer.Option("--json", help="Print the record, nothing else.")]
RobotKind = Annotated[str, typer.Option(help="kinematic or mujoco.", callback=_robot_kind)]


@app.command("spin-test")
def spin_test_command(
    robot: RobotKind = "mujoco",
    profile: Annotated[str, typer.Option(help="Profile, shipped or a file.")] = "p3at",
    turns: Annotated[float, typer.Option(min=0.1, help="Turns of each spin.")] = 3.0,
    rates: Annotated[str, typer.Option(help="Turn rates in rad/s, comma-separated.")] = "0.5,1,1.5",
    rest: Annotated[
        float, typer.Option(min=0.2, help="Seconds at rest, before and after the spins.")
    ] = 8.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the robot's noise and floor.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Turn on the spot, both ways, and tell how the wheels slip: the effective track."""
    from cairn.calibration import spin_test
    from cairn.experiments.bench_odometry import make_robot
    from cairn.profile import Profile

    try:
        wanted = tuple(float(rate) for rate in rates.split(","))
    except ValueError:
        raise typer.BadParameter(f"`{rates}` are no numbers", param_hint="--rates") from None
    with bar() as progress:
        task = progress.add_task("", total=2 * len(wanted) + 3)
        found = spin_test(
            make_robot(robot, Profile.load(profile), seed),
            turns=turns,
            rates_radps=wanted,
            rest_s=rest,
            watch=lambda text: progress.update(task, advance=1, description=text),
        )
    if as_json:
        record = {"summary": {k: v for k, v in found.to_dict().items() if k != "spins"}}
        record["spins"] = found.to_dict()["spins"]
        print_json(plain(record))
        return
    table = Table(
        "rate", "turned", "sides apart", "track", "by truth", box=None, pad_edge=False,
        header_style="dim",
    )  # fmt: skip
    for spin in found.spins:
        table.add_row(
            f"{spin.rate_radps:+.2f} rad/s",
            f"{spin.turned_rad / (2 * math.pi):+.3f} turns",
            f"{spin.driven_m:+.3f} m",
            f"{spin.effective_track_m:.4f} m",
            "–" if spin.truth_m is None else f"{spin.truth_m:.4f} m",
        )
    console.print(table)
    slip = "" if found.slip_factor is None else f", slip factor {found.slip_factor:.3f}"
    truth = "" if found.truth_m is None else f"; by truth {found.truth_m:.4f} m"
    console.print(
        f"\neffective track [bold]{found.effective_track_m:.4f} m[/] ± {found.sigma_m:.4f} m"
        f"{slip} (profile {found.profile_track_m:.4f} m{truth})",
        highlight=False,
    )
    console.print(
        f"gyro bias {math.degrees(found.gyro_bias_radps) * 60:+.2f} °/min,"
        f" noise {found.gyro_sigma_radps:.5f} rad/s",
        highlight=False,
    )
    console.print(f"in the profile: [bold]effective_track_m = {found.effective_track_m:.4f}[/]")


@bench.command("odometry")
def bench_odometry(
    robot: RobotKind = "kinematic",
    way: Annotated[float, typer.Option(min=1.0, help="Metres of each drive.")] = 100.0,
    seeds: Annotated[int, typer.Option(min=1, help="Drives of each course.")] = 20,
    courses: Annotated[str, typer.Option(help="Courses, comma-separated, or all.")] = "all",
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-odometry.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """How far off wheels and gyroscope are after a way, with and without what can be learnt."""
    from cairn.experiments import bench_odometry as measuring
    from cairn.experiments.machine import describe

    names = _names("--courses", courses, dict.fromkeys(measuring.COURSES))
    settings = measuring.Settings(names, robot, way, seeds)
    folder = ready(out or Path("runs/bench-odometry"))
    runs = _all(measuring.measure(settings), len(names) * seeds)
    rows = measuring.table(runs)
    record = plain(
        {
            "summary": measuring.summary_of(rows, settings),
            "machine": describe(),
            "table": rows,
            "runs": runs,
        }
    )
    files = [write_summary(record, folder)]
    if as_json:
        print_json(record)
        return
    table = Table(
        "course", "odometry", "off at the end", "90 % within", "most", "heading", "within 2σ",
        box=None, pad_edge=False, header_style="dim",
    )  # fmt: skip
    for row in rows:
        table.add_row(
            row["course"],
            row["odometry"],
            f"{row['end_m']:.2f} m",
            f"{row['end_p90_m']:.2f} m",
            f"{row['max_m']:.2f} m",
            f"{math.degrees(row['end_rad']):.1f}°",
            f"{100 * row['within_2_sigma']:.0f} %",
        )
    console.print(table)
    console.print(f"[dim]medians of {seeds} drives of {way:g} m, robot {robot}[/]")
    _print_machine(record["machine"], files)


@bench.command("localise")
def bench_localise(
    maps: Annotated[str, typer.Option(help="Shipped maps, comma-separated, or all.")] = "all",
    sensors: Annotated[str, typer.Option(help="sonar, lidar or all.")] = "all",
    trials: Annotated[int, typer.Option(min=1, help="Drives of each map and sensor.")] = 20,
    seconds: Annotated[
        float, typer.Option(min=20.0, help="Simulated seconds of each drive.")
    ] = 60.0,
    boxes: Annotated[int, typer.Option(min=0, help="Things that no map shows.")] = 6,
    seed: Annotated[int, typer.Option(min=0, help="Seed of places and noise.")] = 1,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that share the work; by default one per core."),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="Draw a kidnapping on the first map here.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two maps, three drives of 40 s each.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-localise.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find a robot from nothing and after a kidnapping, keep it, and be honest where nobody can."""
    from cairn.experiments import bench_localise as measuring
    from cairn.experiments.machine import cores, describe

    chosen = _names("--maps", maps, dict.fromkeys(measuring.MAPS))
    if quick:
        chosen, trials, seconds = tuple(m for m in chosen if m in ("office", "room")), 3, 40.0
    settings = measuring.Settings(
        chosen, _names("--sensors", sensors, measuring.SENSORS), trials, seconds, boxes, seed
    )
    folder = ready(out or Path("runs/bench-localise"))
    with busy("timing one update"):
        timing = measuring.speed()
    work = measuring.measure(settings, workers or cores())
    done = _all(work, len(measuring.jobs_of(settings)))
    rows = measuring.table(done)
    record = plain(
        {
            "summary": measuring.summary_of(rows, timing),
            "machine": describe(),
            "timing": timing,
            "table": rows,
            "trials": done,
        }
    )
    files = [write_summary(record, folder)]
    if picture is not None:
        from cairn.view.localisation import draw_kidnapping

        files.append(draw_kidnapping(*measuring.kidnapping(settings), path=picture))
    if as_json:
        print_json(record)
        return
    table = Table(
        "task", "sensor", "map", "right", "noticed 90 %", "found after", "90 %", "vouched",
        "wrongly", "error rms", "most", "heading", box=None, pad_edge=False, header_style="dim",
    )  # fmt: skip
    for row in rows:
        table.add_row(
            row["kind"],
            row["sensor"],
            row["map"],
            _share(row["right"]),
            _number(row["noticed_p90_s"] if row["kind"] == "kidnapped" else None, "s", 1),
            _number(row["found_s"], "s", 1),
            _number(row["found_p90_s"], "s", 1),
            _share(row["vouched"]),
            _share(row["wrong"], 1),
            _number(row["rms_m"], "m", 3),
            _number(row["max_m"], "m", 2),
            _number(None if row["rms_rad"] is None else math.degrees(row["rms_rad"]), "°", 2),
        )
    console.print(table)
    console.print(
        f"one update of {timing['particles']} poses by {timing['sonars']} sonars:"
        f" {timing['update_ms']:.2f} ms (95 % within {timing['update_p95_ms']:.2f} ms);"
        f" search of {timing['search_poses']} poses: {timing['search_ms']:.0f} ms; one core",
        highlight=False,
    )
    _print_machine(record["machine"], files)


def _all(work: Any, total: int) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    with bar() as progress:
        task = progress.add_task("", total=total)
        for some in work:
            found.extend(some)
            progress.advance(task)
    return found


def _share(value: float, digits: int = 0) -> str:
    return f"{100 * value:.{digits}f} %"


def _number(value: float | None, unit: str, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}"
