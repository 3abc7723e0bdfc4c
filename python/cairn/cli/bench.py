"""`cairn bench`: how fast, beside others, on maps that anyone can draw."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from cairn.cli.progress import bar
from cairn.cli.root import app, console, print_json, ready
from cairn.missions.result import EXIT_NOT_REACHED
from cairn.record import write_summary
from cairn.strict_json import plain

BENCHMARKS = Path("BENCHMARKS.md")

bench = typer.Typer(no_args_is_help=True, help="Measure, beside others, and compare the answers.")
app.add_typer(bench, name="bench")

RULES = {"both": (False, True), "forbidden": (False,), "allowed": (True,)}


@bench.command("plan")
def bench_plan(
    size: Annotated[
        str | None,
        typer.Option(
            help="Cells a side, comma-separated; by default 1024,4096, and 512 for the aims."
        ),
    ] = None,
    classes: Annotated[str, typer.Option(help="Kinds of map, comma-separated, or all.")] = "all",
    repeats: Annotated[int, typer.Option(min=1, help="Rounds that count.")] = 5,
    corner_cutting: Annotated[str, typer.Option(help="both, allowed or forbidden.")] = "both",
    peers: Annotated[
        str, typer.Option(help="Planners of others, comma-separated, all or none.")
    ] = "all",
    budget: Annotated[
        float, typer.Option(min=0.0, help="Seconds that a contender may use for one map.")
    ] = 10.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the maps.")] = 1,
    memory: Annotated[bool, typer.Option(help="Measure peak memory as well.")] = True,
    quick: Annotated[
        bool, typer.Option("--quick", help="512², three rounds, strict corners, a small budget.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-plan.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write its part of BENCHMARKS.md where you are.")
    ] = False,
    report: Annotated[
        Path | None, typer.Option(help="Write the result as one HTML page as well.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Plan on every kind of map, beside Dial, scipy and others. Code 3 if answers differ."""
    from cairn.experiments import bench_plan as measuring
    from cairn.experiments.bench_report import plans_section
    from cairn.experiments.contenders import PEERS
    from cairn.experiments.grids import CLASSES

    if corner_cutting not in RULES:
        _refuse("--corner-cutting", corner_cutting, RULES)
    if quick:
        size, repeats, budget = size or "512", min(repeats, 3), min(budget, 2.0)
        corner_cutting = "forbidden" if corner_cutting == "both" else corner_cutting
    settings = measuring.Settings(
        measuring.cases_of(
            _sizes(size, measuring.FULL_SIZES),
            _names("--classes", classes, CLASSES),
            RULES[corner_cutting],
            small=size is None,
        ),
        repeats=repeats,
        peers=_names("--peers", peers, PEERS),
        budget_s=budget,
        seed=seed,
        memory=memory,
    )
    out = ready(out or Path("runs/bench-plan"))
    record = _measure(settings, quiet=as_json)
    if report is not None:
        from cairn.view.report import write_bench

        write_bench(record, report, source=str(out / "summary.json"))
    _end("plan", record, out, plans_section if markdown else None, _print if not as_json else None)


