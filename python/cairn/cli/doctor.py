"""`cairn doctor`: is everything there that is needed, and what to install if not."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

import cairn
from cairn import _brain
from cairn.cli.progress import bar
from cairn.cli.root import app, console, print_json
from cairn.missions.result import EXIT_NOT_REACHED

DISTRIBUTION = "cairn-nav"
PURPOSES = {
    "sim": "physics of the P3-AT",
    "bench": "planners of others, to compare with",
    "tune": "`cairn tune`",
    "console": "the live console",
    "docs": "`make docs`",
}
# Packages whose module has another name.
MODULES = {
    "pillow": "PIL", "pyyaml": "yaml", "scikit-image": "skimage", "xarray-spatial": "xrspatial",
    "myst-parser": "myst_parser", "mcap-ros2-support": "mcap_ros2",
}  # fmt: skip
OPENGL = "import mujoco; mujoco.GLContext(8, 8).make_current()"


@dataclass(frozen=True)
class Check:
    """One thing that was looked at."""

    name: str
    good: bool
    found: str
    advice: str = ""
    """What to do about it; empty where all is well."""
    needed: bool = True
    """Without it nothing works, or else only what `found` says."""


@app.command()
def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, nothing else.")] = False,
) -> None:
    """Check the installation and its extras, and say what to install for what is missing.

    Code 3 if something is missing that everything needs; extras may be missing.
    """
    checks = []
    with bar() as shown:
        task = shown.add_task("looking", total=_count())
        for check in _examine():
            checks.append(check)
            shown.update(task, advance=1, description=check.name)
    sound = all(check.good for check in checks if check.needed)
    if as_json:
        wrong = [check.name for check in checks if not check.good]
        record = {
            "summary": {"sound": sound, "missing": wrong, "version": cairn.__version__},
            "checks": [asdict(check) for check in checks],
        }
        print_json(record)
    else:
        _print(checks, sound)
    raise typer.Exit(0 if sound else EXIT_NOT_REACHED)


def _print(checks: list[Check], sound: bool) -> None:
    table = Table(box=None, show_header=False, pad_edge=False)
    for check in checks:
        mark = "[green]✓[/]" if check.good else "[red]✗[/]" if check.needed else "[yellow]–[/]"
        table.add_row(
            mark, f"[bold]{escape(check.name)}[/]", escape(check.found),
            f"[yellow]{escape(check.advice)}[/]",
        )  # fmt: skip
    console.print(table)
    left_out = [check.name for check in checks if not (check.good or check.needed)]
    without = f", without {', '.join(left_out)}" if left_out else ""
    console.print(f"sound{without}" if sound else "[red]not sound[/]")


def _count() -> int:
    """About how many checks there are."""
    extras = _requirements()
    return 6 + len(extras.pop("", [])) + len(extras)


def _examine() -> Iterator[Check]:
    yield Check(
        "python", sys.version_info >= (3, 11), f"{platform.python_version()} on "
        f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "" if sys.version_info >= (3, 11) else "install Python 3.11 or later",
    )  # fmt: skip
    yield _tried("cairn", _answers, "reinstall it: pip install --force-reinstall cairn-nav")
    yield _tried("processor", _processor, "reinstall it: pip install --force-reinstall cairn-nav")
    extras = _requirements()
    for package in extras.pop("", []):
        found = _found(package)
        yield Check(
            package, found is not None, found or "missing",
            "" if found else f"pip install {package}",
        )  # fmt: skip
    yield _writable("this", Path.cwd(), "runs are kept in the folder runs: go to one you may write")
    yield _writable(
        "temporary", Path(tempfile.gettempdir()), "set TMPDIR to a folder you may write"
    )
    for extra, packages in sorted(extras.items()):
        versions = {package: _found(package) for package in packages}
        missing = [package for package, version in versions.items() if version is None]
        told = ", ".join(f"{name} {version}" for name, version in versions.items() if version)
        purpose = f" (for {PURPOSES[extra]})" if extra in PURPOSES else ""
        yield Check(
            f"extra {extra}", not missing,
            (f"missing {', '.join(missing)}" if missing else told) + purpose,
            f'pip install "{DISTRIBUTION}[{extra}]"' if missing else "", needed=False,
        )  # fmt: skip
        if extra == "sim" and not missing:
            yield _opengl()


def _answers() -> str:
    """Plan a little and compare: is the brain the one that belongs here?"""
    import numpy as np

    built, installed = _brain.__version__, _version(DISTRIBUTION)
    field = cairn.plan_grid(np.ones((2, 3), bool), goal=(0, 0))
    if field.cost_to_go[0].tolist() != [0.0, 1.0, 2.0]:
        raise RuntimeError("the brain plans wrongly")
    if installed is not None and installed != built:
        raise RuntimeError(f"the brain is {built}, the package {installed}")
    return f"{built}, in {Path(cairn.__file__).parent}; plans as it should"


def _processor() -> str:
    levels = _brain.simd_levels()
    return f"the planner uses {levels[0]}" + (
        f" (also there: {', '.join(levels[1:])})" * bool(levels[1:])
    )


def _opengl() -> Check:
    try:
        done = subprocess.run(
            [sys.executable, "-c", OPENGL], capture_output=True, text=True, timeout=30
        )
        works = done.returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        works = False
    backend = os.environ.get("MUJOCO_GL", "the default")
    return Check(
        "opengl", works,
        f"MuJoCo {'draws' if works else 'cannot draw'} with {backend}: only for its own viewer, "
        "physics needs none",
        "" if works else "without a display: MUJOCO_GL=egl and Mesa's libEGL", needed=False,
    )  # fmt: skip


def _tried(name: str, look: Callable[[], str], advice: str) -> Check:
    try:
        return Check(name, True, look())
    except Exception as error:
        return Check(name, False, f"{type(error).__name__}: {error}", advice)


def _writable(name: str, folder: Path, advice: str) -> Check:
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return Check(f"{name} folder", False, f"{folder}: {error.strerror}", advice)
    return Check(f"{name} folder", True, f"{folder} can be written")


def _requirements() -> dict[str, list[str]]:
    """The packages that each extra names, under "" those always needed; by what is installed."""
    found: dict[str, list[str]] = {"": []}
    try:
        lines = importlib.metadata.requires(DISTRIBUTION) or []
    except importlib.metadata.PackageNotFoundError:
        return found
    for line in lines:
        name = re.match(r"[\w.-]+", line)
        extra = re.search(r"extra\s*==\s*['\"]([\w-]+)", line)
        if name:
            found.setdefault(extra.group(1) if extra else "", []).append(name.group())
    return found


def _found(package: str) -> str | None:
    """The version of a package that is there and can be imported."""
    version = _version(package)
    try:
        importlib.import_module(MODULES.get(package, package.replace("-", "_")))
    except Exception:
        return None
    return version or "of unknown version"


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
