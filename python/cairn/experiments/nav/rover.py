"""The sonar robot of the benchmark: a Pioneer P3-AT that has nothing but its sixteen sonars.

Firmware ramps, latency, slip and the errors of its sensors are those of `cairn.robots`; only what
stands around it is made of circles here. A sonar hears the nearest face met within
`sonar_miss_incidence_rad` of its normal; posts are round, so some part of them nearly always is.
"""

from __future__ import annotations

import math

import numpy as np

from cairn import _brain, errors
from cairn.experiments.nav.simulated import STEP_S, Floats, Stepped, Surroundings
from cairn.experiments.nav.stacks import Observation
from cairn.experiments.nav.worlds import NavWorld
from cairn.profile import Noise, Profile
from cairn.robots.firmware import Firmware
from cairn.robots.robot import Pose, Twist, moved
from cairn.robots.sensors import Caster, Gyroscope, RangeSensors, WheelEncoders

RAYS = 61
"""Across one cone, so that a post of 0.1 m at 5 m is met by several."""


class SonarRover(Stepped):
    """A P3-AT in a world.

    Args:
        profile: `p3at`, or one made from it.
        world: what is around it; it starts at the world's start.
        period_s: from one observation to the next.
        seed: of everything that is drawn.
        phase_s: the world's time at the start.
    """

    def __init__(
        self, profile: Profile, world: NavWorld, period_s: float, seed: int, phase_s: float = 0.0
    ) -> None:
        if profile.noise is None:
            raise errors.ProfileTableMissing(
                f"profile `{profile.name}` has no [noise]", profile=profile.name, table="noise"
            )
        noise = Noise(**{**profile.noise.model_dump(), "sonar_rays": RAYS})
        super().__init__(profile, Surroundings(world, phase_s), Pose(*world.start))
        self._noise = noise
        self.odometry = Pose(0.0, 0.0, 0.0)
        self._firmware = Firmware(profile)
        self._encoders = WheelEncoders(noise, seed)
        self._gyroscope = Gyroscope(noise, seed)
        self._ranges = RangeSensors(profile, noise, seed)
        self._random = np.random.default_rng([seed, 4])
        self._track_scale = 1 + noise.track_scale_sigma * float(self._random.standard_normal())
        self._slip = 0.0
        self._corners = _corners(world.boxes)
        self._seen_s = 0.0
        self._since = (0.0, 0.0, 0.0)  # left and right travel, turn, since `observe`

    def observe(self) -> Observation:
        """Read sonars, encoders and gyroscope."""
        time_s, dt_s = self.time_s, self.time_s - self._seen_s
        self._seen_s = time_s
        left, right, turned = self._since
        self._since = (0.0, 0.0, 0.0)
        wheels = self._encoders.read((left, right)) if dt_s > 0 else (0.0, 0.0)
        track_m = self.profile.drive.effective_track_m
        twist, gyro = Twist(0.0, 0.0), self._gyroscope.bias_radps
        if dt_s > 0:
            twist = Twist(
                (wheels[0] + wheels[1]) / (2 * dt_s), (wheels[1] - wheels[0]) / (track_m * dt_s)
            )
            gyro = self._gyroscope.read(turned, dt_s)
            self.odometry = moved(self.odometry, Twist(twist.linear_mps, gyro), dt_s)
        ranges = self._ranges.read(self.truth, time_s, self._caster(time_s), self._corners)
        return Observation(time_s, dt_s, ranges, self.odometry, self.odometry, twist, wheels, gyro)

    def command(self, linear_mps: float, angular_radps: float) -> None:
        """Ask for speeds; they come after the profile's latency, at its accelerations."""
        self._firmware.command(self.time_s, Twist(linear_mps, angular_radps))

    def _step(self) -> None:
        # As the kinematic robot: the turn rate errs once and from moment to moment.
        noise, track_m = self._noise, self.profile.drive.effective_track_m
        keep = math.exp(-STEP_S / noise.slip_correlation_s)
        drawn = float(self._random.standard_normal())
        self._slip = keep * self._slip + math.sqrt(1 - keep * keep) * noise.slip_sigma * drawn
        linear, angular = self._firmware.step(self.time_s, STEP_S)
        true = Twist(linear, angular / self._track_scale * (1 + self._slip))
        self.truth = moved(self.truth, true, STEP_S)
        left, right, turned = self._since
        half = angular * track_m / 2
        self._since = (
            left + (linear - half) * STEP_S,
            right + (linear + half) * STEP_S,
            turned + true.angular_radps * STEP_S,
        )
        self._steps += 1

    def _caster(self, time_s: float) -> Caster:
        around = [self.around.shapes]
        moving = self.around.moving(time_s)
        if moving is not None:
            around.append(_brain.Shapes(moving, np.zeros((0, 5))))

        def cast(origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
            angles = np.arctan2(directions[:, 1], directions[:, 0])
            at = (float(origin[0]), float(origin[1]))
            first, *others = (shapes.cast(at, angles, self._ranges.reach_m) for shapes in around)
            for ranges, cosines in others:
                nearer = ranges < first[0]
                first = np.where(nearer, ranges, first[0]), np.where(nearer, cosines, first[1])
            return first

        return cast


def _corners(boxes: Floats) -> Floats:
    """Corners (4 m, 2) of boxes (m, 5); they echo to every side."""
    x, y, heading, length, width = boxes.T
    c, s = np.cos(heading), np.sin(heading)
    corners = [
        np.column_stack([x + c * u * length - s * v * width, y + s * u * length + c * v * width])
        for u, v in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    ]
    return np.vstack(corners)
