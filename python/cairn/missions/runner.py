"""Scenario → run → result: ten times a second, every robot senses, decides and moves.

The navigators get readings only (and the true pose where the scenario says so); arrival, contact
and clearance are judged by truth.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

import cairn
from cairn.missions import result as outcomes
from cairn.missions.result import GoalResult, Recovered, Result, RobotResult, Trace, Transition
from cairn.missions.scenario import (
    Cancel,
    EmergencyStop,
    Event,
    Goal,
    Hold,
    NewGoal,
    Scenario,
    Shove,
)
from cairn.missions.setting import Agent, Pose, Setting, build, length_m, way_left_m

TICK_S = 0.1
REST_MPS, REST_RADPS = 0.02, 0.05  # by truth: below these a robot counts as standing
REST_PATIENCE_S = 3.0


@dataclass(frozen=True)
class Tick:
    """What observers of a run see of one robot at one tick."""

    time_s: float
    robot: str
    truth: Pose
    decision: Any
    goal: tuple[float, float] | None
    distance_to_go_m: float | None  # along the plan where there is one
    clearance_m: float
    explored: float | None  # share of the time to explore that is over


Observer = Callable[[Tick], None]


def run(
    scenario: Scenario,
    *,
    seed: int | None = None,
    observers: Iterable[Observer] = (),
    setting: Callable[[Scenario, int], Setting] = build,
) -> Result:
    """Run a scenario once.

    Args:
        scenario: what to do, where.
        seed: of everything random; by default the scenario's own.
        observers: called with every robot's `Tick`; one with a method `begin` is first told
            (scenario, seed, setting).
        setting: builds world, robots and navigators.

    Returns:
        The result, judged by truth. Two runs with one seed differ in `wall` only.

    Raises:
        CairnError: the scenario names things that do not exist or do not fit together.
    """
    seed = scenario.seed if seed is None else seed
    began = time.perf_counter()
    scene = setting(scenario, seed)
    built = time.perf_counter()
    loop = Loop(scenario, scene, list(observers), seed)
    loop.play()
    return loop.result(seed, build_s=built - began, run_s=time.perf_counter() - built)


class Loop:
    """One run: the clock, the events, and a follower for each robot."""

    def __init__(
        self, scenario: Scenario, setting: Setting, observers: list[Observer], seed: int
    ) -> None:
        """Begin at time zero; observers with a method `begin` are told of what."""
        self.config_hash = scenario.config_hash()
        scenario = scenario.model_copy(update={"pose": scenario.pose or setting.pose})
        self.scenario, self.setting, self.observers = scenario, setting, observers
        for observer in observers:
            if (begin := getattr(observer, "begin", None)) is not None:
                begin(scenario, seed, setting)
        leader = Follower(setting.agents[0], scenario, setting, None)
        others = [Follower(agent, scenario, setting, leader) for agent in setting.agents[1:]]
        self.followers = [leader, *others]
        self.events = list(scenario.events)
        self.ticks = 0
        self.deciding_s = self.slowest_s = 0.0
        self.decisions = 0

    @property
    def time_s(self) -> float:
        """Simulated time that has passed."""
        return round(self.ticks * TICK_S, 6)

    @property
    def done(self) -> bool:
        """Whether every robot has done its goals."""
        return all(follower.done for follower in self.followers)

    def play(self) -> None:
        """Run until every robot has done its goals, or the time is up."""
        while self.time_s < self.scenario.timeout_s:
            self.decide()
            if self.done:
                break
            self.move()
        self.close()

    def decide(self) -> None:
        """First half of a tick: what is due happens, every robot senses, decides and commands."""
        self._let_happen()
        for follower in self.followers:
            self._step(follower)

    def move(self) -> None:
        """Second half of a tick: time passes."""
        for follower in self.followers:
            follower.agent.robot.advance(TICK_S)
        self.ticks += 1
        self._meet()

    def close(self) -> None:
        """End the run: what is still open is out of time."""
        for follower in self.followers:
            follower.time_up(self.time_s)

    def result(self, seed: int, *, build_s: float, run_s: float) -> Result:
        """Sum up; wall times are the caller's."""
        robots = [follower.result() for follower in self.followers]
        return Result(
            scenario=self.scenario,
            seed=seed,
            version=cairn.__version__,
            config_hash=self.config_hash,
            time_s=self.time_s,
            robots=robots,
            unmet=_unmet(self.scenario, robots),
            wall={
                "build_s": build_s,
                "run_s": run_s,
                "decide_mean_ms": 1e3 * self.deciding_s / max(self.decisions, 1),
                "decide_max_ms": 1e3 * self.slowest_s,
                "real_time_factor": self.time_s / max(run_s, 1e-9),
            },
            map=self.setting.known,
            world=self.setting.world,
        )

    def _step(self, follower: Follower) -> None:
        began = time.perf_counter()
        tick = follower.step(self.time_s)
        took = time.perf_counter() - began
        self.deciding_s += took
        self.slowest_s = max(self.slowest_s, took)
        self.decisions += 1
        for observe in self.observers:
            observe(tick)

    def _let_happen(self) -> None:
        """Apply the events that are due, each once."""
        for event in [event for event in self.events if self._is_due(event)]:
            self.events.remove(event)
            self.followers[event.robot].happens(event, self.time_s)

    def _meet(self) -> None:
        """Note how near robots are to each other, and where they overlap."""
        for i, one in enumerate(self.followers):
            for other in self.followers[:i]:
                apart_m = _apart_m(one.agent.robot, other.agent.robot)
                one.met(other.agent.name, apart_m, self.time_s)
                other.met(one.agent.name, apart_m, self.time_s)

    def _is_due(self, event: Event) -> bool:
        follower = self.followers[event.robot]
        return (
            (event.at_s is None or self.time_s >= event.at_s)
            and (event.at_distance_m is None or follower.driven_m >= event.at_distance_m)
            and (event.when_mode is None or follower.is_in(event.when_mode, event.mode_for_s))
        )


