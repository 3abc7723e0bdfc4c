"""One drive along a path, judged by truth: a tracker, a robot, a loop, what disturbs it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from cairn.experiments.track_paths import Floats, Reference
from cairn.profile import Profile
from cairn.robots import KinematicRobot, Scene, Twist
from cairn.robots.robot import wrap_angle
from cairn.tracking import Tracker, TrackingRecord, deviations

# The goal counts as reached when the robot first comes this near; what follows is coming to rest.
NEAR_M = 0.1
# Where a robot starts off its path, the first metres driven are judged apart.
JOINING_M = 2.0
SETTLED_M = 0.05
_REST_S = 6.0


class Follower(Protocol):
    """What drives: our tracker or another."""

    def step(self, pose: tuple[float, float, float], twist: Twist, dt_s: float) -> Twist:
        """The command for the next tick, from what is measured now."""
        ...


class FuzzyFollower:
    """`cairn.Tracker`, keeping its records."""

    def __init__(self, tracker: Tracker) -> None:
        """Drive with a tracker that has taken up its path."""
        self.tracker = tracker
        self.records: list[TrackingRecord] = []

    def step(self, pose: tuple[float, float, float], twist: Twist, dt_s: float) -> Twist:
        """One tick of the tracker."""
        record = self.tracker.step(pose, twist, dt_s)
        self.records.append(record)
        return record.twist


@dataclass(frozen=True)
class Conditions:
    """What is not as the tracker believes.

    Attributes:
        tick_s: from one command to the next.
        latency_s: true latency; the tracker is told `told_latency_s`, by default the true one.
        turn_share: true turn rate over the wheels', as a function of the way driven [m].
        dead_band_radps, dead_band_mps: slower than this the robot does not turn, or move.
        pose_sigma_m, heading_sigma_rad: white noise on every measured pose.
        twist_sigma: relative white noise on the measured speeds.
    """

    tick_s: float = 0.1
    latency_s: float = 0.1
    told_latency_s: float | None = None
    turn_share: Callable[[float], float] | None = None
    dead_band_radps: float = 0.0
    dead_band_mps: float = 0.0
    pose_sigma_m: float = 0.0
    heading_sigma_rad: float = 0.0
    twist_sigma: float = 0.0


@dataclass
class Drive:
    """What happened, tick by tick: times (n,), true poses (n, 3), speeds and commands (n, 2)."""

    reference: Reference
    times_s: Floats
    poses: Floats
    twists: Floats
    commands: Floats
    records: list[TrackingRecord] = field(default_factory=list)


def profile_with(profile: Profile, latency_s: float) -> Profile:
    """`profile` with another latency."""
    line = f"latency_s = {profile.drive.latency_s}"
    assert line in profile.text
    return Profile(profile.text.replace(line, f"latency_s = {latency_s}"))


def robot_at(
    kind: str, profile: Profile, start: tuple[float, float, float], conditions: Conditions
) -> Any:
    """A robot alone on a floor, with sensors that are not asked."""
    exact = profile_with(profile, conditions.latency_s)
    noise = None if exact.noise is None else exact.noise.scaled(0)
    if kind == "kinematic":
        return KinematicRobot(exact, Scene(), start, noise=noise)
    from cairn.robots import MujocoP3AT

    return MujocoP3AT(exact, Scene(), start, noise=noise)


def drive(
    follower: Follower,
    robot: Any,
    reference: Reference,
    conditions: Conditions,
    *,
    seed: int = 0,
    most_s: float | None = None,
    at_tick: Callable[[int], None] | None = None,
) -> Drive:
    """Drive until the robot has come to rest at the end of its path, or `most_s` have passed."""
    random = np.random.default_rng([seed, 21])
    goal = reference.path[-1]
    if most_s is None:
        most_s = 30.0 + 12.0 * reference.length_m
    rows: list[tuple[float, ...]] = []
    driven_m, before = 0.0, robot.truth
    near_s = math.inf
    for tick in range(math.ceil(most_s / conditions.tick_s)):
        truth, velocity = robot.truth, robot.velocity
        driven_m += math.hypot(truth.x - before.x, truth.y - before.y)
        before = truth
        time_s = tick * conditions.tick_s
        if at_tick is not None:
            at_tick(tick)
        pose, twist = measured(truth, velocity, conditions, random)
        command = follower.step(pose, twist, conditions.tick_s)
        rows.append((time_s, *truth, *velocity, *command))
        # A path may pass its own end before it gets there.
        there = math.hypot(truth.x - goal[0], truth.y - goal[1]) < NEAR_M
        if there and driven_m > 0.8 * reference.length_m:
            near_s = min(near_s, time_s)
        resting = abs(velocity.linear_mps) < 0.005 and abs(velocity.angular_radps) < 0.02
        if time_s > near_s and (resting or time_s > near_s + _REST_S):
            break
        if conditions.turn_share is not None:
            robot.change_floor(1 / conditions.turn_share(driven_m))
        robot.command(_through_dead_band(command, conditions))
        robot.advance(conditions.tick_s)
    table = np.array(rows)
    records = getattr(follower, "records", [])
    return Drive(reference, table[:, 0], table[:, 1:4], table[:, 4:6], table[:, 6:8], list(records))


def measured(
    truth: Any, velocity: Twist, conditions: Conditions, random: np.random.Generator
) -> tuple[tuple[float, float, float], Twist]:
    """Pose and speeds as the tracker gets them."""
    dx, dy, turn, forward, turning = random.standard_normal(5)
    sigma = conditions.pose_sigma_m
    pose = (
        truth.x + sigma * dx,
        truth.y + sigma * dy,
        truth.heading + conditions.heading_sigma_rad * turn,
    )
    return pose, Twist(
        velocity.linear_mps * (1 + conditions.twist_sigma * forward),
        velocity.angular_radps * (1 + conditions.twist_sigma * turning),
    )


def _through_dead_band(command: Twist, conditions: Conditions) -> Twist:
    return Twist(
        command.linear_mps if abs(command.linear_mps) >= conditions.dead_band_mps else 0.0,
        command.angular_radps if abs(command.angular_radps) >= conditions.dead_band_radps else 0.0,
    )


def rms(values: Floats, weights: Floats | None = None) -> float | None:
    """Root mean square; None of nothing."""
    if weights is None:
        weights = np.ones_like(values)
    total = float(weights.sum())
    return math.sqrt(float((weights * values**2).sum()) / total) if total > 0 else None


def measures(run: Drive) -> dict[str, Any]:
    """A drive in numbers, against the continuous path.

    Keys:
        reached: came within 0.1 m of the goal; `time_s` when; `arrival_error_m` where it rests.
        rms_m, max_m: distance to the path, over the way driven: every metre counts the same. On a
            path that the robot has to join, without the first 2 m.
        rms_in_time_m: the same over time: every second counts the same.
        rms_first_m, max_first_m: over the first 2 m driven; rms_late_m, max_late_m: over the rest.
        overshoot_m: farthest on the other side of the path than where the robot stood at first.
        settled_s: from when on it stays within 5 cm of the path.
        after_turn_rms_m, after_turn_max_m: from when the robot first looked along the path (10°).
        effort_v_mps, effort_w_radps: ∫|V̇| dt and ∫|ω̇| dt.
        least_v_mps: below 0 it reversed; spinning_s: turned on the spot.
    """
    reference = run.reference
    left_m, along_m = deviations(reference.path, run.poses[:, :2])
    goal = reference.path[-1]
    to_goal_m = np.hypot(*(run.poses[:, :2] - goal).T)
    near = np.nonzero((to_goal_m < NEAR_M) & (along_m > reference.length_m - 1.0))[0]
    reached = bool(len(near))
    until = int(near[0]) + 1 if reached else len(left_m)
    left, twists = left_m[:until], run.twists[:until]
    way = np.hypot(*np.diff(run.poses[:until, :2], axis=0, prepend=run.poses[:1, :2]).T)
    driven_m = np.cumsum(way)
    first = driven_m <= JOINING_M
    judged = ~first if reference.joins else np.ones_like(first)
    along = looking_along(reference.path, along_m[:until], run.poses[:until, 2])
    turned = np.arange(until) >= (int(np.nonzero(along)[0][0]) if along.any() else until)
    off = np.nonzero(np.abs(left) > SETTLED_M)[0]
    settled = int(off[-1]) + 1 if len(off) else 0
    side = math.copysign(1, left[0]) if abs(left[0]) > SETTLED_M else 0.0
    changes = np.abs(np.diff(run.twists, axis=0)).sum(0)
    standing = (np.abs(twists[:, 0]) < 0.02) & (np.abs(twists[:, 1]) > 0.2)
    tick_s = float(run.times_s[1] - run.times_s[0]) if len(run.times_s) > 1 else 0.0
    return {
        "reached": reached,
        "time_s": float(run.times_s[until - 1]),
        "arrival_error_m": float(to_goal_m[-1]),
        "rms_m": rms(left[judged], way[judged]),
        "rms_in_time_m": rms(left[judged]),
        "max_m": most(left[judged]),
        "rms_first_m": rms(left[first], way[first]),
        "max_first_m": most(left[first]),
        "rms_late_m": rms(left[~first], way[~first]),
        "max_late_m": most(left[~first]),
        "overshoot_m": float(max((-side * left).max(), 0.0)) if side else None,
        "settled_s": float(run.times_s[settled]) if settled < until else None,
        "after_turn_rms_m": rms(left[turned]),
        "after_turn_max_m": most(left[turned]),
        "driven_m": float(driven_m[-1]),
        "effort_v_mps": float(changes[0]),
        "effort_w_radps": float(changes[1]),
        "least_v_mps": float(run.commands[:, 0].min()),
        "spinning_s": float(standing.sum() * tick_s),
    }


def looking_along(path: Floats, along_m: Floats, headings: Floats) -> NDArrayBool:
    """Whether the robot looks within 10° of where the path goes, at each place along it."""
    sides = np.diff(path, axis=0)
    starts = np.concatenate([[0.0], np.cumsum(np.hypot(*sides.T))])
    at = np.clip(np.searchsorted(starts, along_m, side="right") - 1, 0, len(sides) - 1)
    directions = np.arctan2(sides[at, 1], sides[at, 0])
    off = [abs(wrap_angle(h - d)) for h, d in zip(headings, directions, strict=True)]
    return np.array(off) < math.radians(10)


NDArrayBool = np.ndarray[Any, np.dtype[np.bool_]]


def most(values: Floats) -> float | None:
    """The greatest of all sizes; None of nothing."""
    return float(np.abs(values).max()) if len(values) else None
