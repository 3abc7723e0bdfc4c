"""The spin test: how a skid-steer robot's wheels slip, measured by turning on the spot.

Any robot that takes commands and gives readings will do, simulated or real. It stands, turns on
the spot both ways at several rates, and stands again; at rest the gyroscope shows its bias, and
what the sides drove against each other over what it turned is the effective track b of
[Maalouf06 §2].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from cairn import errors
from cairn.robots.robot import Robot, Twist, wrap_angle

__all__ = ["Spin", "SpinTest", "spin_test"]

TICK_S = 0.1


@dataclass(frozen=True)
class Spin:
    """One turn on the spot."""

    rate_radps: float
    """As commanded; positive is counter-clockwise."""
    turned_rad: float
    """By the gyroscope, its bias taken off."""
    driven_m: float
    """Right side less left side."""
    effective_track_m: float
    """Their quotient."""
    crept_m: float
    """How far the middle of both sides drove meanwhile: 0 on the spot."""
    truth_m: float | None
    """Effective track by the true turn; simulated robots only."""


@dataclass(frozen=True)
class SpinTest:
    """What a spin test found."""

    effective_track_m: float
    """What the profile should say."""
    sigma_m: float
    """Standard deviation of that, by how much the spins differ; the gyroscope's own scale, about
    0.3 %, comes on top."""
    profile_track_m: float
    """What the profile says."""
    slip_factor: float | None
    """Effective track over the distance of the wheels, where the profile knows it."""
    gyro_bias_radps: float
    """At rest, before and after."""
    gyro_sigma_radps: float
    """Standard deviation of one reading at rest."""
    truth_m: float | None
    """Effective track by the true turn; simulated robots only."""
    spins: tuple[Spin, ...]

    @property
    def correction(self) -> float:
        """Effective track found over that of the profile."""
        return self.effective_track_m / self.profile_track_m

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return {**asdict(self), "correction": self.correction}


def spin_test(
    robot: Robot,
    *,
    turns: float = 3.0,
    rates_radps: tuple[float, ...] = (0.5, 1.0, 1.5),
    rest_s: float = 8.0,
    tick_s: float = TICK_S,
    watch: Callable[[str], None] | None = None,
) -> SpinTest:
    """Turn on the spot, both ways at each rate, and tell the effective track.

    The robot needs as much room as its circle. A real robot takes about
    2 · turns · Σ 2π / rate + rest seconds: three minutes by default.

    Args:
        robot: what is driven; see `cairn.robots.Robot`.
        turns: of each spin.
        rates_radps: how fast, slower ones first.
        rest_s: how long it stands before and after [s].
        tick_s: how often it is asked and told [s].
        watch: told what is going on.

    Raises:
        SpinTestRefused: a number is not usable, or the robot does not turn.
    """
    _check(turns, rates_radps, rest_s, tick_s)
    say = watch or (lambda _: None)
    drive = _Driver(robot, tick_s)
    say(f"standing for {rest_s:g} s")
    before = drive.rest(rest_s)
    began_s = drive.time_s
    raw: list[_Raw] = []
    for rate in rates_radps:
        for signed in (rate, -rate):
            say(f"{turns:g} turns at {signed:+.2f} rad/s")
            raw.append(drive.spin(signed, turns))
    ended_s = drive.time_s
    say(f"standing for {rest_s:g} s")
    after = drive.rest(rest_s)
    first, last = float(before.mean()), float(after.mean())

    def bias(time_s: float) -> float:
        """Between the rests, linear in time."""
        return first + (last - first) * (time_s - began_s) / max(ended_s - began_s, 1e-9)

    spins = tuple(each.corrected(bias(each.middle_s)) for each in raw)
    driven = np.array([spin.driven_m for spin in spins])
    turned = np.array([spin.turned_rad for spin in spins])
    track_m = float((driven @ turned) / (turned @ turned))
    each = np.array([spin.effective_track_m for spin in spins])
    truths = [spin.truth_m for spin in spins if spin.truth_m is not None]
    physics = getattr(robot.profile, "physics", None)
    return SpinTest(
        effective_track_m=track_m,
        sigma_m=float(each.std(ddof=1) / math.sqrt(len(each))),
        profile_track_m=robot.profile.drive.effective_track_m,
        slip_factor=None if physics is None else track_m / physics.track_m,
        gyro_bias_radps=(first + last) / 2,
        gyro_sigma_radps=float(np.concatenate([before - first, after - last]).std()),
        truth_m=float(np.mean(truths)) if truths else None,
        spins=spins,
    )


def _check(turns: float, rates_radps: tuple[float, ...], rest_s: float, tick_s: float) -> None:
    named = [("turns", turns), ("rest_s", rest_s), ("tick_s", tick_s)]
    for key, value in [*named, *(("rates_radps", rate) for rate in rates_radps)]:
        if not (math.isfinite(value) and value > 0):
            raise errors.SpinTestRefused(
                f"spin test: {key} is {value}, must be a positive number", reason=f"{key} {value}"
            )
    if not rates_radps:
        raise errors.SpinTestRefused("spin test: no rates given", reason="no rates")


@dataclass(frozen=True)
class _Raw:
    rate_radps: float
    gyro_rad: float
    driven_m: float
    crept_m: float
    took_s: float
    middle_s: float
    truth_rad: float | None

    def corrected(self, bias_radps: float) -> Spin:
        turned = self.gyro_rad - bias_radps * self.took_s
        return Spin(
            self.rate_radps,
            turned,
            self.driven_m,
            self.driven_m / turned,
            self.crept_m,
            None if self.truth_rad is None else self.driven_m / self.truth_rad,
        )


class _Driver:
    """Commands a robot tick by tick and adds up what it measures."""

    def __init__(self, robot: Robot, tick_s: float) -> None:
        self.robot, self.tick_s = robot, tick_s
        robot.sense()  # what it measured before does not count
        self.time_s = 0.0

    def rest(self, for_s: float) -> np.ndarray:
        """What the gyroscope says at rest [rad/s]."""
        self.robot.command(Twist(0.0, 0.0))
        return np.array(
            [self._tick().gyro_radps for _ in range(max(2, math.ceil(for_s / self.tick_s)))]
        )

    def spin(self, rate_radps: float, turns: float) -> _Raw:
        """Turn so far by the gyroscope, and come to rest."""
        gyro_rad = driven_m = crept_m = 0.0
        began_s = self.time_s
        before, truth_rad = self._truth(), 0.0
        wanted = 2 * math.pi * turns
        patience_s = 3 * wanted / abs(rate_radps) + 5.0
        resting = 0
        while resting < 5:
            turning = abs(gyro_rad) < wanted and resting == 0
            self.robot.command(Twist(0.0, rate_radps if turning else 0.0))
            readings = self._tick()
            gyro_rad += readings.gyro_radps * self.tick_s
            left, right = readings.wheels_m
            driven_m += right - left
            crept_m += (right + left) / 2
            now = self._truth()
            if before is not None and now is not None:
                truth_rad += wrap_angle(now - before)
                before = now
            stands = not turning and abs(left) < 1e-4 and abs(right) < 1e-4
            resting = resting + 1 if stands else 0
            if self.time_s - began_s > patience_s:
                raise errors.SpinTestRefused(
                    f"spin test: the robot turned by {gyro_rad:.2f} of {wanted:.2f} rad in"
                    f" {patience_s:.0f} s",
                    reason="it does not turn",
                )
        return _Raw(
            rate_radps,
            gyro_rad,
            driven_m,
            crept_m,
            self.time_s - began_s,
            (self.time_s + began_s) / 2,
            None if before is None else truth_rad,
        )

    def _tick(self) -> Any:
        self.robot.advance(self.tick_s)
        self.time_s += self.tick_s
        return self.robot.sense()

    def _truth(self) -> float | None:
        pose = getattr(self.robot, "truth", None)
        return None if pose is None else pose.heading
