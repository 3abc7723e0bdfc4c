"""`cairn report`: a run or a benchmark as one page, or a run as an animation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from cairn import errors
from cairn.cli.progress import bar, busy
from cairn.cli.root import app, console, print_json

if TYPE_CHECKING:
    from cairn.view.story import Story


@app.command()
def report(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="RUN", help="Folder of a recorded run or of a benchmark, or its summary.json."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(help="The page; by default report.html beside what it tells.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option(help="Write the run as a .gif, .webp or .png instead of a page.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, nothing else.")] = False,
) -> None:
    """Tell a recorded run or a benchmark as one page that needs nothing else."""
    from cairn.missions import retelling
    from cairn.view.animation import check_format
    from cairn.view.report import write_bench, write_run

    folder = source if source.is_dir() else source.parent
    page = out or folder / "report.html"
    if retelling.is_run(source):
        if animate is not None:
            check_format(animate)
        story = read(source)
        if animate is None:
            with busy("writing the page"):
                written = write_run(story, page)
            _say(source, written, as_json)
        else:
            _say(source, animated(story, animate), as_json)
        return
    if animate is not None:
        raise typer.BadParameter("only a recorded run can be animated", param_hint="--animate")
    path = source / "summary.json" if source.is_dir() else source
    _say(source, write_bench(_record(path), page, source=str(path)), as_json)


def animated(story: Story, path: Path) -> Path:
    """Write an animation, saying how far it is: it takes some seconds."""
    from cairn.view.animation import animate

    with bar() as shown:
        task = shown.add_task("drawing pictures", total=None)
        return animate(
            story,
            path,
            observer=lambda done, total: shown.update(task, completed=done, total=total),
        )


def read(source: Path, maps_from: Path | None = None) -> Story:
    """Read the record of a run, saying how far it is."""
    from cairn.missions import retelling

    with bar() as shown:
        task = shown.add_task("reading", total=None)
        return retelling.of_record(
            source,
            maps_from=maps_from,
            observer=lambda done, total: shown.update(task, completed=done, total=total),
        )


def _record(path: Path) -> dict[str, Any]:
    """What a benchmark left; a run that was not recorded is told how to be."""
    reason = "it has no `summary`"
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        record, reason = None, "there is no such file"
    except ValueError as error:
        record, reason = None, f"it is not JSON ({error})"
    if isinstance(record, dict) and "scenario" in record:
        reason = "a run without its ticks; `cairn run NAME --record DIR` keeps them"
    elif isinstance(record, dict) and isinstance(record.get("summary"), dict):
        return record
    raise errors.NothingToReport(
        f"{path} is neither a recorded run nor the record of a benchmark: {reason}",
        path=str(path),
        reason=reason,
    )


def _say(source: Path, path: Path, as_json: bool) -> None:
    if as_json:
        record = {"summary": {"source": str(source), "written": str(path)}}
        print_json(record)
        return
    console.print("[dim]" + escape(str(path)) + "[/]", soft_wrap=True, highlight=False)
