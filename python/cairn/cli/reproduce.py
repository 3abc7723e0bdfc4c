"""`cairn reproduce`: the figures of the paper, and the study that it leaves to be done."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from cairn.cli.progress import bar
from cairn.cli.root import app, console, print_json, ready
from cairn.experiments.reproduce import ALL, NOT_MADE
from cairn.experiments.reproduction import Caption, Reproduction
from cairn.record import write_summary
from cairn.strict_json import plain


@app.command()
def reproduce(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help=f"Of: {', '.join(ALL)}; or all, the default."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder to write, a folder in it for each; by default runs/reproduce."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of whatever is random.")] = 1,
    list_: Annotated[
        bool, typer.Option("--list", help="Only list what there is to reproduce.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the record, nothing else.")
    ] = False,
) -> None:
    """Reproduce figures, tables and studies of the paper.

    Tables are printed; pictures, what agrees and what differs, and the record stay in a folder.
    """
    wanted = list(dict.fromkeys(names or ["all"]))
    if "all" in wanted:
        wanted = list(ALL)
    for name in wanted:
        if name not in ALL:
            raise typer.BadParameter(
                f"there is no `{name}`; there are: {', '.join(ALL)}", param_hint="NAME"
            )
    if list_:
        _list({name: ALL[name]().title for name in wanted}, as_json)
        return
    records, shown = {}, []
    folder_of_all = out or Path("runs/reproduce")
    for number, name in enumerate(wanted, start=1):
        reproduction, folder = ALL[name](), ready(folder_of_all / name)
        said = name if len(wanted) == 1 else f"{number} of {len(wanted)}, {name}"
        record = plain(_measured(said, reproduction, seed))
        record["caption"] = asdict(reproduction.caption(record))
        pictures = reproduction.draw(record, folder)
        written = [write_summary(record, folder), *pictures]
        beside = folder / "caption.md"
        beside.write_text(
            reproduction.caption(record).markdown(reproduction.title), encoding="utf-8"
        )
        written.append(beside)
        records[name] = record
        shown.append(
            {
                "name": name,
                "title": reproduction.title,
                "caption": record["caption"],
                "pictures": pictures,
            }
        )
        if not as_json:
            _print(reproduction, record, written)
    if len(shown) > 1:
        from cairn.view.report.gallery import write_gallery

        page = write_gallery(shown, NOT_MADE, folder_of_all / "index.html")
        if not as_json:
            console.print("[dim]" + escape(f"all on one page: {page}") + "[/]")
    if as_json:
        whole = records[wanted[0]] if len(wanted) == 1 else _joined(records)
        print_json(whole)


def _joined(records: dict[str, Any]) -> dict[str, Any]:
    summaries = {name: record["summary"] for name, record in records.items()}
    return {"summary": summaries, "reproductions": records}


def _list(titles: dict[str, str], as_json: bool) -> None:
    if as_json:
        print_json({"summary": titles, "not_made": NOT_MADE})
        return
    table = Table("name", "what it shows", box=None, pad_edge=False)
    for name, title in titles.items():
        table.add_row(f"[bold]{name}[/]", escape(title))
    console.print(table)
    left_out = Table("not made", "why", box=None, pad_edge=False)
    for name, why in NOT_MADE.items():
        left_out.add_row(f"[dim]{name}[/]", f"[dim]{escape(why)}[/]")
    console.print()
    console.print(left_out)


def _measured(name: str, reproduction: Reproduction, seed: int) -> dict[str, Any]:
    with bar() as progress:
        task = progress.add_task(name, total=reproduction.steps())
        begun = 0

        def advance(what: str) -> None:
            nonlocal begun
            progress.update(task, description=f"{name}: {what}", completed=begun)
            begun += 1

        return reproduction.measure(seed, advance)


def _print(reproduction: Reproduction, record: dict[str, Any], written: list[Path]) -> None:
    console.print(f"[bold]{escape(reproduction.title)}[/]")
    for content in reproduction.tables(record):
        table = Table(
            *map(escape, content.columns), box=None, pad_edge=False, header_style="dim",
            title=escape(content.title), title_justify="left", title_style="",
        )  # fmt: skip
        for row in content.rows:
            table.add_row(*map(escape, row))
        console.print()
        console.print(table)
    _print_caption(reproduction.caption(record))
    console.print("[dim]" + escape("  ".join(map(str, written))) + "[/]")


def _print_caption(caption: Caption) -> None:
    table = Table(box=None, show_header=False, pad_edge=False)
    for colour, name, sentences in (
        ("green", "agrees", caption.agrees),
        ("yellow", "differs", caption.differs),
    ):
        for sentence in sentences:
            table.add_row(f"[{colour}]{name}[/]", escape(sentence))
    console.print()
    console.print(table)
