"""What comes out of a run. Everything here follows from the seed; wall times are kept apart."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from cairn.missions.traps import Trap, traps
from cairn.strict_json import plain

if TYPE_CHECKING:
    from cairn.missions.scenario import Scenario
    from cairn.world import World

REACHED = "reached"
REFUSED = "refused"
MISSED = "missed"  # the robot says it has arrived, the truth says otherwise
CANCELLED = "cancelled"  # called off by an event of the scenario
REPLACED = "replaced"  # by a new goal on the way, an event of the scenario
TIMED_OUT = "timed_out"
EXPLORED = "explored"
ABANDONED = "abandoned"  # the run was ended by hand before it was over

EXIT_OK = 0
EXIT_USAGE = 2
EXIT_NOT_REACHED = 3
EXIT_CONTACT = 4


def tidy(value: Any) -> Any:
    """Return `value` as strict JSON, to 6 decimals."""
    return plain(value, decimals=6)


def called(place: str | None, goal: tuple[float, float] | None) -> str:
    """Return what a person calls a goal: a place, a point [m], or to explore."""
    if place is not None:
        return place
    return "to explore" if goal is None else f"({goal[0]:.2f}, {goal[1]:.2f}) m"


@dataclass(frozen=True)
class Transition:
    """A change of mode: when, from what to what, and why."""

    time_s: float
    before: str
    after: str
    event: str  # code of what was perceived
    reason: str  # code of why
    sentence: str
    at: tuple[float, float]  # by truth [m, world frame]

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return tidy(
            {
                "time_s": self.time_s,
                "from": self.before,
                "to": self.after,
                "event": self.event,
                "reason": self.reason,
                "sentence": self.sentence,
                "at_m": self.at,
            }
        )


@dataclass(frozen=True)
class Recovered:
    """Something went wrong: when, what, and what the navigator did about it."""

    time_s: float
    cause: str
    remedy: str
    detail: dict[str, Any]  # the numbers of the cause

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return tidy(
            {"time_s": self.time_s, "cause": self.cause, "remedy": self.remedy, **self.detail}
        )


@dataclass
class GoalResult:
    """How one goal of one robot ended, judged by truth."""

    goal: tuple[float, float] | None  # None: exploration
    place: str | None
    expected: str
    outcome: str
    sentence: str
    started_s: float
    ended_s: float
    error_m: float | None  # distance from the goal by truth at the end
    path_length_m: float  # driven, by truth
    planned_length_m: float | None  # of the first plan to this goal

    @property
    def as_expected(self) -> bool:
        """Whether it ended as the scenario expects, or as one of its events asked."""
        return self.outcome in (self.expected, EXPLORED, CANCELLED, REPLACED)

    @property
    def is_refused(self) -> bool:
        """Whether the robot said that it cannot be done."""
        return self.outcome == REFUSED

    @property
    def called(self) -> str:
        """The place, or the point, or that it was to explore."""
        return called(self.place, self.goal)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return tidy(
            {
                "goal_m": self.goal,
                "place": self.place,
                "expected": self.expected,
                "outcome": self.outcome,
                "as_expected": self.as_expected,
                "sentence": self.sentence,
                "started_s": self.started_s,
                "ended_s": self.ended_s,
                "error_m": self.error_m,
                "path_length_m": self.path_length_m,
                "planned_length_m": self.planned_length_m,
            }
        )


@dataclass
class Trace:
    """What one robot did, one row per tick of the run; for pictures and reports."""

    time_s: list[float] = field(default_factory=list)
    truth: list[tuple[float, float, float]] = field(default_factory=list)
    estimate: list[tuple[float, float, float]] = field(default_factory=list)
    mode: list[str] = field(default_factory=list)
    twist: list[tuple[float, float]] = field(default_factory=list)
    clearance_m: list[float] = field(default_factory=list)
    plans: list[np.ndarray] = field(default_factory=list)  # (n, 2) [m, world frame], in order


@dataclass
class RobotResult:
    """What one robot did."""

    name: str
    goals: list[GoalResult]
    transitions: list[Transition]
    recoveries: list[Recovered]
    contacts: list[dict[str, Any]]
    plan_count: int
    path_length_m: float
    planned_length_m: float | None
    least_clearance_m: float
    drift_end_m: float
    drift_max_m: float
    drift_end_rad: float
    modes_s: dict[str, float]
    effort: dict[str, float]
    trace: Trace

    @property
    def traps(self) -> list[Trap]:
        """Where it could not go on as it did, and how long until it was out."""
        return traps(self.recoveries, self.trace.time_s, self.trace.truth)

    @property
    def sentence(self) -> str:
        """The first goal that did not end as expected; else expected refusals and the last goal."""
        if not self.goals:
            return "no goal was given"
        *earlier, last = self.goals
        wrong = next((goal for goal in self.goals if not goal.as_expected), None)
        if wrong is not None:
            return wrong.sentence.rstrip(".")
        refused = [f"refused {goal.called} as expected" for goal in earlier if goal.is_refused]
        return "; ".join([*refused, last.sentence.rstrip(".")])

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON, without the trace."""
        return tidy(
            {
                "name": self.name,
                "goals": [goal.to_dict() for goal in self.goals],
                "plan_count": self.plan_count,
                "path_length_m": self.path_length_m,
                "planned_length_m": self.planned_length_m,
                "least_clearance_m": self.least_clearance_m,
                "contacts": self.contacts,
                "drift": {
                    "end_m": self.drift_end_m,
                    "max_m": self.drift_max_m,
                    "end_rad": self.drift_end_rad,
                },
                "modes_s": self.modes_s,
                "effort": self.effort,
                "transitions": [transition.to_dict() for transition in self.transitions],
                "recoveries": [recovered.to_dict() for recovered in self.recoveries],
                "traps": [trap.to_dict() for trap in self.traps],
            }
        )