@dataclass
class _Under:
    """The task under way."""

    task: Goal | NewGoal
    goal: tuple[float, float] | None
    started_s: float
    driven_at_start_m: float
    plans_at_start: int
    ending: tuple[str, str] | None = None  # outcome and sentence, once the robot says it is over
    ending_s: float = 0.0

    @property
    def explore_s(self) -> float | None:
        return self.task.explore_s if isinstance(self.task, Goal) else None


class Follower:
    """Takes one robot through its tasks and keeps account of it.

    The first robot leads: the field it plans to a goal serves the others that share the goal.
    """

    def __init__(
        self, agent: Agent, scenario: Scenario, setting: Setting, leader: Follower | None
    ) -> None:
        self.agent, self.scenario, self.setting = agent, scenario, setting
        self.leader = leader
        self.fields: dict[tuple[float, float], Any] = {}  # planned by this robot, by goal
        self.waiting: list[Goal | NewGoal] = list(agent.tasks)
        self.under: _Under | None = None
        self.goals: list[GoalResult] = []
        self.transitions: list[Transition] = []
        self.recoveries: list[Recovered] = []
        self.trace = Trace()
        self.driven_m = 0.0
        self.last: Pose | None = None
        self.apart_m: dict[str, float] = {}
        self.touching: set[str] = set()
        self.meetings: list[dict[str, Any]] = []
        self.sentence = ""
        self.readings: Any = None  # `cairn.robots.Readings` of the last tick
        self.decision: Any = None
        self.free_since_s = 0.0  # of tasks

    @property
    def done(self) -> bool:
        """Whether there is nothing under way and nothing waiting."""
        return self.under is None and not self.waiting

    @property
    def heading_for(self) -> tuple[float, float] | None:
        """The goal under way, or the one to be taken at once."""
        if self.under is not None:
            return self.under.goal
        task = self.waiting[0] if self.waiting else None
        if task is None or (isinstance(task, Goal) and (task.explore_s or task.wait_s)):
            return None
        return self.setting.point_of(task)

    def is_in(self, mode: str, for_s: float) -> bool:
        """Whether the navigator is in that mode, and has been for that long."""
        ticks = max(math.ceil(for_s / TICK_S - 1e-9), 1)
        return self.trace.mode[-ticks:] == [mode] * ticks

    def step(self, time_s: float) -> Tick:
        """One tick: measure by truth, take a task if free, sense, decide, command, judge."""
        robot, navigator = self.agent.robot, self.agent.navigator
        truth = _pose(robot.truth)
        if self.last is not None:
            self.driven_m += math.dist(truth[:2], self.last[:2])
        self.last = truth
        if self.under is None and self.waiting and self._may_begin(time_s):
            self._take(self.waiting.pop(0), time_s)
        readings = robot.sense()
        decision = navigator.step(
            readings.ranges_m,
            readings.wheels_m,
            readings.gyro_radps,
            TICK_S,
            world_from_robot=truth if self.scenario.pose == "truth" else None,
        )
        robot.command(decision.twist)
        self.readings, self.decision = readings, decision
        self.sentence = str(decision.sentence)
        self._offer_field()
        clearance_m = min([float(robot.clearance_m), *self.apart_m.values()])
        self._keep(time_s, truth, decision, clearance_m)
        tick = self._tick(time_s, truth, decision, clearance_m)
        self._judge(time_s, truth, decision)
        return tick

    def happens(self, event: Event, time_s: float) -> None:
        """Apply an event of the scenario to this robot."""
        if isinstance(event, Shove):
            self.agent.robot.shove(event.dx_m, event.dy_m, event.dheading_rad)
            self.last = _pose(self.agent.robot.truth)  # a shove is not driving
        elif isinstance(event, EmergencyStop):
            self.agent.robot.emergency_stop(event.for_s)
        elif isinstance(event, Hold):
            self.agent.robot.hold(event.half_width_m)
        elif isinstance(event, Cancel):
            if self.under is not None:
                self.agent.navigator.cancel()
                self._end_soon(outcomes.CANCELLED, "called off on the way", time_s)
        else:
            self.order(event, time_s)

    def order(self, task: Goal | NewGoal, time_s: float) -> None:
        """Give it a task that comes before all others; it replaces one under way."""
        if self.under is not None:
            self._close(
                outcomes.REPLACED, "replaced by a new goal on the way", time_s, _pose(self.last)
            )
            self._take(task, time_s)
        else:
            self.waiting.insert(0, task)

    def abandon(self, time_s: float) -> None:
        """Leave off: nobody waits for its tasks any more."""
        if self.under is not None:
            self.agent.navigator.cancel()
            why = f"; last: {_without_mode(self.sentence)}" if self.sentence else ""
            self._close(
                outcomes.ABANDONED, f"the run was ended on the way{why}", time_s, _pose(self.last)
            )
        while self.waiting:
            self._take(self.waiting.pop(0), time_s, begin=False)
            self._close(
                outcomes.ABANDONED, "not begun when the run was ended", time_s, _pose(self.last)
            )

    def give_up(self, time_s: float, limit_s: float) -> None:
        """Call off a task that has been under way for longer than `limit_s`."""
        under = self.under
        if under is None or under.ending is not None or time_s - under.started_s < limit_s:
            return
        self.agent.navigator.cancel()
        self._end_soon(outcomes.TIMED_OUT, f"given up after {limit_s:g} s", time_s)

    def met(self, name: str, apart_m: float, time_s: float) -> None:
        """Take note of how far another robot's outline is."""
        self.apart_m[name] = apart_m
        if apart_m > 0:
            self.touching.discard(name)
        elif name not in self.touching:
            self.touching.add(name)
            self.meetings.append({"time_s": time_s, "name": name})

    def time_up(self, time_s: float) -> None:
        """Close what is still open when the time is up."""
        truth = _pose(self.last)
        limit = f"{self.scenario.timeout_s:g} s"
        if self.under is not None:
            goal = self.under.goal
            left = f", {math.dist(truth[:2], goal):.2f} m short" if goal else ""
            why = f"; last: {_without_mode(self.sentence)}" if self.sentence else ""
            self._close(outcomes.TIMED_OUT, f"out of time after {limit}{left}{why}", time_s, truth)
        while self.waiting:
            self._take(self.waiting.pop(0), time_s, begin=False)
            self._close(outcomes.TIMED_OUT, f"not begun within {limit}", time_s, truth)

    def _take(self, task: Goal | NewGoal, time_s: float, *, begin: bool = True) -> None:
        exploring = isinstance(task, Goal) and task.explore_s is not None
        goal = None if exploring else self.setting.point_of(task)
        navigator = self.agent.navigator
        self.under = _Under(task, goal, time_s, self.driven_m, navigator.plan_count)
        if not begin:
            return
        if goal is None:
            navigator.explore()
        else:
            navigator.set_goal(goal, field=self.leader.fields.get(goal) if self.leader else None)

    def _may_begin(self, time_s: float) -> bool:
        """Whether its wait is over, and the field of a shared goal is there or will never be."""
        task, number = self.waiting[0], len(self.goals)
        if isinstance(task, Goal) and time_s - self.free_since_s < task.wait_s:
            return False
        if self.leader is None or number >= len(self.scenario.goals):
            return True
        exploring = isinstance(task, Goal) and task.explore_s is not None
        goal = None if exploring else self.setting.point_of(task)
        return goal is None or goal in self.leader.fields or len(self.leader.goals) > number

    def _offer_field(self) -> None:
        """Keep the first field planned to the goal under way, for the others."""
        under, navigator = self.under, self.agent.navigator
        if under is None or under.goal is None or under.goal in self.fields:
            return
        if navigator.plan_count > under.plans_at_start and navigator.field is not None:
            self.fields[under.goal] = navigator.field

    def _judge(self, time_s: float, truth: Pose, decision: Any) -> None:
        """Close the task under way once the robot says it is over and stands still."""
        under = self.under
        if under is None:
            return
        if under.ending is None:
            self._listen(under, time_s, decision)
        if under.ending is None:
            return
        standing = decision.mode == "stop" and _is_slow(self.agent.robot.velocity)
        if standing or time_s - under.ending_s > REST_PATIENCE_S:
            outcome, sentence = under.ending
            self._close(outcome, sentence, time_s, truth)

    def _listen(self, under: _Under, time_s: float, decision: Any) -> None:
        if under.explore_s is not None and time_s - under.started_s >= under.explore_s:
            self.agent.navigator.cancel()
            self._end_soon(outcomes.EXPLORED, f"explored for {under.explore_s:g} s", time_s)
            return
        if decision.goal_status == "reached" and under.goal is None:
            self._end_soon(outcomes.EXPLORED, "nothing left to explore", time_s)
        elif decision.goal_status == "reached":
            self._end_soon(outcomes.REACHED, "", time_s)
        elif decision.goal_status == "refused":
            self._end_soon(outcomes.REFUSED, "", time_s)

    def _end_soon(self, outcome: str, sentence: str, time_s: float) -> None:
        assert self.under is not None
        self.under.ending, self.under.ending_s = (outcome, sentence), time_s

    def _close(self, outcome: str, sentence: str, time_s: float, truth: Pose) -> None:
        under = self.under
        assert under is not None
        error_m = None if under.goal is None else math.dist(truth[:2], under.goal)
        name = outcomes.called(under.task.place, under.goal)
        if outcome == outcomes.REFUSED:
            sentence = f"refused {name}: {_without_mode(self.sentence)}"
        if outcome == outcomes.REACHED:
            assert error_m is not None
            sentence = f"reached {name}, {error_m:.2f} m from it by truth"
            if error_m > self.scenario.arrival_tolerance_m:
                outcome = outcomes.MISSED
                sentence = (
                    f"says it reached {name}, but stands {error_m:.2f} m from it by truth"
                    f" (allowed {self.scenario.arrival_tolerance_m:g} m)"
                )
        self.goals.append(
            GoalResult(
                goal=under.goal,
                place=under.task.place,
                expected=under.task.expect if isinstance(under.task, Goal) else outcomes.REACHED,
                outcome=outcome,
                sentence=sentence,
                started_s=under.started_s,
                ended_s=time_s,
                error_m=error_m,
                path_length_m=self.driven_m - under.driven_at_start_m,
                planned_length_m=self._planned_length_m(under.plans_at_start),
            )
        )
        self.under = None
        self.free_since_s = time_s

    def _keep(self, time_s: float, truth: Pose, decision: Any, clearance_m: float) -> None:
        trace, mode = self.trace, str(decision.mode)
        before = trace.mode[-1] if trace.mode else None
        if before is not None and mode != before:
            self.transitions.append(
                Transition(
                    time_s=time_s,
                    before=before,
                    after=mode,
                    event=str(decision.event),
                    reason=str(decision.reason),
                    sentence=str(decision.sentence),
                    at=(truth[0], truth[1]),
                )
            )
        recovery = getattr(decision, "recovery", None)
        if recovery is not None:
            detail = dict(recovery["cause"])
            self.recoveries.append(
                Recovered(time_s, detail.pop("code"), recovery["remedy"], detail)
            )
        trace.time_s.append(time_s)
        trace.truth.append(truth)
        trace.estimate.append(_pose(decision.pose))
        trace.mode.append(mode)
        trace.twist.append((decision.twist.linear_mps, decision.twist.angular_radps))
        trace.clearance_m.append(clearance_m)
        if self.agent.navigator.plan_count > len(trace.plans):
            path = self.agent.navigator.path
            plan = np.empty((0, 2)) if path is None else np.array(path, dtype=float)
            missing = self.agent.navigator.plan_count - len(trace.plans)
            trace.plans += [np.empty((0, 2))] * (missing - 1) + [plan]

    def _tick(self, time_s: float, truth: Pose, decision: Any, clearance_m: float) -> Tick:
        goal = self.under.goal if self.under else None
        explored = None
        if self.under and self.under.explore_s:
            explored = min((time_s - self.under.started_s) / self.under.explore_s, 1.0)
        to_go = None if goal is None else way_left_m(self.agent.navigator.path, truth, goal)
        return Tick(time_s, self.agent.name, truth, decision, goal, to_go, clearance_m, explored)

    def _planned_length_m(self, plans_before: int) -> float | None:
        plans = [plan for plan in self.trace.plans[plans_before:] if len(plan) > 1]
        return length_m(plans[0]) if plans else None

    def result(self) -> RobotResult:
        """Sum up what this robot did."""
        trace = self.trace
        truth, estimate = np.array(trace.truth), np.array(trace.estimate)
        apart = np.hypot(*(truth - estimate)[:, :2].T)
        twist = np.array(trace.twist)
        changes = np.abs(np.diff(twist, axis=0, prepend=[[0.0, 0.0]])).sum(axis=0)
        planned = [goal.planned_length_m for goal in self.goals if goal.planned_length_m]
        modes: dict[str, float] = {}
        for mode in trace.mode:
            modes[mode] = modes.get(mode, 0.0) + TICK_S
        return RobotResult(
            name=self.agent.name,
            goals=self.goals,
            transitions=self.transitions,
            recoveries=self.recoveries,
            contacts=[*(_contact(c, trace) for c in self.agent.robot.contacts), *self.meetings],
            plan_count=self.agent.navigator.plan_count,
            path_length_m=self.driven_m,
            planned_length_m=sum(planned) if planned else None,
            least_clearance_m=min(trace.clearance_m),
            drift_end_m=float(apart[-1]),
            drift_max_m=float(apart.max()),
            drift_end_rad=abs(math.remainder(truth[-1, 2] - estimate[-1, 2], math.tau)),
            modes_s=modes,
            effort={
                "linear_change_mps": float(changes[0]),
                "angular_change_radps": float(changes[1]),
                "mean_speed_mps": float(np.abs(twist[:, 0]).mean()),
                "mean_turn_radps": float(np.abs(twist[:, 1]).mean()),
            },
            trace=trace,
        )


