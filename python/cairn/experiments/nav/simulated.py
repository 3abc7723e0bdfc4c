"""What the two robots of the benchmark share: a world around them, time, and contact."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cairn.experiments.nav.stacks import Observation
from cairn.experiments.nav.worlds import NavWorld
from cairn.profile import Profile
from cairn.robots.robot import Pose

Floats = NDArray[np.float64]

STEP_S = 0.005
"""Motion and contact are looked at two hundred times a second."""


@dataclass(frozen=True)
class Touch:
    """The first contact of the robot's outline.

    Attributes:
        step: at which pose of the motion.
        what: `circle`, `box` or `moving`.
        which: its number among them.
    """

    step: int
    what: str
    which: int


@dataclass(frozen=True, eq=False)
class Motion:
    """What happened while time passed.

    Attributes:
        times_s: (n,) of the robot's clock, at the end of each step.
        poses: (n, 3) by truth, at the same times.
        touch: the first contact among them; None without one.
    """

    times_s: NDArray[Any]
    poses: Floats
    touch: Touch | None


class Surroundings:
    """A world as it is at one time after another.

    Args:
        world: what stands and moves.
        phase_s: the world's time when the robot's clock is at 0.
    """

    def __init__(self, world: NavWorld, phase_s: float = 0.0) -> None:
        self.shapes = world.shapes()
        self.motion = world.motion()
        self.phase_s = phase_s

    def moving(self, times_s: NDArray[Any] | float) -> Floats | None:
        """(n·k, 3) everything that moves, time after time; None where nothing does."""
        if self.motion is None:
            return None
        return self.motion.at(self.phase_s + np.asarray(times_s)).reshape(-1, 3)

    def touch(
        self, times_s: NDArray[Any], poses: Floats, outline: tuple[float, float]
    ) -> Touch | None:
        """First contact of an outline (length, width) along some poses (n, 3)."""
        found = self.shapes.first_touch(poses, outline, self.moving(times_s))
        return None if found is None else Touch(*found)

    def from_jump_s(self, touch: Touch, time_s: float) -> float:
        """How near in time a jump of the moving obstacle touched is; inf for all else [s]."""
        if touch.what != "moving" or self.motion is None:
            return float("inf")
        return self.motion.from_jump_s(touch.which, self.phase_s + time_s)


class Stepped(ABC):
    """A robot that moves in steps of `STEP_S`.

    Args:
        profile: its outline and limits.
        around: what is around it.
        truth: where it stands at first.
    """

    def __init__(self, profile: Profile, around: Surroundings, truth: Pose) -> None:
        self.profile = profile
        self.around = around
        self.truth = truth
        self._outline = (profile.footprint.length_m, profile.footprint.width_m)
        self._steps = 0

    @property
    def time_s(self) -> float:
        """The robot's clock."""
        return self._steps * STEP_S

    def advance(self, dt_s: float) -> Motion:
        """Move, in steps of `STEP_S`."""
        count = round(dt_s / STEP_S)
        poses = np.empty((count, 3))
        times = STEP_S * np.arange(self._steps + 1, self._steps + count + 1, dtype=np.float64)
        for step in range(count):
            self._step()
            poses[step] = self.truth
        return Motion(times, poses, self.around.touch(times, poses, self._outline))

    @abstractmethod
    def _step(self) -> None:
        """Move by one step, and count it."""


class Simulated(Protocol):
    """A robot of the benchmark."""

    profile: Profile
    around: Surroundings
    truth: Pose

    def observe(self) -> Observation:
        """Read every sensor."""
        ...

    def command(self, linear_mps: float, angular_radps: float) -> None:
        """Ask for speeds; they hold until the next command takes effect."""
        ...

    def advance(self, dt_s: float) -> Motion:
        """Let time pass, in steps of `STEP_S`."""
        ...
