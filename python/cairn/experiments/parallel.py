"""The parallel study that the paper leaves as future work [Maalouf06 §3.3].

Three graphs of about as many nodes, in few wide, as many as wide, and many thin layers. Each is
solved by the levelled and the in-place engine as a task graph, under schedule (a) `fronts` and (b)
`wavefront`: what was done against the bounds, the speed-up on the cores there are, and both
schedules played out on 1 to 64 workers with the durations measured on one thread.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cairn import _brain
from cairn.graphs import Csr, LayeredResult, graph_from_edges, plan_layered

WORKERS = (1, 2, 4, 8, 16, 32, 64)
BUSY_ON = 16
BUSY_BINS = 80
REPEAT_S = 0.1
ENGINES: tuple[Literal["levelled", "in_place"], ...] = ("levelled", "in_place")
SCHEDULES: tuple[Literal["fronts", "wavefront"], ...] = ("fronts", "wavefront")


@dataclass(frozen=True)
class Profile:
    """A graph by the layers it has: `layers` of `width` nodes each."""

    name: str
    layers: int
    width: int


PROFILES = (Profile("wide", 12, 1500), Profile("square", 134, 134), Profile("long thin", 600, 30))


def layered_graph(profile: Profile, seed: int) -> Csr:
    """Return a graph of a profile: eight two-way links a node, costs 1 to 100 by direction.

    Node 0 is the goal, linked both ways to all of layer 1.
    """
    rng = np.random.default_rng(seed)
    cells = 1 + np.arange(profile.layers * profile.width).reshape(profile.layers, profile.width)
    pairs = [np.stack([np.zeros(profile.width, np.int64), cells[0]], axis=1)]
    for down, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        rows = slice(0, profile.layers - down), slice(down, None)
        left = slice(max(-right, 0), profile.width - max(right, 0))
        shifted = slice(max(right, 0), profile.width - max(-right, 0))
        ends = cells[rows[0], left], cells[rows[1], shifted]
        pairs.append(np.stack([end.ravel() for end in ends], axis=1))
    half = np.concatenate(pairs)
    edges = np.concatenate([half, half[:, ::-1]])
    return graph_from_edges(1 + cells.size, edges, rng.integers(1, 101, len(edges)))


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def steps() -> int:
    """Return how often `measure` calls `advance` for `PROFILES`."""
    return len(PROFILES) * len(ENGINES) * (1 + len(SCHEDULES))


def measure(
    profiles: Sequence[Profile] = PROFILES,
    *,
    seed: int = 1,
    repeats: int = 4,
    advance: Callable[[str], None] = lambda name: None,
) -> dict[str, Any]:
    """Run the study; the record that `cairn reproduce parallel --json` prints.

    Args:
        profiles: the graphs.
        seed: of the links' costs.
        repeats: of every timing, at least, and for a tenth of a second each; the fastest counts.
        advance: called with what comes next, `steps()` times.
    """
    began = time.perf_counter()
    studies = []
    for profile in profiles:
        graph = layered_graph(profile, seed)
        for engine in ENGINES:
            advance(f"{profile.name}, {engine}")
            studies.append(_study(profile, graph, engine, repeats, advance))
    record = {"summary": _summary(studies), "seed": seed, "repeats": repeats, "studies": studies}
    return record | {"wall": {"study_s": time.perf_counter() - began}}


def _study(
    profile: Profile, graph: Csr, engine: Any, repeats: int, advance: Callable[[str], None]
) -> dict[str, Any]:
    serial = plan_layered(*graph, 0, engine=engine)
    runs = _runs(graph, engine, "wavefront", 1, repeats)
    alone = min(runs, key=_span_ns)
    level, layer, took_ns = _durations(runs)
    # What a task costs beside itself: taken off the board, and those woken that wait for it.
    span_ns = _span_ns(alone)
    ran_ns = int((alone.trace.end_ns - alone.trace.begin_ns).sum())
    hand_out_ns = max(0, round((span_ns - ran_ns) / len(alone.trace.level)))
    slope = alone.greatest_rise + 1 if engine == "in_place" else 0
    schedules = {}
    for schedule in SCHEDULES:
        advance(f"{profile.name}, {engine}, {schedule}")
        measured = {}
        for threads in sorted({1, 2, cores()} & set(range(1, cores() + 1))):
            several = runs
            if (threads, schedule) != (1, "wavefront"):
                several = _runs(graph, engine, schedule, threads, repeats)
            for run in several:
                _check_same(serial, run)
            measured[threads] = span_ns / min(map(_span_ns, several))
        played, busy = {}, None
        for workers in WORKERS:
            begin, end = _brain.play_out(
                alone.trace.waits, schedule, slope, level, layer, took_ns + hand_out_ns, workers
            )
            played[workers] = float(end.sum() - begin.sum()) / float(end.max())
            if workers == BUSY_ON:
                busy = _busy(begin, end)
        schedules[schedule] = {"measured": measured, "played": played, "busy": busy}
    return {
        "profile": profile.name,
        "engine": engine,
        "nodes": len(alone.native),
        "links": len(graph[1]),
        "layers": alone.layers,
        "widest_layer": alone.widest_layer,
        "levels": alone.levels,
        "levels_bound": alone.max_levels,
        "operations": alone.operations,
        "operations_bound": alone.operations_worst_case,
        "operations_equation_4": alone.operations_equation_4,
        "operations_bound_equation_4": alone.operations_worst_case_equation_4,
        "tasks": len(took_ns),
        "task_us": float(np.median(took_ns)) / 1e3,
        "hand_out_us": hand_out_ns / 1e3,
        "one_thread_ms": span_ns / 1e6,
        "schedules": schedules,
    }


def _runs(graph: Csr, engine: Any, schedule: Any, threads: int, repeats: int) -> list[Any]:
    """Return so many runs; more if they are short: threads take a while to spread over cores."""
    how = {"engine": engine, "schedule": schedule, "threads": threads, "record_trace": True}
    runs, began = [], time.perf_counter()
    while len(runs) < repeats or time.perf_counter() - began < REPEAT_S * repeats:
        runs.append(plan_layered(*graph, 0, **how))
    return runs


def _durations(runs: list[Any]) -> tuple[Any, Any, Any]:
    """Return level, layer and shortest duration [ns] of every task up to the last level."""
    shortest = []
    for run in runs:
        trace = run.trace
        order = np.lexsort((trace.layer, trace.level))
        order = order[trace.level[order] <= run.levels]
        shortest.append((trace.end_ns - trace.begin_ns)[order])
    return trace.level[order], trace.layer[order], np.min(shortest, axis=0)


def _span_ns(run: LayeredResult) -> int:
    trace = run.trace
    assert trace is not None
    return int(trace.end_ns.max() - trace.begin_ns.min())


def _check_same(serial: LayeredResult, run: LayeredResult) -> None:
    same = np.array_equal(serial.native, run.native)
    if not (same and np.array_equal(serial.next_node, run.next_node)):
        raise AssertionError("a schedule changed the result: this is a bug, please report it")


def _busy(begin: Any, end: Any) -> list[float]:
    """Return the mean number of busy workers in equal parts of the time."""
    edges = np.linspace(0, end.max(), BUSY_BINS + 1)
    times = np.concatenate([begin, end])
    change = np.concatenate([np.ones(len(begin)), -np.ones(len(end))])
    order = np.argsort(times, kind="stable")
    times, change = times[order], change[order]
    # Work done up to each edge: the integral of the number of busy workers.
    running = np.cumsum(change)
    done = np.concatenate([[0], np.cumsum(running[:-1] * np.diff(times))])
    return (np.diff(np.interp(edges, times, done)) / np.diff(edges)).tolist()


def _summary(studies: list[dict[str, Any]]) -> dict[str, Any]:
    """Return, per profile and engine, levels and operations by their bounds, and the speed-ups."""
    most = max(WORKERS)
    rows: dict[str, Any] = {"cores": cores(), "same_bits_as_serial": True}
    for study in studies:
        plans = study["schedules"]
        rows[f"{study['profile']}, {study['engine']}"] = {
            "levels": study["levels"],
            "levels_of_bound": study["levels"] / study["levels_bound"],
            "operations_of_bound": study["operations"] / study["operations_bound"],
            "measured": {name: plans[name]["measured"] for name in SCHEDULES},
            f"played_on_{most}": {name: plans[name]["played"][most] for name in SCHEDULES},
        }
    return rows
