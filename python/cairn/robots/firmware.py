"""What the robot's own controller does to a command: it comes late, is limited, and is ramped."""

from __future__ import annotations

import math
from collections import deque

from cairn import errors
from cairn.profile import Profile
from cairn.robots.robot import Twist

# Clocks are sums of steps; a command is due when it is due to within this.
_TIME_TOLERANCE_S = 1e-7


class Firmware:
    """Commands take effect after the profile's latency and are approached at its accelerations."""

    def __init__(self, profile: Profile) -> None:
        """At rest, with nothing asked for."""
        self._limits = profile.limits
        self._latency_s = profile.drive.latency_s
        self._track_m = profile.drive.effective_track_m
        self._queue: deque[tuple[float, Twist]] = deque()
        self._wanted = Twist(0.0, 0.0)
        self._pressed_until_s = -math.inf
        self.twist = Twist(0.0, 0.0)

    def command(self, time_s: float, twist: Twist) -> None:
        """Ask for speeds at a time of the robot's clock; ignored while the stop is pressed."""
        if time_s < self._pressed_until_s - _TIME_TOLERANCE_S:
            return
        limits = self._limits
        limited = Twist(
            _clamp(twist.linear_mps, limits.linear_mps),
            _clamp(twist.angular_radps, limits.angular_radps),
        )
        self._queue.append((time_s + self._latency_s, limited))

    def step(self, time_s: float, dt_s: float) -> Twist:
        """The set point from `time_s` on for `dt_s`: one ramp step towards what is wanted."""
        while self._queue and self._queue[0][0] <= time_s + _TIME_TOLERANCE_S:
            self._wanted = self._queue.popleft()[1]
        limits = self._limits
        linear, angular = self.twist
        self.twist = Twist(
            linear + _clamp(self._wanted.linear_mps - linear, limits.linear_mps2 * dt_s),
            angular + _clamp(self._wanted.angular_radps - angular, limits.angular_radps2 * dt_s),
        )
        return self.twist

    def sides_mps(self) -> tuple[float, float]:
        """Left and right side speed of the set point: V ∓ ω·b/2 [Maalouf06 §2]."""
        linear, angular = self.twist
        half = angular * self._track_m / 2
        return linear - half, linear + half

    def emergency_stop(self, time_s: float, for_s: float) -> None:
        """Press the emergency stop: brake without a ramp, and forget what was asked.

        Raises:
            StepOutOfRange: `for_s` is not a positive time.
        """
        if not (math.isfinite(for_s) and for_s > 0):
            raise errors.StepOutOfRange(f"for_s is {for_s}, must be a positive time", dt_s=for_s)
        self._pressed_until_s = max(self._pressed_until_s, time_s + for_s)
        self._queue.clear()
        self._wanted = Twist(0.0, 0.0)
        self.halt()

    def halt(self) -> None:
        """The motors stand: the ramp starts from rest."""
        self.twist = Twist(0.0, 0.0)


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