@dataclass
class Result:
    """The result of one run of a scenario with one seed."""

    scenario: Scenario
    seed: int
    version: str
    config_hash: str
    time_s: float
    robots: list[RobotResult]
    unmet: list[str]  # expectations of the scenario that the run did not meet, as sentences
    wall: dict[str, float]
    map: World | None  # what the robots were given
    world: World  # what really stands there, boxes apart

    @property
    def contacts(self) -> int:
        """How many times a robot touched something."""
        return sum(len(robot.contacts) for robot in self.robots)

    @property
    def reached(self) -> bool:
        """Whether every robot ended every goal as the scenario expects, by truth."""
        return all(goal.as_expected for robot in self.robots for goal in robot.goals)

    @property
    def exit_code(self) -> int:
        """0 all as expected, 3 something was not, 4 a robot touched something."""
        if self.contacts:
            return EXIT_CONTACT
        return EXIT_OK if self.reached and not self.unmet else EXIT_NOT_REACHED

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        several = len(self.robots) > 1
        parts = []
        for robot in self.robots:
            who = f"{robot.name}: " if several else ""
            parts.append(who + robot.sentence)
        if self.contacts:
            parts.insert(
                0, "touched something" + (f" {self.contacts} times" if self.contacts > 1 else "")
            )
        parts += [sentence.rstrip(".") for sentence in self.unmet]
        return "; ".join(parts) + "."

    def summary(self) -> dict[str, Any]:
        """Return the headline numbers: of the first robot where each has its own."""
        first = self.robots[0]
        ends = [goal for robot in self.robots for goal in robot.goals]
        trapped_s = [trap.seconds for robot in self.robots for trap in robot.traps]
        errors = [goal.error_m for goal in ends if goal.error_m is not None]
        return tidy(
            {
                "scenario": self.scenario.name,
                "seed": self.seed,
                "reached": self.reached,
                "exit_code": self.exit_code,
                "sentence": self.sentence,
                "goals": len(ends),
                "goals_as_expected": sum(goal.as_expected for goal in ends),
                "time_s": self.time_s,
                "path_length_m": sum(robot.path_length_m for robot in self.robots),
                "planned_length_m": first.planned_length_m,
                "arrival_error_m": errors[-1] if errors else None,
                "least_clearance_m": min(robot.least_clearance_m for robot in self.robots),
                "contacts": self.contacts,
                "drift_m": max(robot.drift_end_m for robot in self.robots),
                "drift_max_m": max(robot.drift_max_m for robot in self.robots),
                "plan_count": sum(robot.plan_count for robot in self.robots),
                "transitions": sum(len(robot.transitions) for robot in self.robots),
                "recoveries": sum(len(robot.recoveries) for robot in self.robots),
                "traps": len(trapped_s),
                "trapped_most_s": max(trapped_s, default=0.0),
            }
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the record of the run; two of one seed are equal but for the key `wall`."""
        return {
            "summary": self.summary(),
            "version": self.version,
            "config_hash": self.config_hash,
            "unmet": list(self.unmet),
            "robots": [robot.to_dict() for robot in self.robots],
            "scenario": tidy(self.scenario.model_dump(mode="json", exclude_none=True)),
            "wall": tidy(self.wall),
        }
