"""One trial: a stack drives a robot through a world until it arrives, touches or is too late."""

from __future__ import annotations

import math
import time
import zlib
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.experiments.nav.jackal import Jackal
from cairn.experiments.nav.rover import SonarRover
from cairn.experiments.nav.scoring import CAP, OLD_CAP, score
from cairn.experiments.nav.simulated import STEP_S, Motion, Simulated, Surroundings
from cairn.experiments.nav.stacks import Observation, Task, maker
from cairn.experiments.nav.worlds import NavWorld
from cairn.profile import Profile
from cairn.robots.robot import Pose, as_twist

STARTED_M = 0.1
"""The clock starts once the robot has moved so far."""
START_WITHIN_S = 30.0
"""A robot that has not moved by then has run out of time."""
JUMP_S = 0.1
"""A hit so near in time to a jump of a moving obstacle is nobody's fault."""
ATTEMPTS = 20

SUCCESS, COLLISION, TIMEOUT, ERROR = "success", "collision", "timeout", "error"


@dataclass(frozen=True)
class Kind:
    """A kind of robot: how it is simulated, and how often a stack is asked by default."""

    profile: str
    simulated: type[Jackal] | type[SonarRover]
    period_s: float
    scale: float
    """Worlds are larger by this: the radii around the two robots' outlines are as 1 to 1.30."""
    slower: float
    """And their time limits longer by this: the same number of optimal times for both."""


ROBOTS = {
    "jackal": Kind("jackal", Jackal, 0.05, 1.0, 1.0),
    "p3at": Kind("p3at", SonarRover, 0.1, 1.3, 1.3 * 2.0 / 0.7),
}


def fitted(world: NavWorld, robot: str) -> NavWorld:
    """Return a world of BARN's size as it is for a robot: see `Kind`."""
    kind = ROBOTS[robot]
    if kind.scale == 1.0:
        return world
    return replace(world.scaled(kind.scale), timeout_s=world.timeout_s * kind.slower)


@dataclass
class Trace:
    """Where everything was, for pictures; (n, …) arrays, one row per control period."""

    time_s: list[float] = field(default_factory=list)
    truth: list[tuple[float, float, float]] = field(default_factory=list)
    odometry: list[tuple[float, float, float]] = field(default_factory=list)
    twist: list[tuple[float, float]] = field(default_factory=list)
    path: NDArray[np.float64] | None = None
    moving: NDArray[np.float64] | None = None
    scan: NDArray[np.float64] | None = None


@dataclass
class Trial:
    """How a trial went, judged by truth."""

    world: str
    trial: int
    outcome: str
    reason: str
    time_s: float
    score: float
    score_old_cap: float
    path_length_m: float
    end: Pose
    attempts: int
    notes: dict[str, Any]
    wall: dict[str, float]
    trace: Trace | None = None

    def to_dict(self) -> dict[str, Any]:
        """Everything that follows from the seed, as plain JSON."""
        return {
            "world": self.world,
            "trial": self.trial,
            "outcome": self.outcome,
            "reason": self.reason,
            "time_s": round(self.time_s, 3),
            "score": round(self.score, 6),
            "score_old_cap": round(self.score_old_cap, 6),
            "path_driven_m": round(self.path_length_m, 3),
            "end": [round(value, 4) for value in self.end],
            "attempts": self.attempts,
            "notes": self.notes,
        }


def seed_of(seed: int, world: str, trial: int, attempt: int) -> int:
    """Seed of one attempt: it depends on nothing else that is run."""
    words = np.random.SeedSequence([seed, zlib.crc32(world.encode()), trial, attempt])
    return int(words.generate_state(1)[0])


