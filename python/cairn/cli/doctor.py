"""`cairn doctor`: is everything there that is needed, and what to install if not."""

from __future__ import annotations

import importlib
import importlib.metadata
import platform
import sys

import typer
from rich.markup import escape
from rich.table import Table

import cairn
from cairn.cli.root import app, console
from cairn.missions.result import EXIT_NOT_REACHED

NEEDED = ["numpy", "matplotlib", "pillow", "pydantic", "pyyaml", "rich", "typer"]
OPTIONAL = {"mujoco": ("physics of the P3-AT", 'pip install "cairn-nav[sim]"')}


@app.command()
def doctor() -> None:
    """Check the installation and say what to install for what is missing."""
    table = Table(box=None, show_header=False, pad_edge=False)
    sound = True

    def row(good: bool, name: str, found: str, advice: str = "") -> None:
        mark = "[green]✓[/]" if good else "[red]✗[/]"
        table.add_row(mark, f"[bold]{name}[/]", found, f"[yellow]{escape(advice)}[/]")

    row(sys.version_info >= (3, 11), "python", platform.python_version(), "")
    try:
        profile = cairn.Profile.load("p3at").to_dict()
        row(True, "cairn", f"{cairn.__version__}; brain answers, {profile['name']} is readable")
    except Exception as error:
        sound = False
        row(False, "cairn", f"the brain does not answer: {error}", "reinstall cairn-nav")
    for package in NEEDED:
        version = _version(package)
        sound &= version is not None
        row(
            version is not None,
            package,
            version or "missing",
            "" if version else f"pip install {package}",
        )
    for package, (purpose, advice) in OPTIONAL.items():
        version = _version(package)
        works = version is not None and _imports(package)
        found = f"{version}, {purpose}" if works else f"missing: {purpose}"
        row(works, package, found, "" if works else advice)
    console.print(table)
    console.print("sound" if sound else "[red]not sound[/]")
    raise typer.Exit(0 if sound else EXIT_NOT_REACHED)


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _imports(package: str) -> bool:
    try:
        importlib.import_module(package)
    except Exception:
        return False
    return True