def _unmet(scenario: Scenario, robots: list[RobotResult]) -> list[str]:
    """Say which expectations of the scenario the run did not meet."""
    expect = scenario.expect
    plans = sum(robot.plan_count for robot in robots)
    transitions = sum(len(robot.transitions) for robot in robots)
    driven_m = sum(robot.path_length_m for robot in robots)
    seen = {mode for robot in robots for mode in robot.modes_s}
    unmet = []
    if expect.plan_count is not None and plans != expect.plan_count:
        unmet.append(f"expected {expect.plan_count} plans, made {plans}")
    if expect.plan_count_at_least is not None and plans < expect.plan_count_at_least:
        unmet.append(f"expected at least {expect.plan_count_at_least} plans, made {plans}")
    if expect.transitions_at_least is not None and transitions < expect.transitions_at_least:
        unmet.append(
            f"expected at least {expect.transitions_at_least} transitions, made {transitions}"
        )
    if expect.path_length_at_least_m is not None and driven_m < expect.path_length_at_least_m:
        unmet.append(
            f"expected {expect.path_length_at_least_m:g} m or more driven, was {driven_m:.1f} m"
        )
    events = {change.event for robot in robots for change in robot.transitions}
    unmet += [
        f"expected a change of mode by {event}, there was none"
        for event in expect.transitions
        if event not in events
    ]
    causes = {recovered.cause for robot in robots for recovered in robot.recoveries}
    unmet += [
        f"expected to recover from {cause}, never had to"
        for cause in expect.recoveries
        if cause not in causes
    ]
    unmet += [
        f"expected the mode {mode}, never entered" for mode in expect.modes if mode not in seen
    ]
    return unmet


