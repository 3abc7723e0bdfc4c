"""A run as plain data, for whatever shows it: made from its summary and its ticks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cairn.world import World

Floats = NDArray[np.float64]
MODES = ("stop", "path_planning", "path_tracking", "obstacle_avoidance")
VERDICTS = {0: "as expected", 3: "not as expected", 4: "contact"}


@dataclass
class RobotStory:
    """What one robot did, a row per tick; poses [m, m, rad] in the world frame.

    Args:
        time_s: (n,) by the run's clock.
        truth, estimate: (n, 3); truth is the estimate where nobody judged, on a real robot, say.
        sigma_m: (n,) what it believes its position to be off by, one sigma; nan where not known.
        mode, sentence: n each.
        command, measured: (n, 2) V [m/s] and ω [rad/s].
        clearance_m: (n,) of the outline by truth, inf where nothing is near.
        cost_to_go: (n,) of the field under the robot; nan without one.
        tracking, avoidance: of the decision, None where that part was not asked.
        plans: (time [s], (k, 2) points [m]) of every plan walked.
        transitions, recoveries, contacts, goals: as in the run's summary.
        judged: whether somebody knew the truth.
        echoes_m: (n, sonars) what they measured, nan or inf for none; None where not kept.
    """

    name: str
    time_s: Floats
    truth: Floats
    estimate: Floats
    sigma_m: Floats
    mode: list[str]
    sentence: list[str]
    command: Floats
    measured: Floats
    clearance_m: Floats
    cost_to_go: Floats
    tracking: list[dict[str, Any] | None]
    avoidance: list[dict[str, Any] | None]
    plans: list[tuple[float, Floats]] = field(default_factory=list)
    transitions: list[dict[str, Any]] = field(default_factory=list)
    recoveries: list[dict[str, Any]] = field(default_factory=list)
    contacts: list[dict[str, Any]] = field(default_factory=list)
    goals: list[dict[str, Any]] = field(default_factory=list)
    judged: bool = True
    echoes_m: Floats | None = None

    @property
    def off_m(self) -> Floats:
        """(n,) distance between where it was and where it believed to be [m]."""
        return np.hypot(*(self.truth - self.estimate)[:, :2].T)

    def pieces(self) -> list[tuple[str, slice]]:
        """Cut the run where the mode changes: (mode, ticks)."""
        cuts = [0, *(n for n in range(1, len(self.mode)) if self.mode[n] != self.mode[n - 1])]
        ends = [*cuts[1:], len(self.mode)]
        return [(self.mode[a], slice(a, b)) for a, b in zip(cuts, ends, strict=True)]

    def at(self, time_s: float) -> int:
        """Number of the last tick at or before a time."""
        return max(int(np.searchsorted(self.time_s, time_s + 1e-9, side="right")) - 1, 0)


@dataclass
class Story:
    """A whole run: what it was, where, and what every robot did.

    Args:
        summary: the record of the run (`summary.json`); partly empty for one that was cut off.
        scenario: as run.
        known: the map the robots were given, None without one.
        world: what really stands there, boxes apart; None where that is not known any more.
        outline_m: (length, width) of the robots.
        limits: V [m/s] and ω [rad/s] at most.
        sonars: (x, y, heading, full angle of the cone) of each in the robot frame [m, rad].
    """

    summary: dict[str, Any]
    scenario: dict[str, Any]
    known: World | None
    world: World | None
    outline_m: tuple[float, float]
    limits: tuple[float, float]
    robots: list[RobotStory]
    sonars: list[tuple[float, float, float, float]] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Of the scenario."""
        return str(self.scenario.get("name", "run"))

    @property
    def headline(self) -> dict[str, Any]:
        """The numbers of the whole run, as in `summary.json`."""
        return self.summary.get("summary", {})

    @property
    def verdict(self) -> str:
        """The outcome in two words."""
        if "exit_code" not in self.headline:
            return "cut off"
        return VERDICTS.get(self.headline["exit_code"], "ended")

    @property
    def duration_s(self) -> float:
        """From the first tick to the last."""
        return max((float(robot.time_s[-1]) for robot in self.robots), default=0.0)

    @property
    def view(self) -> tuple[float, float, float, float]:
        """(x0, x1, y0, y1) of what is worth showing [m]: all that is known, and every way."""
        points = [robot.truth[:, :2] for robot in self.robots]
        for world in (self.known, self.world):
            if world is not None:
                points.append(_corners(world))
        whole = np.vstack(points)
        margin = 0.015 * float(np.ptp(whole, axis=0).max()) + 0.1
        (x0, y0), (x1, y1) = whole.min(axis=0) - margin, whole.max(axis=0) + margin
        return float(x0), float(x1), float(y0), float(y1)


