"""The trackers that others use: pure pursuit, and regulated pure pursuit [Macenski23].

Written from the published method, at the defaults of its usual implementation; only the look-ahead
is chosen for each path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cairn.experiments.track_paths import Floats
from cairn.profile import Limits
from cairn.robots import Twist
from cairn.robots.robot import wrap_angle

# How far along the path the nearest point may be from one tick to the next.
_REACH_M = 1.0
_BACK_M = 0.3


@dataclass(frozen=True)
class Regulation:
    """What regulated pure pursuit adds; the values are its defaults in ROS 2 Navigation."""

    least_radius_m: float = 0.9
    least_speed_mps: float = 0.25
    approach_m: float = 0.6
    least_approach_mps: float = 0.05


class PurePursuit:
    """Steers on the arc to the path's point one look-ahead away [Coulter92]: ω = 2 V y / L²."""

    def __init__(
        self,
        path: Floats,
        lookahead_m: float,
        cruise_mps: float,
        limits: Limits,
        *,
        regulation: Regulation | None = None,
    ) -> None:
        """Follow `path` (n, 2) at `cruise_mps`.

        Without regulation the speed is constant and the robot turns on the spot towards a point
        more than 60° off; with it the speed falls with the radius of the arc and near the goal,
        and it turns on the spot from 45° on.
        """
        self.path = path
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        self._lookahead_m = lookahead_m
        self._cruise_mps = cruise_mps
        self._limits = limits
        self._regulation = regulation
        self._turn_from = math.radians(45 if regulation else 60)
        self._turn_radps = 1.8
        self._reached_m = 0.0
        self._done = False

    def step(self, pose: tuple[float, float, float], twist: Twist, dt_s: float) -> Twist:
        """The command for the next tick."""
        x, y, heading = pose
        position = np.array([x, y])
        self._reached_m = self._nearest(position)
        left_m = float(self._along[-1]) - self._reached_m
        carrot = self._carrot(position)
        dx, dy = carrot - position
        bearing = wrap_angle(math.atan2(dy, dx) - heading)
        distance = math.hypot(dx, dy)
        at_end = left_m < self._lookahead_m
        if self._done or (
            at_end and (distance < 0.03 or (distance < 0.3 and abs(bearing) > math.pi / 2))
        ):
            self._done = True
            return Twist(0.0, 0.0)
        if abs(bearing) > self._turn_from:
            most = min(self._turn_radps, math.sqrt(2 * self._limits.angular_radps2 * abs(bearing)))
            return Twist(0.0, math.copysign(most, bearing))
        curvature = 2 * math.sin(bearing) / distance
        speed = self._cruise_mps
        if (rules := self._regulation) is not None:
            radius = 1 / max(abs(curvature), 1e-9)
            if radius < rules.least_radius_m:
                speed = max(speed * radius / rules.least_radius_m, rules.least_speed_mps)
            if left_m < rules.approach_m:
                speed = max(speed * left_m / rules.approach_m, rules.least_approach_mps)
        speed = min(speed, self._cruise_mps, self._stoppable(max(left_m, distance), dt_s))
        most = self._limits.angular_radps
        return Twist(speed, max(-most, min(most, speed * curvature)))

    def _stoppable(self, left_m: float, dt_s: float) -> float:
        a, wait_s = 0.9 * self._limits.linear_mps2, 1.5 * dt_s
        return a * (math.sqrt(wait_s * wait_s + 2 * left_m / a) - wait_s)

    def _nearest(self, position: Floats) -> float:
        first = max(int(np.searchsorted(self._along, self._reached_m - _BACK_M)) - 1, 0)
        last = int(np.searchsorted(self._along, self._reached_m + _REACH_M)) + 1
        a, b = self.path[first:last], self.path[first + 1 : last + 1]
        a = a[: len(b)]
        side = b - a
        length2 = np.maximum((side**2).sum(1), 1e-18)
        share = np.clip(((position - a) * side).sum(1) / length2, 0, 1)
        away = ((position - a - share[:, None] * side) ** 2).sum(1)
        i = int(away.argmin())
        found = float(self._along[first + i] + share[i] * math.sqrt(length2[i]))
        return max(found, self._reached_m)

    def _carrot(self, position: Floats) -> Floats:
        """The first point beyond the nearest one a look-ahead away; at the end, the goal."""
        i = int(np.searchsorted(self._along, self._reached_m, side="right")) - 1
        i = min(i, len(self.path) - 2)
        share = (self._reached_m - self._along[i]) / max(self._along[i + 1] - self._along[i], 1e-12)
        start = self.path[i] + share * (self.path[i + 1] - self.path[i])
        points = np.vstack([start, self.path[i + 1 :]])
        away = np.hypot(*(points - position).T)
        beyond = np.nonzero(away >= self._lookahead_m)[0]
        if not len(beyond):
            return self.path[-1]
        j = int(beyond[0])
        if j == 0:
            return start
        # Where the side from j - 1 to j leaves the circle about the robot.
        p, d = points[j - 1] - position, points[j] - points[j - 1]
        a, b, c = float(d @ d), float(p @ d), float(p @ p) - self._lookahead_m**2
        return points[j - 1] + d * ((-b + math.sqrt(max(b * b - a * c, 0.0))) / a)


def regulated(path: Floats, lookahead_m: float, cruise_mps: float, limits: Limits) -> PurePursuit:
    """Regulated pure pursuit at its defaults."""
    return PurePursuit(path, lookahead_m, cruise_mps, limits, regulation=Regulation())
