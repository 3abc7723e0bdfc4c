"""How long one tick of the navigator takes, part by part, and what recording it costs.

A scenario is run once and logged; then a new navigator gets the same inputs again and again,
without and with a log being written, timed inside the brain on the thread that decides. Every
command must come out as in the log, to the bit, or the measurement counts for nothing.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cairn import _brain
from cairn.missions import Scenario, run
from cairn.navigator import Navigator
from cairn.record import Recorder, Run, open_run

PARTS = ("locate", "map", "keep", "mode", "act", "record")
MODES = ("stop", "path planning", "path tracking", "obstacle avoidance")
PERCENTILES = (50.0, 99.0, 99.9)
AIM_P999_US = 100.0
AIM_RECORDING = 0.10


@dataclass(frozen=True)
class Case:
    """A scenario to measure in, with the pose it is driven by.

    `counts`: whether the aim is about it. The aim is about map, mode, track or avoid: a pose found
    by matching to a map is measured apart.
    """

    name: str
    scenario: str
    pose: str
    seed: int = 1
    counts: bool = True


CASES = (
    Case("office, pose given", "office", "truth"),
    Case("crate, odometry", "crate", "odometry"),
    Case("no map, odometry", "no_map", "odometry"),
    Case("office, localised", "office", "localised", counts=False),
)


@dataclass
class Measured:
    """Times of one case [µs]; of ticks that made no plan, unless said otherwise."""

    case: Case
    ticks: int
    plans: int
    same: bool  # every command as in the log
    tick_us: dict[str, float]  # percentiles, the quickest of the rounds
    raw_us: dict[str, float]  # of all rounds, whatever else the machine did
    parts_us: dict[str, dict[str, float]]
    modes_us: dict[str, dict[str, float]]
    log_us: dict[str, float]  # added to a tick by recording it
    share: float  # of recording in a tick: the median of one over the median of the other
    beside_us: dict[str, float]  # a tick while its log is written beside it
    plan_ms: float | None  # the longest tick that made a plan
    bytes_per_tick: float
    extra: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {**vars(self), "case": vars(self.case)}


def measure(
    cases: tuple[Case, ...] = CASES,
    rounds: int = 5,
    tell: Callable[[str], None] = lambda _: None,
) -> list[Measured]:
    """Measure cases, one after the other.

    Args:
        cases: what to measure in.
        rounds: how often every tick is repeated; the quickest counts, as the machine has other
            work too.
        tell: told what is being done.
    """
    measured = []
    for case in cases:
        with tempfile.TemporaryDirectory() as folder:
            tell(f"{case.name}: driving")
            made = _driven(case, Path(folder))
            tell(f"{case.name}: measuring")
            measured.append(_measured(case, made, rounds, Path(folder)))
    return measured


def _driven(case: Case, folder: Path) -> Run:
    scenario = Scenario.load(case.scenario)
    changes = {"pose": case.pose, "robot": "kinematic", "events": ()}
    scenario = scenario.model_copy(update=changes)
    with Recorder(folder) as recorder:
        run(scenario, seed=case.seed, observers=[recorder])
    return open_run(folder)


@dataclass(frozen=True)
class _Inputs:
    """All that a navigator was given, as arrays with one row per tick."""

    ranges: NDArray[np.float64]
    wheels: NDArray[np.float64]
    gyro: NDArray[np.float64]
    dt_s: NDArray[np.float64]
    poses: NDArray[np.float64]
    goals: list[tuple[int, float, float]]
    commands: NDArray[np.float64]


def _inputs(made: Run, robot: str) -> _Inputs:
    rows: dict[str, list[Any]] = {"ranges": [], "wheels": [], "gyro": [], "dt": [], "pose": []}
    goals = []
    for line in made.inputs(robot):
        if line["call"] == "set_goal":
            goals.append((len(rows["dt"]), *map(float, line["goal"])))
        elif line["call"] == "step":
            rows["ranges"].append(line["ranges_m"])
            rows["wheels"].append(line["wheels_m"])
            rows["gyro"].append(np.nan if line["gyro_radps"] is None else line["gyro_radps"])
            rows["dt"].append(line["dt_s"])
            rows["pose"].append(line["world_from_robot"] or [np.nan] * 3)
    commands = [tuple(tick["decision"]["twist"].values()) for tick in made.ticks(robot)]
    arrays = (np.array(values, float) for values in rows.values())
    return _Inputs(*arrays, goals=goals, commands=np.array(commands))


def _measured(case: Case, made: Run, rounds: int, folder: Path) -> Measured:
    robot = made.robots[0]
    inputs = _inputs(made, robot)

    def play(record: Path | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        navigator = Navigator.from_recipe(made.made_of[robot], made.map(robot))
        given = (inputs.ranges, inputs.wheels, inputs.gyro, inputs.dt_s, inputs.poses)
        return _brain.time_ticks(navigator._brain, *given, inputs.goals, record)

    same, plain, beside, done = True, [], [], np.empty((0, 4))
    for _ in range(rounds):
        for record, times in ((None, plain), (folder / "again.mcap", beside)):
            took, done = play(record)
            same &= bool(np.array_equal(done[:, :2], inputs.commands))
            times.append(took / 1e3)
    planned = done[:, 2] == 1
    drives = ~planned
    quickest = np.min(plain, axis=0)
    with_log = np.min(beside, axis=0)
    tick = quickest[:, : len(PARTS)].sum(axis=1)
    raw = np.concatenate([times[drives, : len(PARTS)].sum(axis=1) for times in plain])
    log = with_log[drives, len(PARTS)]
    return Measured(
        case=case,
        ticks=int(drives.sum()),
        plans=int(planned.sum()),
        same=same,
        tick_us=_percentiles(tick[drives]),
        raw_us=_percentiles(raw),
        parts_us={name: _percentiles(quickest[drives, i]) for i, name in enumerate(PARTS)},
        modes_us={
            name: _percentiles(tick[drives & (done[:, 3] == i)])
            for i, name in enumerate(MODES)
            if (drives & (done[:, 3] == i)).any()
        },
        log_us=_percentiles(log),
        share=float(np.median(log) / np.median(tick[drives])),
        beside_us=_percentiles(with_log[drives].sum(axis=1)),
        plan_ms=float(tick[planned].max() / 1e3) if planned.any() else None,
        bytes_per_tick=(folder / "again.mcap").stat().st_size / len(done),
    )


def _percentiles(times: NDArray[np.float64]) -> dict[str, float]:
    found = {f"p{p:g}": float(np.percentile(times, p)) for p in PERCENTILES}
    return {**found, "mean": float(times.mean()), "max": float(times.max())}


def summary_of(measured: list[Measured]) -> dict[str, Any]:
    """The aims, and how each came out: of the worst case that counts."""
    counted = [each for each in measured if each.case.counts]
    slowest = max((each.tick_us["p99.9"] for each in counted), default=None)
    share = max((each.share for each in counted), default=None)
    return {
        "same": all(each.same for each in measured),
        "tick_p999_us": slowest,
        "tick_aim_us": AIM_P999_US,
        "tick_met": slowest is not None and slowest <= AIM_P999_US,
        "recording_share": share,
        "recording_aim": AIM_RECORDING,
        "recording_met": share is not None and share <= AIM_RECORDING,
    }
