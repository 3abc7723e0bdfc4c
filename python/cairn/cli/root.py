"""The application that the commands hang on, and how it ends when something is wrong."""

from __future__ import annotations

import json
import sys
import tempfile
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

import cairn
from cairn.missions.result import EXIT_USAGE

EXIT_BUG = 1

app = typer.Typer(
    name="cairn",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Plans, tracks, avoids and arrives. Exit codes: 0 done or reached, 2 usage or bad input, "
    "3 goal not reached or refused, 4 contact.",
)
console = Console()
if not console.is_terminal:
    console.width = 160  # tables in logs keep their lines
complaints = Console(stderr=True)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"cairn {cairn.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say which.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line; bad input ends with one line of complaint and code 2.

    Whatever else goes wrong is a bug of ours: code 1, one line, and the traceback in a file.
    """
    try:
        app(prog_name="cairn")
    except (cairn.errors.CairnError, OSError) as error:
        complain(error)
        sys.exit(EXIT_USAGE)
    except Exception as error:
        _admit(error)
        sys.exit(EXIT_BUG)


def print_json(record: Mapping[str, Any]) -> None:
    """Print a record for machines: nothing else is to be on stdout."""
    ascii_only = (sys.stdout.encoding or "ascii").lower().replace("-", "") != "utf8"
    text = json.dumps(record, indent=2, ensure_ascii=ascii_only, allow_nan=False)
    sys.stdout.write(text + "\n")


def complain(error: Exception) -> None:
    """Say what was wrong, and the class that code would catch."""
    complaints.print("[bold red]error[/] ", end="")
    told = str(error)
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        told = f"{error.filename}: {error.strerror}"
    complaints.print(told, markup=False, highlight=False, soft_wrap=True)
    complaints.print(f"[dim]({type(error).__name__})[/]")


def ready(folder: Path) -> Path:
    """Make a folder that is about to be written; refused before the work, not after it."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        return folder


def _admit(error: Exception) -> None:
    """Say that this is our bug and where its traceback is."""
    complain(error)
    told = "".join(traceback.format_exception(error))
    path = Path(tempfile.gettempdir()) / "cairn-error.txt"
    try:
        path.write_text(f"cairn {cairn.__version__}: {sys.argv[1:]}\n\n{told}", encoding="utf-8")
        where = f"what happened is in {path}"
    except OSError:
        where = f"what happened:\n{told}"
    complaints.print(
        f"this is a bug in cairn, not in what you typed; {where}", markup=False, soft_wrap=True
    )
