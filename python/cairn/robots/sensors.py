"""How sensors err: encoders and gyroscope with noise from a seed, sonar as cones of rays."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np

from cairn.profile import Noise, Profile
from cairn.robots.rectangles import Floats
from cairn.robots.robot import Pose

Firing = Literal["all", "sequenced"]

# From one origin (2,) along unit vectors (m, 2): distances (m,) [m], inf for none, and the cosines
# of the angle between each ray and the normal of the face it meets.
Caster = Callable[[Floats, Floats], tuple[Floats, Floats]]

# One transducer of each array fires every 40 ms.
_FIRING_PERIOD_S = 0.04
_ARRAY = 8

# A corner is hit when nothing stands nearer than it by more than this.
_SIGHT_TOLERANCE_M = 2e-3


class WheelEncoders:
    """Travel of each side: radius errors drawn once, and a random walk over the ground."""

    def __init__(self, noise: Noise, seed: int) -> None:
        """Draw the two sides' radius errors."""
        self._random = np.random.default_rng([seed, 1])
        self.scale = 1 + noise.wheel_scale_sigma * self._random.standard_normal(2)
        self._sigma = noise.encoder_sigma_per_sqrt_m

    def read(self, travel_m: tuple[float, float]) -> tuple[float, float]:
        """What the encoders say of a true travel of the left and right side."""
        drawn = self._random.standard_normal(2)
        left, right = (
            d * k + self._sigma * math.sqrt(abs(d)) * n
            for d, k, n in zip(travel_m, self.scale, drawn, strict=True)
        )
        return float(left), float(right)


class Gyroscope:
    """Mean turn rate: bias and scale drawn once, the bias wandering, white noise."""

    def __init__(self, noise: Noise, seed: int) -> None:
        """Draw bias and scale."""
        self._random = np.random.default_rng([seed, 2])
        bias, scale = self._random.standard_normal(2)
        self.bias_radps = float(noise.gyro_bias_sigma_radps * bias)
        self.scale = float(1 + noise.gyro_scale_sigma * scale)
        self._noise = noise

    def read(self, turned_rad: float, elapsed_s: float) -> float:
        """What the gyroscope says of a true turn over some time [rad/s]."""
        if elapsed_s <= 0:
            return self.bias_radps
        drift, white = self._random.standard_normal(2)
        root = math.sqrt(elapsed_s)
        self.bias_radps += float(self._noise.gyro_drift_radps_per_sqrt_s * root * drift)
        rate = turned_rad / elapsed_s * self.scale + self.bias_radps
        return float(rate + self._noise.gyro_density_radps_sqrt_s / root * white)


class RangeSensors:
    """All sonars and the lidar of a robot.

    A sonar hears the nearest of the echoes from inside its cone: faces met within
    `sonar_miss_incidence_rad` of their normal, and corners at any angle; a face met flatter mirrors
    the wave away.
    """

    def __init__(self, profile: Profile, noise: Noise, seed: int, firing: Firing = "all") -> None:
        """Sensors of `profile`; `firing` tells whether each sonar is read every time."""
        self._profile = profile
        self._noise = noise
        self._firing = firing
        self._random = np.random.default_rng([seed, 3])
        self._fired_until = 0
        self._least_cosine = math.cos(noise.sonar_miss_incidence_rad)
        self.reach_m = max(
            [s.max_range_m + math.hypot(s.pose.x, s.pose.y) for s in profile.sonars]
            + ([profile.lidar.max_range_m + 1.0] if profile.lidar else [])
            + [0.0]
        )

    def read(self, pose: Pose, time_s: float, cast: Caster, corners: Floats) -> Floats:
        """One array of ranges: sonars, then lidar beams; see `Readings.ranges_m`.

        Args:
            pose: where the robot truly is.
            time_s: the robot's clock; tells which sonars fired, if they take turns.
            cast: the world's rays.
            corners: points (k, 2) that echo from any side, world frame.
        """
        fired = self._fired(time_s)
        ranges = np.full(self._profile.range_count, np.nan)
        sonars = len(self._profile.sonars)
        # Drawn for all, so that what one sonar hears does not change another's noise.
        drawn = self._random.standard_normal(len(ranges))
        away = np.abs(corners - (pose.x, pose.y))
        corners = corners[np.maximum(away[:, 0], away[:, 1]) <= self.reach_m]
        for i in fired:
            ranges[i] = self._echo(i, pose, cast, corners, drawn[i])
        if self._profile.lidar:
            ranges[sonars:] = self._scan(pose, cast, drawn[sonars:])
        return ranges

    def _fired(self, time_s: float) -> list[int]:
        count = len(self._profile.sonars)
        if self._firing == "all":
            return list(range(count))
        now = math.floor(time_s / _FIRING_PERIOD_S + 1e-6)
        first = max(self._fired_until, now - _ARRAY) + 1
        self._fired_until = now
        slots = {(k - 1) % _ARRAY for k in range(first, now + 1)}
        return [i for i in range(count) if i % _ARRAY in slots]

    def _echo(self, i: int, pose: Pose, cast: Caster, corners: Floats, drawn: float) -> float:
        sonar = self._profile.sonars[i]
        origin, axis = _placed(pose, sonar.pose.x, sonar.pose.y, sonar.pose.heading)
        half = sonar.beam_rad / 2
        rays = self._noise.sonar_rays
        angles = axis + (np.linspace(-half, half, rays) if rays > 1 else np.zeros(1))
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        offsets = corners - origin
        far = np.hypot(offsets[:, 0], offsets[:, 1])
        inside = (far <= sonar.max_range_m) & (far > 1e-6)
        inside &= offsets @ np.array([math.cos(axis), math.sin(axis)]) >= far * math.cos(half)
        to_corners, far = offsets[inside] / far[inside, None], far[inside]
        distance, cosine = cast(origin, np.vstack([directions, to_corners]))
        faces = distance[:rays][cosine[:rays] >= self._least_cosine]
        seen = far[distance[rays:] >= far - _SIGHT_TOLERANCE_M]
        true = min(faces.min(initial=math.inf), seen.min(initial=math.inf))
        if true > sonar.max_range_m:
            return math.inf
        sigma = self._noise.sonar_sigma_m + self._noise.sonar_sigma_relative * true
        measured = max(true + sigma * drawn, sonar.min_range_m)
        return measured if measured <= sonar.max_range_m else math.inf

    def _scan(self, pose: Pose, cast: Caster, drawn: Floats) -> Floats:
        lidar = self._profile.lidar
        assert lidar is not None
        origin, axis = _placed(pose, lidar.pose.x, lidar.pose.y, lidar.pose.heading)
        angles = axis + lidar.first_rad + lidar.step_rad * np.arange(lidar.beams)
        true, _ = cast(origin, np.column_stack([np.cos(angles), np.sin(angles)]))
        with np.errstate(invalid="ignore"):
            measured = np.maximum(true + self._noise.lidar_sigma_m * drawn, lidar.min_range_m)
        return np.where(true <= lidar.max_range_m, measured, np.inf)


def _placed(pose: Pose, x: float, y: float, heading: float) -> tuple[Floats, float]:
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    return np.array([pose.x + c * x - s * y, pose.y + s * x + c * y]), pose.heading + heading