def tell(
    summary: Mapping[str, Any] | None,
    scenario: Mapping[str, Any],
    ticks: Iterable[Mapping[str, Any]],
    *,
    known: World | None = None,
    world: World | None = None,
    plans: Mapping[str, Sequence[tuple[float, Floats]]] | None = None,
    outline_m: tuple[float, float] = (0.626, 0.505),
    limits: tuple[float, float] = (0.7, 2.44),
    sonars: Sequence[tuple[float, float, float, float]] = (),
    echoes: Mapping[str, Mapping[int, Sequence[float]]] | None = None,
) -> Story:
    """Make a story of a run's summary and ticks.

    Args:
        summary: `summary.json`, None for a run that was cut off: then transitions, recoveries are
            taken from the ticks.
        scenario: as run.
        ticks: `{"time_s", "robot", "truth", "clearance_m", "decision"}`, see
            `cairn.record.open_run`.
        known, world, outline_m, limits, sonars: see `Story`.
        plans: of every robot, see `RobotStory`.
        echoes: of every robot, by the number of the tick; of `sonars`, further ranges are left out.

    Raises:
        ValueError: there is not one tick.
    """
    rows: dict[str, list[Mapping[str, Any]]] = {}
    for tick in ticks:
        rows.setdefault(tick["robot"], []).append(tick)
    if not rows:
        raise ValueError("a run without one tick has no story")
    told = {robot["name"]: robot for robot in (summary or {}).get("robots", [])}
    robots = [
        _robot(name, own, told.get(name), list((plans or {}).get(name, ())))
        for name, own in rows.items()
    ]
    for robot in robots:
        robot.echoes_m = _echoes(rows[robot.name], (echoes or {}).get(robot.name), len(sonars))
    return Story(
        dict(summary or {}), dict(scenario), known, world, outline_m, limits, robots, list(sonars)
    )


def _echoes(
    rows: list[Mapping[str, Any]], measured: Mapping[int, Sequence[float]] | None, sonars: int
) -> Floats | None:
    if not measured or not sonars:
        return None
    echoes = np.full((len(rows), sonars), np.nan)
    for number, row in enumerate(rows):
        ranges = measured.get(row["decision"]["tick"])
        if ranges is not None and len(ranges) >= sonars:
            echoes[number] = ranges[:sonars]
    return echoes


def _robot(
    name: str,
    rows: list[Mapping[str, Any]],
    told: Mapping[str, Any] | None,
    plans: list[tuple[float, Floats]],
) -> RobotStory:
    decisions = [row["decision"] for row in rows]
    robot = RobotStory(
        name=name,
        time_s=_floats(row["time_s"] for row in rows),
        truth=np.array([_judged(row) for row in rows], float),
        estimate=np.array([_pose(d["pose"]) for d in decisions], float),
        sigma_m=_floats(_sigma(d.get("covariance")) for d in decisions),
        mode=[d["mode"] for d in decisions],
        sentence=[d["sentence"] for d in decisions],
        command=np.array([_twist(d["twist"]) for d in decisions], float),
        measured=np.array([_twist(d.get("measured")) for d in decisions], float),
        clearance_m=_floats(
            math.inf if row["clearance_m"] is None else row["clearance_m"] for row in rows
        ),
        cost_to_go=_floats(
            math.nan if d.get("cost_to_go") is None else d["cost_to_go"] for d in decisions
        ),
        tracking=[d.get("tracking") for d in decisions],
        avoidance=[d.get("avoidance") for d in decisions],
        plans=plans,
        judged=all(row["truth"] is not None for row in rows),
    )
    if told is None:
        robot.transitions = _transitions(rows)
        robot.recoveries = _recoveries(rows)
        return robot
    robot.transitions = list(told.get("transitions", []))
    robot.recoveries = list(told.get("recoveries", []))
    robot.contacts = list(told.get("contacts", []))
    robot.goals = list(told.get("goals", []))
    return robot


def _transitions(rows: list[Mapping[str, Any]]) -> list[dict[str, Any]]:
    found = []
    for before, row in itertools.pairwise(rows):
        old, new = before["decision"], row["decision"]
        if old["mode"] != new["mode"]:
            found.append(
                {
                    "time_s": row["time_s"],
                    "from": old["mode"],
                    "to": new["mode"],
                    "event": new["event"],
                    "reason": new["reason"],
                    "sentence": new["sentence"],
                    "at_m": list(row["truth"][:2]),
                }
            )
    return found


def _recoveries(rows: list[Mapping[str, Any]]) -> list[dict[str, Any]]:
    found = []
    for row in rows:
        recovery = row["decision"].get("recovery")
        if recovery is not None:
            cause = dict(recovery["cause"])
            code = cause.pop("code")
            remedy = recovery["remedy"]
            found.append({"time_s": row["time_s"], "cause": code, "remedy": remedy, **cause})
    return found


def _sigma(covariance: Any) -> float:
    """Largest standard deviation of the position [m]."""
    if covariance is None:
        return math.nan
    part = np.array([[math.nan if v is None else v for v in row[:2]] for row in covariance[:2]])
    if not np.isfinite(part).all():
        return math.nan
    return math.sqrt(max(float(np.linalg.eigvalsh(part)[-1]), 0.0))


def _judged(row: Mapping[str, Any]) -> tuple[float, float, float]:
    """Where the robot was by truth; by its own estimate where nobody judged."""
    if row["truth"] is None:
        return _pose(row["decision"]["pose"])
    x, y, heading = row["truth"]
    return (x, y, heading)


def _pose(pose: Mapping[str, float]) -> tuple[float, float, float]:
    return (pose["x"], pose["y"], pose["heading"])


def _twist(twist: Mapping[str, Any] | None) -> tuple[float, float]:
    if twist is None:
        return (math.nan, math.nan)
    linear, angular = twist["linear_mps"], twist["angular_radps"]
    return (
        math.nan if linear is None else linear,
        math.nan if angular is None else angular,
    )


def _floats(values: Iterable[float]) -> Floats:
    return np.fromiter(values, float)


def _corners(world: World) -> Floats:
    """The part of a map that is not unknown, by its corners [m]."""
    rows, cols = np.nonzero(np.asarray(world.occupancy) != 2)
    if len(rows) == 0:
        x0, x1, y0, y1 = world.extent
        return np.array([[x0, y0], [x1, y1]])
    ends = np.array([[r, c] for r in (rows.min(), rows.max()) for c in (cols.min(), cols.max())])
    return np.asarray(world.point_of(ends), float)
