"""Planners on the same maps in the same run, taking turns, their answers compared.

A round lets every contender solve once, each round beginning with another one, so that a slow phase
of the machine hits all of them. Contenders of the brain run once before anything counts: the first
call pays for fresh memory. One that is slow gets fewer rounds, by a budget of seconds.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cairn import _brain
from cairn.experiments.contenders import (
    OURS,
    PEERS,
    Contender,
    InRust,
    Refused,
    Task,
    compare,
    in_cells,
    ours,
)
from cairn.experiments.grids import AIM_MS_512, CLASSES, Map, Terrain
from cairn.experiments.machine import cores, describe, free_bytes
from cairn.experiments.memory import peak_share

TOLERANCE = 2e-4
"""Of float64 and whole-number answers against those in float32, of the cost."""

FULL_SIZES = (1024, 4096)
SMALL_SIZE = 512
REFERENCE = "dial"


@dataclass(frozen=True)
class Case:
    """One map and one corner rule."""

    name: str
    size: int
    corner_cutting: bool

    def __str__(self) -> str:
        """Short, for people."""
        return f"{self.name} {self.size}² {'cutting' if self.corner_cutting else 'strict'}"


@dataclass(frozen=True)
class Settings:
    """What to measure.

    Attributes:
        cases: in the order they are measured.
        repeats: rounds that count.
        peers: names of `PEERS`.
        budget_s: a contender whose runs of one case took longer sits out the other rounds; a peer
            that would take longer for a single run is left out.
        seed: of the maps.
        memory: whether to measure peak memory.
    """

    cases: list[Case]
    repeats: int = 5
    peers: tuple[str, ...] = tuple(PEERS)
    budget_s: float = 10.0
    seed: int = 1
    memory: bool = True


def cases_of(
    sizes: tuple[int, ...], classes: tuple[str, ...], rules: tuple[bool, ...], small: bool
) -> list[Case]:
    """Every class at every size under every rule; `small` adds those with an aim at 512²."""
    cases = [
        Case(name, size, rule)
        for size in sorted(sizes)
        for name in CLASSES
        if name in classes
        for rule in rules
    ]
    if small and SMALL_SIZE not in sizes:
        extra = [Case(n, SMALL_SIZE, rule) for n in AIM_MS_512 if n in classes for rule in rules]
        cases = extra + cases
    return cases


@dataclass
class CaseResult:
    """What came of a case.

    Attributes:
        seconds: every run that counted, by contender.
        arithmetic: by contender.
        agreed: how each answer compared with that of `cairn`.
        differs: sentences about answers that did not agree.
        skipped: why a contender was left out.
        reached: share of all cells from which the goal can be reached.
        copy_s: time to copy one uint32 per cell.
        memory: peak as a share of input + output.
        build_s: time a peer took to build its own form of the map.
    """

    case: Case
    goal: tuple[int, int]
    seconds: dict[str, list[float]] = field(default_factory=dict)
    arithmetic: dict[str, str] = field(default_factory=dict)
    agreed: dict[str, str] = field(default_factory=dict)
    differs: list[str] = field(default_factory=list)
    skipped: dict[str, str] = field(default_factory=dict)
    build_s: dict[str, float] = field(default_factory=dict)
    reached: float = 0.0
    copy_s: float = 0.0
    memory: float | None = None

    @property
    def cells(self) -> int:
        """Number of cells, blocked ones too."""
        return self.case.size**2

    def median(self, name: str) -> float | None:
        """Median time of a contender [s], None if it did not run."""
        runs = self.seconds.get(name)
        return statistics.median(runs) if runs else None

    def ns(self, name: str) -> float | None:
        """Median time of a contender per cell [ns]."""
        median = self.median(name)
        return None if median is None else 1e9 * median / self.cells

    def ratio(self, other: str = REFERENCE, name: str = "cairn") -> float | None:
        """How many times longer `other` took than `name`."""
        one, two = self.median(name), self.median(other)
        return None if one is None or two is None else two / one

    @property
    def aim_ns(self) -> float | None:
        """The aim for `cairn` [ns per cell], if there is one."""
        name, size = self.case.name, self.case.size
        if size == SMALL_SIZE and name in AIM_MS_512:
            return 1e6 * AIM_MS_512[name] / self.cells
        return CLASSES[name].aim_ns if size == max(FULL_SIZES) else None

    def to_dict(self) -> dict[str, Any]:
        """Everything, and what follows from it."""
        ns = self.ns("cairn")
        contenders = {
            name: {
                "median_ns_per_cell": self.ns(name),
                "least_ns_per_cell": 1e9 * min(runs) / self.cells,
                "most_ns_per_cell": 1e9 * max(runs) / self.cells,
                "median_s": self.median(name),
                "runs": len(runs),
                "arithmetic": self.arithmetic[name],
                "agrees": self.agreed.get(name),
                "build_s": self.build_s.get(name),
            }
            for name, runs in self.seconds.items()
        }
        return {
            "class": self.case.name,
            "size": self.case.size,
            "corner_cutting": self.case.corner_cutting,
            "cells": self.cells,
            "goal": list(self.goal),
            "reached": self.reached,
            "ratio": self.ratio(),
            "ratios": {name: self.ratio(name) for name in self.seconds if name != "cairn"},
            "ns_per_cell": ns,
            "python_ns_per_cell": self.ns("cairn-python"),
            "aim_ns_per_cell": self.aim_ns,
            "aim_met": None if self.aim_ns is None or ns is None else ns <= self.aim_ns,
            "memory_share": self.memory,
            "copy_share": None if ns is None else self.copy_s / (ns * 1e-9 * self.cells),
            "copy_ns_per_cell": 1e9 * self.copy_s / self.cells,
            "two_threads": self.ratio("cairn", "cairn-2-threads"),
            "contenders": contenders,
            "differs": self.differs,
            "skipped": self.skipped,
        }


def choose_goal(grid: Map, seed: int = 0) -> tuple[int, int]:
    """Return the free cell nearest the middle that most of the free cells can reach.

    Of 32 others, the one that most can reach, where that one is walled in.
    """
    rows, cols = grid.shape
    cells = np.ones(grid.shape, bool) if isinstance(grid, Terrain) else grid > 0
    free = np.flatnonzero(cells)
    away = (free // cols - rows // 2) ** 2 + (free % cols - cols // 2) ** 2
    others = np.random.default_rng(seed).choice(free, 32)
    best, most = (0, 0), -1
    for index in [free[np.argmin(away)], *others]:
        goal = divmod(int(index), cols)
        task = Task(grid if isinstance(grid, Terrain) else cells, goal, False)
        walk = InRust("dial" if isinstance(grid, Terrain) else "dial-wide", task)
        walk.run()
        reached = int(np.isfinite(in_cells(walk.values(), walk.arithmetic)).sum())
        if reached > most:
            best, most = goal, reached
        if 2 * most > len(free):
            break
    return best


class Bench:
    """Measures one case after another, remembering how slow each peer was."""

    def __init__(self, settings: Settings, tell: Callable[[str], None] = lambda _: None) -> None:
        """`tell` hears what is being done."""
        self.settings, self._tell = settings, tell
        self._pace: dict[str, float] = {}
        self.missing = {name: why for name in settings.peers if (why := PEERS[name].missing())}
        self._drawn: tuple[str, int] | None = None
        self._map: Map = np.ones((1, 1), bool)
        self._goal = (0, 0)

    def run(self) -> Iterator[CaseResult]:
        """Measure every case."""
        for case in self.settings.cases:
            yield self.measure(case)

    def measure(self, case: Case) -> CaseResult:
        """Measure one case."""
        if self._drawn != (case.name, case.size):
            self._tell(f"{case}: drawing the map")
            self._map = CLASSES[case.name].draw(case.size, self.settings.seed)
            self._goal = choose_goal(self._map, self.settings.seed)
            self._drawn = (case.name, case.size)
        task = Task(self._map, self._goal, case.corner_cutting)
        result = CaseResult(case, self._goal)
        contenders: dict[str, Contender] = {}
        for name in ours(task):
            if name == "cairn-2-threads" and cores() < 2:
                result.skipped[name] = "this machine has one core"
                continue
            self._tell(f"{case}: {name} warms up")
            contenders[name] = OURS[name](task)
            contenders[name].run()
        for name in self.settings.peers:
            self._tell(f"{case}: {name} gets ready")
            why = self._why_not(name, result.cells)
            if why is None:
                try:
                    contenders[name] = PEERS[name].make(task)
                except (Refused, MemoryError) as error:
                    why = str(error) or "not enough memory"
            if why is not None:
                result.skipped[name] = why
            elif hasattr(contenders[name], "build_s"):
                result.build_s[name] = contenders[name].build_s  # type: ignore[attr-defined]
        self._rounds(case, contenders, result)
        self._tell(f"{case}: comparing answers")
        self._compare(contenders, result)
        result.copy_s = min(_brain.copy_seconds(result.cells) for _ in range(5))
        if self.settings.memory:
            self._tell(f"{case}: peak memory")
            result.memory = peak_share(task)
        return result

    def _why_not(self, name: str, cells: int) -> str | None:
        if name in self.missing:
            return self.missing[name]
        peer = PEERS[name]
        seconds = 1e-9 * self._pace.get(name, peer.guess_ns) * cells
        if seconds > self.settings.budget_s:
            return (
                f"about {seconds:.0f} s a run, more than the budget of {self.settings.budget_s:g} s"
            )
        needs = peer.bytes_per_cell * cells
        if needs > 0.7 * free_bytes():
            return f"needs about {needs / 2**30:.0f} GiB, and {free_bytes() / 2**30:.0f} are free"
        return None

    def _rounds(self, case: Case, contenders: dict[str, Contender], result: CaseResult) -> None:
        names = list(contenders)
        result.seconds = {name: [] for name in names}
        result.arithmetic = {name: contenders[name].arithmetic for name in names}
        for turn in range(self.settings.repeats):
            first = turn % len(names)
            for name in names[first:] + names[:first]:
                runs = result.seconds[name]
                if runs and sum(runs) + min(runs) > self.settings.budget_s:
                    continue
                self._tell(f"{case}: round {turn + 1} of {self.settings.repeats}, {name}")
                runs.append(contenders[name].run())
        for name in self.settings.peers:
            if name in contenders:
                pace = result.ns(name) or 0.0
                self._pace[name] = max(pace, self._pace.get(name, 0.0))

    def _compare(self, contenders: dict[str, Contender], result: CaseResult) -> None:
        mine = contenders["cairn"]
        for name, other in contenders.items():
            if name != "cairn":
                how, differs = compare("cairn", mine, name, other, TOLERANCE)
                result.agreed[name] = how
                if differs:
                    result.differs.append(f"{result.case}: {differs}")
        result.reached = float(np.isfinite(in_cells(mine.values(), mine.arithmetic)).mean())


def record_of(settings: Settings, results: list[CaseResult], machine: dict[str, Any]) -> dict:
    """Return the record of a run, `summary` first."""
    return {
        "summary": summary_of(results),
        "machine": machine,
        "settings": {
            "repeats": settings.repeats,
            "budget_s": settings.budget_s,
            "seed": settings.seed,
            "peers": list(settings.peers),
            "tolerance": TOLERANCE,
        },
        "cases": [result.to_dict() for result in results],
    }


def summary_of(results: list[CaseResult]) -> dict[str, Any]:
    """Ratios first."""
    ratios = {str(r.case): ratio for r in results if (ratio := r.ratio()) is not None}
    lowest = min(ratios, key=ratios.__getitem__, default=None)
    by_size: dict[str, float | None] = {}
    for size in sorted({result.case.size for result in results}):
        found = [result.ratio() for result in results if result.case.size == size]
        by_size[str(size)] = geometric_mean(found)
    dicts = [result.to_dict() for result in results]
    aims = [each["aim_met"] for each in dicts if each["aim_met"] is not None]
    return {
        "cases": len(results),
        "geometric_mean_ratio": geometric_mean(list(ratios.values())),
        "geometric_mean_ratio_by_size": by_size,
        "lowest_ratio": None if lowest is None else ratios[lowest],
        "lowest_ratio_case": lowest,
        "geometric_mean_ratio_scipy": geometric_mean([r.ratio("scipy") for r in results]),
        "aims": len(aims),
        "aims_met": sum(aims),
        "agree": not any(result.differs for result in results),
        "differs": [line for result in results for line in result.differs],
        "skipped": sum(len(result.skipped) for result in results),
    }


def geometric_mean(values: list[float | None]) -> float | None:
    """Of those that are there."""
    found = [value for value in values if value]
    return math.exp(sum(map(math.log, found)) / len(found)) if found else None


__all__ = ["Bench", "Case", "CaseResult", "Settings", "cases_of", "describe", "record_of"]
