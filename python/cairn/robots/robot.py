"""What every robot offers, simulated or real: take a command, let time pass, read the sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.profile import Profile


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

    def emergency_stop(self, for_s: float) -> None:
        """Press its emergency stop for a time: the motors brake hard and ignore commands.

        What was commanded before or meanwhile is forgotten; the sensors go on.

        Raises:
            StepOutOfRange: not a positive time.
        """
        ...


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
