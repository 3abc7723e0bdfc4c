"""The application that the commands hang on."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console

import cairn
from cairn.missions.result import EXIT_USAGE

app = typer.Typer(
    name="cairn",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
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
    """Run the command line; bad input ends with one line of complaint and code 2."""
    try:
        app()
    except (cairn.errors.CairnError, OSError) as error:
        complain(error)
        sys.exit(EXIT_USAGE)


def complain(error: Exception) -> None:
    """Say what was wrong, and the class that code would catch."""
    complaints.print("[bold red]error[/] ", end="")
    complaints.print(str(error), markup=False, highlight=False, soft_wrap=True)
    complaints.print(f"[dim]({type(error).__name__})[/]")