def drive(
    stack: str,
    world: NavWorld,
    trial: int,
    seed: int,
    *,
    robot: str = "jackal",
    trace: bool = False,
) -> Trial:
    """Drive one trial; the world must be `fitted` to the robot already.

    Args:
        stack: a name of `stacks.STACKS`, or `module:function`.
        world: what to drive through.
        trial: its number; latencies, yaw gain, noise and phase are drawn from it and `seed`.
        seed: of the whole benchmark.
        robot: `jackal` (lidar) or `p3at` (sonars).
        trace: keep what a picture needs.

    Raises:
        StackNotFound, StackPeriodInvalid: the stack cannot be entered.
    """
    kind = ROBOTS[robot]
    make = maker(stack)
    period_s = checked_period(stack, getattr(make, "period_s", kind.period_s))
    attempt = 0
    while True:
        run = _Run(make, kind, world, period_s, seed_of(seed, world.name, trial, attempt), trace)
        outcome, reason = run.play()
        attempt += 1
        if outcome is not None or attempt >= ATTEMPTS:
            break
    outcome = outcome or COLLISION
    top_mps = run.robot.profile.limits.linear_mps
    success = outcome == SUCCESS
    return Trial(
        world=world.name,
        trial=trial,
        outcome=outcome,
        reason=reason,
        time_s=run.clock_s,
        score=score(success, run.clock_s, world.path_length_m, top_mps, CAP),
        score_old_cap=score(success, run.clock_s, world.path_length_m, top_mps, OLD_CAP),
        path_length_m=run.driven_m,
        end=run.end,
        attempts=attempt,
        notes=run.notes(),
        wall=run.wall(),
        trace=run.trace,
    )


def checked_period(stack: str, period_s: float) -> float:
    """Return a control period that the simulation offers.

    Raises:
        StackPeriodInvalid: not a multiple of 5 ms from 20 ms to 1 s.
    """
    steps = period_s / STEP_S
    if not (0.02 - 1e-9 <= period_s <= 1.0 and abs(steps - round(steps)) < 1e-6):
        raise errors.StackPeriodInvalid(
            f"stack `{stack}`: its control period is {period_s} s, "
            "must be a multiple of 5 ms from 20 ms to 1 s",
            name=stack,
            period_s=period_s,
        )
    return round(steps) * STEP_S


