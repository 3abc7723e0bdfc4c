"""What every robot offers, simulated or real: take a command, let time pass, read the sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.profile import Profile

if TYPE_CHECKING:
    from cairn.robots.scene import Stage


class Pose(NamedTuple):
    """Where a robot's centre is and looks, world frame [m, m, rad]; heading in (−π, π]."""

    x: float
    y: float
    heading: float


class Twist(NamedTuple):
    """Speed along the robot's x axis [m/s] and turn rate, counter-clockwise [rad/s]."""

    linear_mps: float
    angular_radps: float


class Contact(NamedTuple):
    """One touch, from its first moment until the robot came free again."""

    time_s: float
    name: str


@dataclass(frozen=True)
class Readings:
    """What the sensors say, since the last time they were asked.

    Attributes:
        ranges_m: sonars in firing-number order, then lidar beams, (n,); inf: no echo; nan: not
            measured this time.
        wheels_m: travel of the left and the right side since the last reading, by encoders.
        gyro_radps: mean turn rate since the last reading, by gyroscope.
        time_s: the robot's own clock.
    """

    ranges_m: NDArray[np.float64]
    wheels_m: tuple[float, float]
    gyro_radps: float
    time_s: float


class Robot(Protocol):
    """A robot that a navigator can drive."""

    profile: Profile

    @property
    def time_s(self) -> float:
        """The robot's own clock."""
        ...

    def command(self, twist: Any) -> None:
        """Ask for speeds: anything with `linear_mps` and `angular_radps`, or a pair of them.

        They hold until the next command; the robot keeps its own limits.

        Raises:
            CommandNotFinite: NaN or infinity.
        """
        ...

    def advance(self, dt_s: float) -> None:
        """Let time pass.

        Raises:
            StepOutOfRange: not a positive time that the robot can step by.
        """
        ...

    def sense(self) -> Readings:
        """Read the sensors."""
        ...


class SimulatedRobot(Robot, Protocol):
    """A robot whose truth is known to the judge of a run (never to the navigator)."""

    @property
    def truth(self) -> Pose:
        """Where it really is."""
        ...

    @property
    def velocity(self) -> Twist:
        """How it really moves."""
        ...

    @property
    def stage(self) -> Stage:
        """What stands around it now; robots of one physics share it."""
        ...

    @property
    def contacts(self) -> list[Contact]:
        """Every touch of its body with anything but the floor, oldest first."""
        ...

    @property
    def clearance_m(self) -> float:
        """Least distance now from its outline to anything standing; 0 in contact, inf alone."""
        ...

    def shove(self, dx: float, dy: float, dheading: float = 0.0) -> None:
        """Move it by force: `dx` forward and `dy` leftward in its own frame [m], then turn it.

        The wheels do not notice; the gyroscope does.

        Raises:
            StandsInObstacle: something stands there already; nothing is changed.
        """
        ...

    def hold(self, half_width_m: float) -> None:
        """Hold it by something that no sensor shows, a doorstep under its wheels, say.

        From now on its centre cannot drive on across the line through it, at a right angle to its
        heading and `half_width_m` to either side; back and around it can. Its wheels spin.

        Raises:
            StepOutOfRange: not a positive width.
        """
        ...

    def change_floor(self, track_scale: float) -> None:
        """Drive onto another floor: the effective track is so many times the profile's from now on.

        Above 1 the robot slips more, and turns less than its wheels say.

        Raises:
            FloorOutOfRange: not a positive finite number.
        """
        ...

    def emergency_stop(self, for_s: float) -> None:
        """Press its emergency stop for a time: the motors brake hard and ignore commands.

        What was commanded before or meanwhile is forgotten; the sensors go on.

        Raises:
            StepOutOfRange: not a positive time.
        """
        ...


@dataclass(frozen=True)
class Sill:
    """What holds a robot: a line [m, world frame] that its centre cannot cross one way."""

    at: Pose
    half_width_m: float

    @classmethod
    def under(cls, pose: Pose, half_width_m: float) -> Sill:
        """The sill that begins to hold a robot at `pose`.

        Raises:
            StepOutOfRange: `half_width_m` is not a positive number.
        """
        if not (math.isfinite(half_width_m) and half_width_m > 0):
            raise errors.StepOutOfRange(
                f"half_width_m is {half_width_m}, must be a positive width", dt_s=half_width_m
            )
        return cls(pose, half_width_m)

    def depth_m(self, x: float, y: float) -> float:
        """How far a centre is beyond the line; 0 where it is not, or no longer, held."""
        c, s = math.cos(self.at.heading), math.sin(self.at.heading)
        dx, dy = x - self.at.x, y - self.at.y
        beyond, aside = c * dx + s * dy, c * dy - s * dx
        held = abs(aside) <= self.half_width_m and 0 < beyond < _SILL_REACH_M
        return beyond if held else 0.0


# A robot that is this far beyond a sill has come from the other side.
_SILL_REACH_M = 0.3


def as_twist(twist: Any) -> Twist:
    """`twist`, given as a pair or as anything with the two speeds as attributes; checked."""
    if hasattr(twist, "linear_mps"):
        linear, angular = float(twist.linear_mps), float(twist.angular_radps)
    else:
        linear, angular = map(float, twist)
    if not (math.isfinite(linear) and math.isfinite(angular)):
        raise errors.CommandNotFinite(
            f"commanded speeds are ({linear} m/s, {angular} rad/s), must be finite",
            linear_mps=linear,
            angular_radps=angular,
        )
    return Twist(linear, angular)


def positive_scale(track_scale: float) -> float:
    """`track_scale`, checked."""
    if not (math.isfinite(track_scale) and track_scale > 0):
        raise errors.FloorOutOfRange(
            f"track_scale is {track_scale}, must be a positive finite number",
            track_scale=track_scale,
        )
    return float(track_scale)


def wrap_angle(angle: float) -> float:
    """`angle` in (−π, π]."""
    return -((-angle + math.pi) % (2 * math.pi) - math.pi)


def moved(pose: Pose, twist: Twist, dt_s: float) -> Pose:
    """Exact arc of constant speeds [Maalouf06 (1)]."""
    turn = twist.angular_radps * dt_s
    half = turn / 2
    chord = (
        twist.linear_mps
        * dt_s
        * (1 - half * half / 6 if abs(half) < 1e-4 else math.sin(half) / half)
    )
    return Pose(
        pose.x + chord * math.cos(pose.heading + half),
        pose.y + chord * math.sin(pose.heading + half),
        wrap_angle(pose.heading + turn),
    )


def displaced(pose: Pose, dx: float, dy: float, dheading: float) -> Pose:
    """`pose` moved by (dx, dy) in its own frame, then turned."""
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    return Pose(
        pose.x + c * dx - s * dy, pose.y + s * dx + c * dy, wrap_angle(pose.heading + dheading)
    )