@bench.command("movingai")
def bench_movingai(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="With .map files and their .map.scen files.")
    ],
    repeats: Annotated[int, typer.Option(min=1, help="Timed fields of each map.")] = 9,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-movingai.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write its part of BENCHMARKS.md where you are.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Time the field of MovingAI maps and check every published length. Code 3 if one is missed."""
    from cairn.experiments import bench_movingai as measuring
    from cairn.experiments.bench_report import maps_section
    from cairn.experiments.machine import describe

    paths = measuring.find_maps(folder)
    if not paths:
        raise typer.BadParameter(f"{folder}: no .map file there", param_hint="FOLDER")
    results = []
    out = ready(out or Path("runs/bench-movingai"))
    machine = describe()
    with bar() as progress:
        work = progress.add_task("", total=len(paths))
        for result in measuring.measure(
            paths, repeats, lambda text: progress.update(work, description=text)
        ):
            results.append(result)
            progress.advance(work)
    record = plain(
        {
            "summary": measuring.summary_of(results),
            "machine": machine,
            "maps": [result.to_dict() for result in results],
        }
    )
    _end(
        "movingai",
        record,
        out,
        maps_section if markdown else None,
        _print_maps if not as_json else None,
    )


@bench.command("graph")
def bench_graph(
    nodes: Annotated[str, typer.Option(help="Numbers of nodes, comma-separated.")] = "1000000",
    graphs: Annotated[str, typer.Option(help="Kinds, comma-separated, or all.")] = "all",
    repeats: Annotated[int, typer.Option(min=1, help="Rounds that count.")] = 5,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the graphs.")] = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-graph.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write its part of BENCHMARKS.md where you are.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Plan on graphs beside scipy. Code 3 if answers differ."""
    from cairn.experiments import bench_graph as measuring
    from cairn.experiments.bench_report import graphs_section
    from cairn.experiments.machine import describe

    names = _names("--graphs", graphs, measuring.GRAPHS)
    out = ready(out or Path("runs/bench-graph"))
    sizes = _sizes(nodes, (), "--nodes", most=100_000_000)
    machine, results = describe(), []
    with bar() as progress:
        work = progress.add_task("", total=len(names) * sum(sizes))
        for result in measuring.measure(
            names, sizes, repeats, seed, lambda text: progress.update(work, description=text)
        ):
            results.append(result)
            progress.advance(work, result.nodes)
    record = plain(
        {
            "summary": measuring.summary_of(results),
            "machine": machine,
            "graphs": [result.to_dict() for result in results],
        }
    )
    _end(
        "graph",
        record,
        out,
        graphs_section if markdown else None,
        _print_graphs if not as_json else None,
    )