class _Run:
    """One attempt."""

    def __init__(
        self, make: Any, kind: Kind, world: NavWorld, period_s: float, seed: int, trace: bool
    ) -> None:
        profile = Profile.load(kind.profile)
        phase_s = self._phase(world, profile, seed)
        self.robot: Simulated = kind.simulated(profile, world, period_s, seed, phase_s)
        self.world, self.period_s = world, period_s
        self.trace = Trace() if trace else None
        goal = _in_frame(world.start, world.goal)
        self.task = Task(profile, goal, world.goal_tolerance_m, period_s, world.timeout_s, seed)
        self._make = make
        self._stack: Any = None
        self.began_s: float | None = None
        self.clock_s = 0.0
        self.driven_m = 0.0
        self.end = Pose(*world.start)
        self._ticks_s: list[float] = []

    @staticmethod
    def _phase(world: NavWorld, profile: Profile, seed: int) -> float:
        """World time at the start: any, but no obstacle stands on the robot then."""
        if not world.movers:
            return 0.0
        random = np.random.default_rng([seed, 5])
        outline = (profile.footprint.length_m, profile.footprint.width_m)
        pose = np.array([world.start], float)
        while True:
            phase_s = float(random.uniform(0.0, 1000.0))
            if Surroundings(world, phase_s).touch(np.zeros(1), pose, outline) is None:
                return phase_s

    def play(self) -> tuple[str | None, str]:
        """(outcome, reason); no outcome after a hit that was nobody's fault."""
        try:
            self._stack = self._make(self.task)
        except Exception as error:  # a stack may fail in any way
            return ERROR, _told(error)
        while True:
            seen = self.robot.observe()
            began = time.perf_counter()
            try:
                linear, angular = as_twist(self._stack(seen))
            except Exception as error:  # a stack may fail in any way
                return ERROR, _told(error)
            self._ticks_s.append(time.perf_counter() - began)
            self._keep(seen, (linear, angular))
            self.robot.command(linear, angular)
            motion = self.robot.advance(self.period_s)
            ended = self._judge(motion)
            if ended is not None:
                self._keep_end(motion)
                return ended

    def _judge(self, motion: Motion) -> tuple[str | None, str] | None:
        """What ended the trial during a motion, first things first; None if it goes on."""
        x, y = motion.poses[:, 0], motion.poses[:, 1]
        steps = np.hypot(np.diff(x, prepend=self.end[0]), np.diff(y, prepend=self.end[1]))
        self.end = Pose(*map(float, motion.poses[-1]))
        if self.began_s is None:
            moved = np.hypot(x - self.world.start.x, y - self.world.start.y) >= STARTED_M
            if moved.any():
                self.began_s = float(motion.times_s[int(moved.argmax())])
        began_s = math.inf if self.began_s is None else self.began_s
        limit_s = START_WITHIN_S if self.began_s is None else began_s + self.world.timeout_s
        near = np.hypot(x - self.world.goal[0], y - self.world.goal[1])
        arrived = _first(near <= self.world.goal_tolerance_m)
        late = _first(motion.times_s >= limit_s - 1e-9)
        touched = math.inf if motion.touch is None else motion.touch.step
        first = min(arrived, late, touched)
        last = None if first == math.inf else int(first) + 1
        self.driven_m += float(steps[:last].sum())
        if first == math.inf:
            return None
        now_s = float(motion.times_s[int(first)])
        self.end = Pose(*map(float, motion.poses[int(first)]))
        self.clock_s = max(0.0, now_s - began_s) if self.began_s is not None else 0.0
        if touched == first and motion.touch is not None:
            if self.robot.around.from_jump_s(motion.touch, now_s) <= JUMP_S:
                return None, "an obstacle jumped onto the robot"
            return COLLISION, f"touched {motion.touch.what} {motion.touch.which}"
        if arrived == first:
            return SUCCESS, "reached the goal"
        if self.began_s is None:
            return TIMEOUT, f"did not start within {START_WITHIN_S:.0f} s"
        return TIMEOUT, f"{near[int(first)]:.1f} m from the goal after {self.clock_s:.0f} s"

    def _keep(self, seen: Observation, twist: tuple[float, float]) -> None:
        if self.trace is None:
            return
        self.trace.time_s.append(seen.time_s)
        self.trace.truth.append(self.robot.truth)
        self.trace.odometry.append(seen.odometry)
        self.trace.twist.append(twist)

    def _keep_end(self, motion: Motion) -> None:
        if self.trace is None:
            return
        self.trace.time_s.append(float(motion.times_s[-1]))
        self.trace.truth.append(self.end)
        self.trace.moving = self.robot.around.moving(motion.times_s[-1:])
        path = getattr(self._stack, "path", None)
        if path is not None and len(path):
            self.trace.path = np.asarray(path, float)

    def notes(self) -> dict[str, Any]:
        """What the stack has to say, if it says anything."""
        told: Any = getattr(self._stack, "notes", None)
        return {} if told is None else told()

    def wall(self) -> dict[str, float]:
        """How long the stack thought [ms]."""
        ticks = np.asarray(self._ticks_s or [0.0]) * 1e3
        return {
            "tick_mean_ms": float(ticks.mean()),
            "tick_p99_ms": float(np.quantile(ticks, 0.99)),
            "tick_max_ms": float(ticks.max()),
            "ticks": len(self._ticks_s),
        }


def _first(condition: NDArray[np.bool_]) -> float:
    return float(condition.argmax()) if condition.any() else math.inf


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _in_frame(start: tuple[float, float, float], point: tuple[float, float]) -> tuple[float, float]:
    dx, dy = point[0] - start[0], point[1] - start[1]
    c, s = math.cos(start[2]), math.sin(start[2])
    return c * dx + s * dy, c * dy - s * dx
