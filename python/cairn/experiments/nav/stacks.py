"""What a stack is told, what it sees, and by what names stacks are entered."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.profile import Profile
from cairn.robots.robot import Pose, Twist


@dataclass(frozen=True)
class Task:
    """What a stack knows before a trial.

    Attributes:
        profile: the robot.
        goal: (x, y) [m] in the odometry frame: the robot starts at (0, 0) there, looking along +x.
        tolerance_m: arrived when this near to the goal, by truth.
        period_s: control period of this trial.
        timeout_s: the trial ends so long after the robot has moved 0.1 m.
        seed: of everything that the stack draws.
    """

    profile: Profile
    goal: tuple[float, float]
    tolerance_m: float
    period_s: float
    timeout_s: float
    seed: int


@dataclass(frozen=True)
class Observation:
    """What the robot senses at one moment.

    Attributes:
        time_s: the robot's clock; 0 at the first observation.
        dt_s: since the last observation; 0 at the first.
        ranges_m: (n,) the profile's sonars, then its lidar beams [m]; inf: nothing within reach.
        scan_pose: odometry when the lidar measured, at most 20 ms before `time_s`; a lidar measures
            fifty times a second.
        odometry: the robot's pose in the odometry frame, summed from its wheels; turns are those of
            the gyroscope where there is one.
        twist: speeds of the wheels as a twist (V [m/s], ω [rad/s]); the body may slip.
        wheels_m: travel of the left and the right side since the last observation.
        gyro_radps: mean turn rate since the last observation; None for a robot without gyroscope.
    """

    time_s: float
    dt_s: float
    ranges_m: NDArray[np.float64]
    scan_pose: Pose
    odometry: Pose
    twist: Twist
    wheels_m: tuple[float, float]
    gyro_radps: float | None


Driver = Callable[[Observation], Any]
Maker = Callable[[Task], Driver]

STACKS: dict[str, str] = {
    "cairn": "cairn.experiments.nav.own:cairn_stack",
    "cvm": "cairn.experiments.nav.pure_cvm:cvm",
    "dynamic-window": "cairn.experiments.nav.dynamic_window:dynamic_window",
}
"""Built-in stacks: name → `module:function`."""


def maker(name: str) -> Maker:
    """Find a stack by its built-in name or as `module:function`.

    Raises:
        StackNotFound: no such name, module or callable.
    """
    target = STACKS.get(name, name)
    module, colon, function = target.partition(":")
    if not (colon and module and function):
        raise _not_found(name, f"give `module:function`, or one of {', '.join(STACKS)}")
    try:
        found: Any = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise _not_found(name, str(error)) from error
    if not callable(found):
        raise _not_found(name, f"{function} of {module} cannot be called")
    return cast(Maker, found)


def _not_found(name: str, reason: str) -> errors.StackNotFound:
    return errors.StackNotFound(f"stack `{name}`: {reason}", name=name, reason=reason)
