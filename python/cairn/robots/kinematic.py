"""A robot without physics: exact arcs, the firmware's ramp and latency, sensors that err."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cairn import errors
from cairn.profile import Noise, Profile
from cairn.robots import rectangles as rect
from cairn.robots.firmware import Firmware
from cairn.robots.rectangles import Floats
from cairn.robots.robot import (
    Contact,
    Pose,
    Readings,
    Sill,
    Twist,
    as_twist,
    displaced,
    moved,
    positive_scale,
    wrap_angle,
)
from cairn.robots.scene import Scene, Stage
from cairn.robots.sensors import Firing, Gyroscope, RangeSensors, WheelEncoders

_STEP_S = 0.01
_BISECTIONS = 12


class KinematicRobot:
    """Moves on the arcs of [Maalouf06 (1)]; stops where its outline meets something.

    Skid steer: the true turn rate is the wheels' over an effective track that differs from the
    profile's, once by a draw and again from moment to moment (`Noise`).
    """

    def __init__(
        self,
        profile: Profile,
        scene: Scene,
        start: Sequence[float],
        *,
        seed: int = 0,
        noise: Noise | None = None,
        firing: Firing = "all",
    ) -> None:
        """Stand at `start` (x, y, heading), world frame.

        Args:
            profile: what robot it is.
            scene: what stands around it.
            start: pose [m, m, rad].
            seed: of everything that is drawn.
            noise: how its sensors err; the profile's own by default, `profile.noise.scaled(0)` for
                exact ones.
            firing: "all" reads every sonar every time; "sequenced" one of each eight per 40 ms.

        Raises:
            StandsInObstacle: something stands at the start.
            ProfileTableMissing: no noise given, and none in the profile.
        """
        self.profile = profile
        noise = require_noise(profile, noise)
        self._noise = noise
        self._stage = scene.stage()
        self._firmware = Firmware(profile)
        self._encoders = WheelEncoders(noise, seed)
        self._gyroscope = Gyroscope(noise, seed)
        self._ranges = RangeSensors(profile, noise, seed, firing)
        self._random = np.random.default_rng([seed, 4])
        self._track_scale = 1 + noise.track_scale_sigma * float(self._random.standard_normal())
        self._slip = 0.0
        x, y, heading = map(float, start)
        self._pose = Pose(x, y, wrap_angle(heading))
        self._stage.refuse_if_taken(self._pose, profile.footprint)
        self._circle_m = math.hypot(profile.footprint.length_m, profile.footprint.width_m) / 2
        self._time_s = 0.0
        self._velocity = Twist(0.0, 0.0)
        self._contacts: list[Contact] = []
        self._touching: str | None = None
        # Nothing is nearer than this; spent by motion, renewed when used up.
        self._margin_m = 0.0
        self._sills: list[Sill] = []
        self._since = (0.0, 0.0, 0.0, 0.0)  # left and right travel, turn, time since `sense`

    @property
    def time_s(self) -> float:
        """The robot's own clock."""
        return self._time_s

    @property
    def truth(self) -> Pose:
        """Where it really is."""
        return self._pose

    @property
    def velocity(self) -> Twist:
        """How it really moves."""
        return self._velocity

    @property
    def stage(self) -> Stage:
        """What stands around it now."""
        return self._stage

    @property
    def contacts(self) -> list[Contact]:
        """Every touch, oldest first."""
        return list(self._contacts)

    @property
    def clearance_m(self) -> float:
        """Least distance now from its outline to anything standing; inf alone."""
        if self._touching is not None:
            return 0.0
        return self._stage.clearance_m(self._pose, self.profile.footprint)

    def command(self, twist: Any) -> None:
        """Ask for speeds; they take effect after the latency, at the profile's accelerations."""
        self._firmware.command(self._time_s, as_twist(twist))

    def advance(self, dt_s: float) -> None:
        """Move for `dt_s`, in steps of at most 10 ms."""
        if not (math.isfinite(dt_s) and dt_s > 0):
            raise errors.StepOutOfRange(f"dt_s is {dt_s}, must be a positive time", dt_s=dt_s)
        steps = math.ceil(dt_s / _STEP_S - 1e-9)
        for _ in range(steps):
            self._step(dt_s / steps)

    def sense(self) -> Readings:
        """Read encoders, gyroscope and ranges."""
        left, right, turned, elapsed = self._since
        self._since = (0.0, 0.0, 0.0, 0.0)
        nearby = self._stage.rectangles[
            self._stage.near(self._pose.x, self._pose.y, self._ranges.reach_m)
        ]

        def cast(origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
            return rect.cast(np.broadcast_to(origin, directions.shape), directions, nearby)

        return Readings(
            self._ranges.read(self._pose, self._time_s, cast, self._stage.corners),
            self._encoders.read((left, right)),
            self._gyroscope.read(turned, elapsed),
            self._time_s,
        )

    def shove(self, dx: float, dy: float, dheading: float = 0.0) -> None:
        """Move it by force, in its own frame; see `SimulatedRobot.shove`."""
        there = displaced(self._pose, dx, dy, dheading)
        self._stage.refuse_if_taken(there, self.profile.footprint)
        self._pose = there
        self._margin_m = 0.0
        self._touching = None
        left, right, turned, elapsed = self._since
        self._since = (left, right, turned + dheading, elapsed)

    def hold(self, half_width_m: float) -> None:
        """Hold it by something unseen; see `SimulatedRobot.hold`."""
        self._sills.append(Sill.under(self._pose, half_width_m))

    def change_floor(self, track_scale: float) -> None:
        """Drive onto another floor; see `SimulatedRobot.change_floor`."""
        self._track_scale = positive_scale(track_scale)

    def emergency_stop(self, for_s: float) -> None:
        """Press its emergency stop; see `SimulatedRobot.emergency_stop`."""
        self._firmware.emergency_stop(self._time_s, for_s)

    def _step(self, dt_s: float) -> None:
        if self._stage.update(self._time_s, ((self._pose, self.profile.footprint),)):
            self._margin_m = 0.0
        set_point = self._firmware.step(self._time_s, dt_s)
        self._wander(dt_s)
        true = Twist(
            set_point.linear_mps,
            set_point.angular_radps / self._track_scale * (1 + self._slip),
        )
        self._time_s += dt_s
        reach = (abs(true.linear_mps) + abs(true.angular_radps) * self._circle_m) * dt_s
        fraction = 1.0
        if reach > 0 and reach >= self._margin_m:
            fraction = self._free_fraction(true, dt_s, reach)
        self._margin_m -= reach
        there = moved(self._pose, true, dt_s * fraction)
        if any(sill.depth_m(there.x, there.y) > 0 for sill in self._sills):
            # Its wheels spin where it stands.
            true, there = Twist(0.0, 0.0), self._pose
        self._velocity = true if fraction == 1.0 else Twist(0.0, 0.0)
        self._pose = there
        half = set_point.angular_radps * self.profile.drive.effective_track_m / 2
        left, right, turned, elapsed = self._since
        self._since = (
            left + (set_point.linear_mps - half) * dt_s * fraction,
            right + (set_point.linear_mps + half) * dt_s * fraction,
            turned + true.angular_radps * dt_s * fraction,
            elapsed + dt_s,
        )
        if fraction < 1.0:
            self._firmware.halt()

    def _free_fraction(self, true: Twist, dt_s: float, reach_m: float) -> float:
        """How much of a step is free; notes a contact where it is not all."""
        footprint = self.profile.footprint
        there = moved(self._pose, true, dt_s)
        name = self._stage.touching(there, footprint)
        if name is None:
            self._touching = None
            self._margin_m = reach_m + self._stage.clearance_m(there, footprint)
            return 1.0
        free, blocked = 0.0, 1.0
        for _ in range(_BISECTIONS):
            middle = (free + blocked) / 2
            if self._stage.touching(moved(self._pose, true, dt_s * middle), footprint):
                blocked = middle
            else:
                free = middle
        if self._touching != name:
            self._contacts.append(Contact(self._time_s, name))
            self._touching = name
        self._margin_m = 0.0
        return free

    def _wander(self, dt_s: float) -> None:
        """One step of the slip, an Ornstein-Uhlenbeck process: exact for any step."""
        noise = self._noise
        keep = math.exp(-dt_s / noise.slip_correlation_s)
        drawn = float(self._random.standard_normal())
        self._slip = keep * self._slip + noise.slip_sigma * math.sqrt(1 - keep * keep) * drawn


def require_noise(profile: Profile, noise: Noise | None) -> Noise:
    """`noise`, or the profile's own."""
    chosen = noise if noise is not None else profile.noise
    if chosen is None:
        raise errors.ProfileTableMissing(
            f"profile `{profile.name}` has no [noise]: give one, or add the table",
            profile=profile.name,
            table="noise",
        )
    return chosen
