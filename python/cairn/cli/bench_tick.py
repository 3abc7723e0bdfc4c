"""`cairn bench tick`: how long deciding takes, part by part, and what recording adds."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from cairn.cli.bench import bench
from cairn.cli.progress import bar
from cairn.cli.root import console, print_json, ready
from cairn.missions.result import EXIT_NOT_REACHED, EXIT_OK
from cairn.record import write_summary
from cairn.strict_json import plain


@bench.command("tick")
def bench_tick(
    rounds: Annotated[
        int, typer.Option(min=1, help="How often every tick is repeated; the quickest counts.")
    ] = 5,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-tick.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Time every tick of real runs, without and with a log. Code 3 if a command differs."""
    from cairn.experiments import bench_tick as measuring
    from cairn.experiments.machine import describe

    out = ready(out or Path("runs/bench-tick"))
    machine = describe()
    with bar() as progress:
        work, begun = progress.add_task("", total=2 * len(measuring.CASES)), itertools.count()
        measured = measuring.measure(
            rounds=rounds,
            tell=lambda text: progress.update(work, description=text, completed=next(begun)),
        )
    summary = measuring.summary_of(measured)
    cases = [each.to_dict() for each in measured]
    record = plain({"summary": summary, "machine": machine, "cases": cases}, decimals=3)
    write_summary(record, out)
    if as_json:
        print_json(record)
    else:
        _print(measured, summary)
    raise typer.Exit(EXIT_OK if summary["same"] else EXIT_NOT_REACHED)


def _print(measured: list, summary: dict) -> None:
    console.print("A tick [µs], the quickest of the rounds; ticks that made a plan are apart.\n")
    table = Table(
        "", "ticks", "p50", "p99", "p99.9", "max", "recording p50", "share", "bytes", "plan",
        box=None, pad_edge=False,
    )  # fmt: skip
    for each in measured:
        took, log = each.tick_us, each.log_us
        table.add_row(
            f"[bold]{each.case.name}[/]" + ("" if each.case.counts else " [dim](apart)[/]"),
            str(each.ticks),
            *(f"{took[name]:.1f}" for name in ("p50", "p99", "p99.9", "max")),
            f"{log['p50']:.2f}",
            f"{100 * each.share:.1f} %",
            f"{each.bytes_per_tick:.0f}",
            "–" if each.plan_ms is None else f"{each.plan_ms:.1f} ms",
        )
    console.print(table)
    from cairn.experiments.bench_tick import PARTS

    parts = Table("p50 / p99.9 of", *PARTS, box=None, pad_edge=False)
    for each in measured:
        cells = (each.parts_us[name] for name in PARTS)
        parts.add_row(
            f"[bold]{each.case.name}[/]",
            *(f"{cell['p50']:.1f} / {cell['p99.9']:.1f}" for cell in cells),
        )
    console.print()
    console.print(parts)
    console.print(
        f"\np99.9 of a tick {summary['tick_p999_us']:.0f} µs, aim {summary['tick_aim_us']:.0f};"
        f" recording {100 * summary['recording_share']:.1f} % of a tick, aim"
        f" {100 * summary['recording_aim']:.0f} %."
    )