def _without_mode(sentence: str) -> str:
    """Return a navigator's sentence without the mode that it begins with, `Stop: arrived.`"""
    _, colon, why = sentence.partition(": ")
    return (why if colon else sentence).rstrip(".")


def _pose(value: Any) -> Pose:
    if hasattr(value, "heading_rad"):
        return (float(value.x_m), float(value.y_m), float(value.heading_rad))
    if hasattr(value, "heading"):
        return (float(value.x), float(value.y), float(value.heading))
    x, y, heading = value
    return (float(x), float(y), float(heading))


def _is_slow(velocity: Any) -> bool:
    return abs(velocity.linear_mps) < REST_MPS and abs(velocity.angular_radps) < REST_RADPS


def _contact(contact: Any, trace: Trace) -> dict[str, Any]:
    """Tell a contact, with how fast the robot itself moved in the tick before, by truth."""
    after = int(np.searchsorted(trace.time_s, contact.time_s))
    now, before = trace.truth[max(after - 1, 0)], trace.truth[max(after - 2, 0)]
    return {
        "time_s": float(contact.time_s),
        "name": str(contact.name),
        "speed_mps": math.dist(now[:2], before[:2]) / TICK_S,
        "turn_radps": abs(math.remainder(now[2] - before[2], math.tau)) / TICK_S,
    }


def _apart_m(one: Any, other: Any) -> float:
    """Return how far two robots' outlines are from each other [m]; 0 where they overlap."""
    from cairn.robots import rectangles
    from cairn.robots.scene import outline_at

    outline = outline_at(one.truth, one.profile.footprint)
    return float(
        rectangles.distances(outline, outline_at(other.truth, other.profile.footprint)[None])[0]
    )
