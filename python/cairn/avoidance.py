"""Obstacle avoidance by the curvature velocity method [Maalouf06 §5 (7)] [Simmons96].

The robot moves on arcs. Every tick, the arcs that the speeds reachable now allow are scored by
speed, free length and heading for the goal; the best one that the robot can stop on is driven.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain, errors
from cairn.profile import Profile


@dataclass(frozen=True)
class Avoidance:
    """One choice, with everything it was made from.

    `why["kind"]` is `best_arc`, `turning_in_place` (with `direction`, `to_heading_rad`),
    `leaving_obstacle` (with `clearance_m`), `backing_out` (with `to_room_m`, `clear_m`),
    `giving_way` (with `things`, `touches_s`, `nearest_m`: to what moves, with a lidar) or
    `braking` (with `reason["kind"]`).
    """

    record: dict[str, Any]
    """The whole record as plain dicts and lists: window, intervals, candidates with their terms."""

    @property
    def twist(self) -> tuple[float, float]:
        """The motion to drive (V [m/s], ω [rad/s])."""
        twist = self.record["twist"]
        return twist["linear_mps"], twist["angular_radps"]

    @property
    def why(self) -> dict[str, Any]:
        """What kind of motion this is, and why."""
        return self.record["why"]

    @property
    def intervals(self) -> NDArray[np.float64]:
        """Merged intervals (n, 3): rightmost and leftmost curvature [1/m], free length [m]."""
        keys = ("curvature_lo", "curvature_hi", "distance_m")
        rows = [[interval[key] for key in keys] for interval in self.record["intervals"]]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain dicts and lists."""
        return self.record


class Cvm:
    """The curvature velocity method for the robot of one profile.

    Args:
        profile: outline, limits and latency of the robot.
        **config: settings that differ from their defaults, e.g. `shape="disc"`, `margin_m=0.05`,
            `speed_weight=0.2, distance_weight=0.3, heading_weight=0.5` (they sum to 1). The
            latency is the profile's unless given.

    Raises:
        AvoidanceValueOutOfRange: a setting is outside its range.
        AvoidanceWeightsNotOne: the weights of (7) do not sum to one.
        SettingsInvalid: an unknown setting.
    """

    def __init__(self, profile: Profile, **config: Any) -> None:
        config.setdefault("latency_s", profile.drive.latency_s)
        self._brain = _brain.CurvatureVelocity(profile, config)

    @property
    def config(self) -> dict[str, Any]:
        """All settings, defaults included."""
        return self._brain.config()

    def choose(
        self,
        twist: tuple[float, float],
        goal_bearing_rad: float,
        goal_distance_m: float,
        obstacles: ArrayLike,
        dt_s: float = 0.1,
        *,
        pending: tuple[float, float] | None = None,
    ) -> Avoidance:
        """Choose the motion for the next tick.

        Args:
            twist: measured (V [m/s], ω [rad/s]).
            goal_bearing_rad: direction of the goal in the robot frame [rad], left positive.
            goal_distance_m: distance to the goal [m]; `inf` means a direction only.
            obstacles: centres of occupied cells (n, 2) in the robot frame [m].
            dt_s: length of a tick [s].
            pending: the command given before this one, which the robot drives towards while the
                latency lasts; without it the robot is taken to keep its twist for that long.

        Raises:
            AvoidanceObstacleNotFinite: an obstacle has a coordinate that is not finite.
            AvoidanceInputInvalid: twist, goal or tick is not a usable number, or `obstacles` has
                another shape.
        """
        points = _rows(obstacles, "obstacles", 2)
        linear, angular = twist
        record = self._brain.choose(
            (float(linear), float(angular)),
            pending,
            goal_bearing_rad,
            goal_distance_m,
            points,
            dt_s,
        )
        return Avoidance(record)

    def choose_guided(
        self,
        twist: tuple[float, float],
        guide: Guide,
        obstacles: ArrayLike,
        goal_distance_m: float,
        dt_s: float = 0.1,
        *,
        pending: tuple[float, float] | None = None,
        moving: Sequence[Moving] = (),
    ) -> Avoidance:
        """Choose the motion for the next tick, guided by a field instead of the goal's direction.

        An arc is worth the time to drive over it and on from where the field takes over best, one
        step of looking ahead before the cost-to-go [Brock99] [Bertsekas05]; a turn on the spot is
        judged in the same seconds. Free lengths, window and braking check are those of `choose`.

        Args:
            twist: measured (V [m/s], ω [rad/s]).
            guide: what the field says around the robot: a `FieldGuide`, or anything like it (a
                guide written in Python is asked some thousand times for one choice).
            obstacles: centres of what stands (n, 2) in the robot frame [m].
            goal_distance_m: distance to the goal [m]; what lies beyond it is no hindrance.
            dt_s: length of a tick [s].
            pending: the command given before this one; `twist` unless given.
            moving: what moves: whole manoeuvres are then followed in time beside it.

        Raises:
            AvoidanceObstacleNotFinite: an obstacle has a coordinate that is not finite.
            AvoidanceInputInvalid: twist, goal, tick or a moving thing is not usable, or `obstacles`
                has another shape. What the guide raises comes through.
        """
        points = _rows(obstacles, "obstacles", 2)
        things = [(*thing.center_m, thing.radius_m, *thing.velocity_mps) for thing in moving]
        rows = _rows(things, "moving", 5)
        if not np.isfinite(rows).all():
            raise _invalid("moving", float("nan"), "finite numbers")
        last = twist if pending is None else pending
        record = self._brain.choose_guided(
            (float(twist[0]), float(twist[1])),
            (float(last[0]), float(last[1])),
            guide,
            points,
            rows,
            goal_distance_m,
            dt_s,
        )
        return Avoidance(record)