@bench.command("repair")
def bench_repair(
    size: Annotated[str, typer.Option(help="Cells a side, comma-separated.")] = "4096",
    classes: Annotated[str, typer.Option(help="Kinds of map, comma-separated, or all.")] = "all",
    places: Annotated[int, typer.Option(min=1, help="Changes of each map.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of maps and places.")] = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder for summary.json; by default runs/bench-repair.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write its part of BENCHMARKS.md where you are.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Repair fields after local changes, against solving anew. Code 3 if answers differ."""
    from cairn.experiments import bench_repair as measuring
    from cairn.experiments.bench_report import repairs_section
    from cairn.experiments.machine import describe

    names = _names("--classes", classes, dict.fromkeys(measuring.CLASSES_REPAIRED))
    out = ready(out or Path("runs/bench-repair"))
    sizes = _sizes(size, ())
    machine, results = describe(), []
    with bar() as progress:
        work = progress.add_task("", total=len(names) * sum(each**2 for each in sizes))
        for result in measuring.measure(
            names, sizes, places, seed, lambda text: progress.update(work, description=text)
        ):
            results.append(result)
            progress.advance(work, result.size**2)
    record = plain(
        {
            "summary": measuring.summary_of(results),
            "machine": machine,
            "maps": [result.to_dict() for result in results],
        }
    )
    _end(
        "repair",
        record,
        out,
        repairs_section if markdown else None,
        _print_repairs if not as_json else None,
    )


def _end(
    name: str,
    record: dict[str, Any],
    out: Path,
    section: Callable[[dict[str, Any], str], str] | None,
    show: Callable[[dict[str, Any], list[Path]], None] | None,
) -> None:
    """Write the record and, with `section`, its part of BENCHMARKS.md; show or print the record.

    Without `show` it is printed as JSON. Leaves with code 3 if not every answer was right.
    """
    from cairn.experiments.bench_report import written

    files = [write_summary(record, out)]
    if section is not None:
        written(BENCHMARKS, f"cairn bench {name}", section(record, _command()))
        files.append(BENCHMARKS)
    if show is None:
        print_json(record)
    else:
        show(record, files)
    summary = record["summary"]
    raise typer.Exit(0 if summary.get("agree", summary.get("all_met")) else EXIT_NOT_REACHED)


def _print_graphs(record: dict[str, Any], files: list[Path]) -> None:
    from cairn.experiments.bench_report import GRAPH_COLUMNS, graph_row, graphs_line

    _print_rows(GRAPH_COLUMNS, [graph_row(each) for each in record["graphs"]])
    console.print("\n" + graphs_line(record["summary"]))
    _print_machine(record["machine"], files)


def _print_repairs(record: dict[str, Any], files: list[Path]) -> None:
    from cairn.experiments.bench_report import REPAIR_COLUMNS, repair_row, repairs_line

    _print_rows(REPAIR_COLUMNS, [repair_row(each) for each in record["maps"]])
    console.print("\n" + repairs_line(record["summary"]))
    _print_machine(record["machine"], files)


def _print_maps(record: dict[str, Any], files: list[Path]) -> None:
    from cairn.experiments.bench_report import MAP_COLUMNS, map_row, maps_line

    _print_rows(MAP_COLUMNS, [map_row(each) for each in record["maps"]])
    console.print("\n" + maps_line(record["summary"]))
    for wrong in record["summary"]["wrong"]:
        console.print(f"[red]{wrong}[/]", highlight=False)
    _print_machine(record["machine"], files)


def _print_rows(columns: tuple[str, ...], rows: list[list[str]]) -> None:
    table = Table(*columns, box=None, pad_edge=False, header_style="dim")
    for column in table.columns[1:]:
        column.justify = "right"
    for name, *others in rows:
        table.add_row(f"[bold]{name}[/]", *others)
    console.print(table)


def _print_machine(machine: dict[str, Any], files: list[Path]) -> None:
    from cairn.experiments.bench_report import machine_lines

    for line in machine_lines(machine):
        console.print(f"[dim]{line}[/]", highlight=False)
    console.print("[dim]" + "  ".join(map(str, files)) + "[/]")


def _measure(settings: Any, quiet: bool) -> dict[str, Any]:
    """Measure every case, showing how far it is and how long it will take."""
    from cairn.experiments import bench_plan as measuring

    machine = measuring.describe()
    results = []
    with bar() as progress:
        work = progress.add_task("", total=sum(case.size**2 for case in settings.cases))
        bench = measuring.Bench(settings, lambda text: progress.update(work, description=text))
        for result in bench.run():
            results.append(result)
            progress.advance(work, result.cells)
            if not (quiet or console.is_terminal):
                ns, ratio = result.ns("cairn"), result.ratio()
                console.print(
                    f"[dim]{result.case}: {ns:.2f} ns per cell, Dial ÷ cairn {ratio:.1f}[/]"
                )
    return plain(measuring.record_of(settings, results, machine))


def _print(record: dict[str, Any], files: list[Path]) -> None:
    from cairn.experiments.bench_report import COLUMNS, row, skipped, summary_lines

    if not console.is_terminal:
        console.width = 240
    columns = tuple(column.replace(" ns", "\nns") for column in COLUMNS)
    _print_rows(columns, [row(case) for case in record["cases"]])
    console.print(
        "[dim]ns per cell, median (least–most); aim ✓ met; copy: share of copy speed[/]\n"
    )
    for line in summary_lines(record["summary"]):
        console.print(line)
    for why, count in skipped(record):
        console.print(f"[yellow]left out[/] {escape(why)} ({count} cases)", highlight=False)
    _print_machine(record["machine"], files)


def _command() -> str:
    return "cairn " + " ".join(sys.argv[1:])


def _refuse(option: str, value: str, choices: Any) -> None:
    raise typer.BadParameter(f"`{value}` is none of {', '.join(choices)}", param_hint=option)


def _names(option: str, text: str, known: dict[str, Any]) -> tuple[str, ...]:
    if text in ("all", "none"):
        return tuple(known) if text == "all" else ()
    names = tuple(part.strip() for part in text.split(","))
    for name in names:
        if name not in known:
            _refuse(option, name, [*known, "all"])
    return names


def _sizes(
    text: str | None, default: tuple[int, ...], option: str = "--size", most: int = 32768
) -> tuple[int, ...]:
    from cairn.experiments.grids import SMALLEST

    if text is None:
        return default
    try:
        sizes = tuple(int(part) for part in text.split(","))
    except ValueError:
        sizes = ()
    if not sizes or min(sizes) < SMALLEST or max(sizes) > most:
        raise typer.BadParameter(
            f"`{text}`: whole numbers from {SMALLEST} to {most}, comma-separated",
            param_hint=option,
        )
    return sizes
