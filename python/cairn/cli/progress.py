"""Progress on the terminal: how far it is and how long it will still take.

Shown on stderr, and only to a person: what a command prints to stdout is the same with and without.
"""

from __future__ import annotations

import contextlib
import time
from types import TracebackType
from typing import Self

from rich.live import Live
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar
from rich.status import Status
from rich.table import Table

from cairn.cli.root import complaints
from cairn.missions import Scenario, Tick

REFRESH_S = 0.1


def bar() -> Bar:
    """A bar with what has been done, the time it took, the time left and what is being done."""
    return Bar(
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("[dim]{task.description}[/]"),
        console=complaints,
        transient=True,
        disable=not complaints.is_terminal,
    )


def busy(what: str) -> Status | contextlib.nullcontext[None]:
    """Say what is going on where nobody can tell how long it takes."""
    return complaints.status(what) if complaints.is_terminal else contextlib.nullcontext()


class Progress:
    """An observer of `cairn.missions.run` that shows one line per robot while it runs."""

    def __init__(self, scenario: Scenario) -> None:
        """Get ready to show."""
        self._live = Live(console=complaints, auto_refresh=False, transient=True)
        self._name, self._limit_s = scenario.name, scenario.timeout_s
        self._ticks: dict[str, Tick] = {}
        self._first: dict[str, tuple[object, float, float]] = {}
        self._began = self._shown = time.monotonic()

    def __call__(self, tick: Tick) -> None:
        """Take note of a tick; shown at most ten times a second."""
        self._ticks[tick.robot] = tick
        known = self._first.get(tick.robot)
        if tick.distance_to_go_m is not None and (known is None or known[0] != tick.goal):
            self._first[tick.robot] = (tick.goal, tick.time_s, tick.distance_to_go_m)
        now = time.monotonic()
        if now - self._shown >= REFRESH_S:
            self._shown = now
            self._live.update(self._table(now), refresh=True)

    def _table(self, now: float) -> Table:
        table = Table(box=None, show_header=False, pad_edge=False, expand=True)
        for ratio in (None, None, None, None, None, None, 1):
            table.add_column(no_wrap=True, overflow="ellipsis", ratio=ratio)
        for tick in self._ticks.values():
            mode, (_, _, why) = tick.decision.mode, tick.decision.sentence.partition(":")
            factor = tick.time_s / max(now - self._began, 1e-6)
            table.add_row(
                f"[bold]{self._name if len(self._ticks) == 1 else tick.robot}[/]",
                f"{tick.time_s:6.1f} s",
                f"[dim]{factor:.0f}×[/]",
                self._to_go(tick),
                self._left(tick, factor),
                f"[cyan]{mode.replace('_', ' ')}[/]",
                f"[dim]{why.strip()}[/]",
            )
        return table

    def _to_go(self, tick: Tick) -> str:
        if tick.explored is not None:
            return f"{100 * tick.explored:3.0f} % explored"
        return "" if tick.distance_to_go_m is None else f"{tick.distance_to_go_m:5.1f} m to go"

    def _left(self, tick: Tick, factor: float) -> str:
        """Return the wall time left, at the pace so far."""
        first = self._first.get(tick.robot)
        if first is None or tick.distance_to_go_m is None or factor <= 0:
            return ""
        covered, took = first[2] - tick.distance_to_go_m, tick.time_s - first[1]
        if covered < 0.5 or took <= 0:
            return ""
        left_s = min(tick.distance_to_go_m * took / covered, self._limit_s - tick.time_s) / factor
        return f"{left_s:.0f} s left"

    def __enter__(self) -> Self:
        """Start showing."""
        self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Clear the line."""
        self._live.stop()