@dataclass(frozen=True)
class Moving:
    """A disc that moves straight on, in the robot frame as it lies now.

    Attributes:
        center_m: (x, y) [m].
        radius_m: of the disc [m].
        velocity_mps: (x, y) over the ground [m/s].
    """

    center_m: tuple[float, float]
    radius_m: float
    velocity_mps: tuple[float, float]


class Guide(Protocol):
    """What a cost-to-go field says about the places around the robot."""

    def to_go(self, point_in_robot: tuple[float, float], /) -> tuple[float, float]:
        """Time still to go from a place [s] and the direction to leave it in [rad], robot frame."""
        ...

    def price(self, point_in_robot: tuple[float, float], /) -> float:
        """Time that a metre takes at a place [s/m]; inf where the robot's centre must not be."""
        ...


class FieldGuide(_brain.FieldGuide):
    """The guide of the lidar robot: seconds to a goal over points seen around, solved at once.

    `to_go` and `price` ask it about a place, `has_way` tells whether any way keeps off every point.

    Args:
        profile: outline of the robot.
        points: what stands (n, 2) [m].
        robot: pose (x, y, heading) [m, m, rad] in the frame of the points.
        goal: (x, y) [m] in the same frame; one farther than `reach_m` is headed for that far.
        resolution_m: side of a cell of the field [m], 0.01 to 1.
        **config: settings that differ from `Navigator.default_config()["lidar"]["field"]`.

    Raises:
        AvoidanceInputInvalid: a number is not finite or out of range, or `points` has another
            shape.
        SettingsInvalid: an unknown setting.
    """

    def __new__(
        cls,
        profile: Profile,
        points: ArrayLike,
        robot: tuple[float, float, float],
        goal: tuple[float, float],
        *,
        resolution_m: float = 0.05,
        **config: Any,
    ) -> FieldGuide:
        """Solve the field."""
        rows = _rows(points, "points", 2)
        for what, values in (("points", rows), ("robot", robot), ("goal", goal)):
            numbers = np.asarray(values, float)
            if not (np.isfinite(numbers).all() and (np.abs(numbers) < FARTHEST_M).all()):
                raise _invalid(what, float("nan"), f"numbers below {FARTHEST_M:.0f}")
        if not FINEST_M <= resolution_m <= COARSEST_M:
            raise _invalid("resolution_m", float(resolution_m), f"{FINEST_M} to {COARSEST_M} m")
        pose = (float(robot[0]), float(robot[1]), float(robot[2]))
        target = (float(goal[0]), float(goal[1]))
        return super().__new__(cls, profile, config, rows, pose, target, float(resolution_m))


FARTHEST_M = 1e6
FINEST_M, COARSEST_M = 0.01, 1.0


def _rows(values: ArrayLike, what: str, width: int) -> NDArray[np.float64]:
    """(n, width) floats; empty of any shape is (0, width)."""
    rows = np.ascontiguousarray(values, dtype=np.float64)
    if rows.size == 0:
        rows = rows.reshape(0, width)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise errors.AvoidanceInputInvalid(
            f"avoidance: {what} have shape {rows.shape}, must be (n, {width})",
            what=f"{what}.shape",
            value=float(rows.ndim),
            wanted=f"(n, {width})",
        )
    return rows


def _invalid(what: str, value: float, wanted: str) -> errors.AvoidanceInputInvalid:
    return errors.AvoidanceInputInvalid(
        f"avoidance: {what} is {value}, must be {wanted}", what=what, value=value, wanted=wanted
    )
