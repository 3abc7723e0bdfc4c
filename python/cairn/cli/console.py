"""`cairn console`, and what `cairn run --live` shares with it."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from cairn.cli.completion import names_of
from cairn.cli.root import app, complaints, console, ready
from cairn.errors import ConsoleAddressUnusable
from cairn.missions import Result, Scenario
from cairn.missions.live import Live, with_nothing_to_do
from cairn.record import Recorder, write_summary

PORT = 8080

Host = Annotated[
    str,
    typer.Option(help="Address to listen on; any but a loopback one asks visitors for a token."),
]
Port = Annotated[
    int | None, typer.Option(min=0, max=65535, help=f"By default {PORT}, or a free one; 0: free.")
]
Speed = Annotated[
    float, typer.Option(help="Simulated seconds per second; inf: as many as there can be.")
]
Browser = Annotated[
    bool | None, typer.Option(help="Open a browser; by default where there is a screen.")
]


@app.command("console")
def console_command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="[SCENARIO]",
            help="Whose map, robot and boxes: a .toml file, or the name of a shipped one.",
            autocompletion=names_of("scenarios"),
        ),
    ] = "office",
    seed: Annotated[
        int | None,
        typer.Option(
            min=0, max=2**32 - 1, help="Seed of all that is random; by default the scenario's."
        ),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(help="Folder to write; a run begun anew goes to <folder>-2 and so on."),
    ] = None,
    speed: Speed = 1.0,
    paused: Annotated[bool, typer.Option(help="Begin paused.")] = False,
    host: Host = "127.0.0.1",
    port: Port = None,
    browser: Browser = None,
) -> None:
    """Drive a robot from the browser: click goals, drop boxes, see why it does what it does.

    The scenario's own goals and events are left out. Ends with Ctrl-C; the exit code is the worst
    of what came of the goals given.
    """
    mission = with_nothing_to_do(Scenario.load(scenario))
    folder = ready(record or Path("runs") / f"console-{mission.name}")

    def observers(run: int) -> list[Any]:
        return [] if record is None else [Recorder(_folder(folder, run))]

    def finish(result: Result, run: int) -> None:
        write_summary(result.to_dict(), _folder(folder, run))

    results = watch(
        mission, seed=seed, observers=observers, finish=finish, speed=speed, paused=paused,
        host=host, port=port, browser=browser, open_end=True, quiet=False,
    )  # fmt: skip
    for result in results:
        console.print(result.sentence, markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(max(result.exit_code for result in results))


def watch(
    mission: Scenario,
    *,
    seed: int | None,
    observers: Callable[[int], list[Any]],
    speed: float,
    paused: bool,
    host: str,
    port: int | None,
    browser: bool | None,
    open_end: bool,
    quiet: bool,
    finish: Callable[[Result, int], None] = lambda result, run: None,
) -> list[Result]:
    """Run a mission before the eyes of a browser; return what came of it, run by run."""
    if not speed > 0:
        raise typer.BadParameter("must be above 0", param_hint="--speed")
    live = Live(
        mission, seed=seed, observers=observers, finish=finish, speed=speed, paused=paused,
        open_end=open_end,
    )  # fmt: skip
    page = _page(live, host, port, interactive=open_end, title=f"Cairn · {mission.name}")
    try:
        if not quiet:
            console.print(f"[bold]{page.url}[/]  [dim]Ctrl-C ends it[/]", soft_wrap=True)
        else:
            complaints.print(page.url, soft_wrap=True)
        if page.url.startswith("http://") and "?token=" in page.url:
            complaints.print(
                "[yellow]whoever has this address can steer the robot; it is not encrypted[/]"
            )
        if browser or (browser is None and _has_screen()):
            webbrowser.open(page.url)
        _until_over(live, page, open_end)
    finally:
        page.stop()
    return live.results


def _page(live: Live, host: str, port: int | None, *, interactive: bool, title: str) -> Any:
    from cairn.view.console.server import Console

    try:
        return Console(
            live, host=host, port=PORT if port is None else port, interactive=interactive,
            title=title,
        )  # fmt: skip
    except ConsoleAddressUnusable:
        if port is not None:
            raise
        return Console(live, host=host, port=0, interactive=interactive, title=title)


def _until_over(live: Live, page: Any, open_end: bool) -> None:
    """Wait for the end; Ctrl-C ends the run, and its result is still told."""

    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupted)
    live.start()
    try:
        with contextlib.suppress(KeyboardInterrupt):
            while not live.wait(0.2):
                pass
            while not open_end and page.visitors:
                # The page stays for those who look at it.
                time.sleep(0.2)
        live.end()
    finally:
        signal.signal(signal.SIGTERM, before)


def _folder(folder: Path, run: int) -> Path:
    return folder if run == 0 else folder.with_name(f"{folder.name}-{run + 1}")


def _has_screen() -> bool:
    if not sys.stdout.isatty():
        return False
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
