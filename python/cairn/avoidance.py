"""Obstacle avoidance by the curvature velocity method [Maalouf06 §5 (7)] [Simmons96].

The robot moves on arcs. Every tick, the arcs that the speeds reachable now allow are scored by
speed, free length and heading for the goal; the best one that the robot can stop on is driven.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

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
        points = np.ascontiguousarray(obstacles, dtype=np.float64)
        if points.size == 0:
            points = points.reshape(0, 2)
        if points.ndim != 2 or points.shape[1] != 2:
            raise errors.AvoidanceInputInvalid(
                f"avoidance: obstacles have shape {points.shape}, must be (n, 2)",
                what="obstacles.shape",
                value=float(points.ndim),
                wanted="(n, 2)",
            )
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
