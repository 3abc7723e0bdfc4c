"""Where the robot is on a known map: kept, found from nothing, and found again.

A set of poses is moved as the robot moves and weighed by how near the map's surfaces are to where
its ranges ended: Monte Carlo localisation [Fox99] in a likelihood field [Thrun05 §6.4], with as
many poses as the spread needs [Fox03].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain
from cairn.odometry import MatchReport, _pose
from cairn.profile import Profile
from cairn.world import World

__all__ = ["LocaliseReport", "Localiser", "MonteCarlo", "PoseEstimate"]


@dataclass(frozen=True)
class PoseEstimate:
    """What a set of poses says."""

    pose: tuple[float, float, float]
    """Mean (x, y, heading) around the heaviest place, world frame [m, m, rad]."""
    covariance: NDArray[np.float64]
    """Of `pose`, (3, 3) [m², m·rad, rad²]."""
    share: float
    """Share of all weight around that place, 0 to 1."""
    rival: tuple[float, float, float] | None
    """The heaviest place elsewhere."""
    rival_share: float
    """Share of all weight around the rival."""
    particles: int
    """Poses in the set."""


@dataclass(frozen=True)
class LocaliseReport:
    """What one tick of a `Localiser` did."""

    is_found: bool
    """The map explains what is measured at the pose; otherwise all of the map is searched."""
    fit: float
    """Share of the readings that the map explains at the pose, over the last while, 0 to 1."""
    contradicted: float
    """Share of the readings that cannot be at the pose, if the map is right, 0 to 1."""
    candidate: PoseEstimate | None
    """What the set of poses says."""
    candidate_fit: float
    """As `fit`, at the candidate."""
    searched: int
    """Poses looked at by a search of the whole map that begins in this tick; 0 without one."""
    lead: float | None
    """How much likelier the last readings are, all together, at the best place of the map than at
    any other (while the pose is believed: at it than at any other), a difference of logarithms;
    where a search of the whole map ended in this tick."""
    jump: tuple[float, float, float] | None
    """The pose was moved to the candidate: by (x, y, heading), world frame [m, m, rad]."""
    matching: MatchReport | None
    """What matching the ranges to the map did to the pose."""


class MonteCarlo:
    """A set of poses on a known map. Its bits follow from map, seed and inputs alone.

    Args:
        world: the map.
        profile: whose sonars and lidar the ranges are from.
        seed: of everything drawn, at least 0.
        config: settings that differ from `default_config`.

    Raises:
        LocaliseValueOutOfRange: a setting cannot be.
        LocaliseMapEmpty: nothing stands on the map.
        LocaliseNoSensor: the profile has neither sonars nor a lidar.
    """

    def __init__(
        self,
        world: World,
        profile: Profile | str = "p3at",
        *,
        seed: int = 1,
        config: Mapping[str, Any] | None = None,
    ) -> None:
        self.profile = profile if isinstance(profile, Profile) else Profile.load(profile)
        self._brain = _brain.MonteCarlo(
            _parts(world), self.profile, int(seed), None if config is None else dict(config)
        )

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.MonteCarlo.default_config()

    def spread(self, pose: ArrayLike, sigma_m: float = 0.15, sigma_rad: float = 0.07) -> None:
        """Begin around (x, y, heading) [m, m, rad], with these standard deviations.

        Raises:
            LocaliseInputNotFinite: it is not a pose, or a deviation is negative.
        """
        self._brain.spread(_pose(pose), float(sigma_m), float(sigma_rad))

    def search(self, ranges_m: ArrayLike) -> int:
        """Begin anywhere: weigh a lattice over all free places, draw from it; return its size.

        Args:
            ranges_m: (n,) the sonars, then the lidar's beams [m]; inf no echo, nan not measured.

        Raises:
            LocaliseRangeCount: not one range for each sensor.
            LocaliseNoRoom: the robot fits nowhere on the map.
        """
        return self._brain.search(_ranges(ranges_m))

    def predict(self, before_from_now: ArrayLike) -> None:
        """Note a motion by odometry: (x, y, heading) of now in the frame before [m, m, rad].

        Raises:
            LocaliseInputNotFinite: it is no motion.
        """
        self._brain.predict(_pose(before_from_now))

    @property
    def is_due(self) -> bool:
        """The robot has moved enough for another `update` to say something new."""
        return self._brain.is_due

    def update(self, ranges_m: ArrayLike) -> int:
        """Move the poses by the motions noted and weigh them; return how many ranges were used.

        Raises:
            LocaliseRangeCount: not one range for each sensor.
        """
        return self._brain.update(_ranges(ranges_m))

    @property
    def estimate(self) -> PoseEstimate | None:
        """What the set says now; None before `spread` or `search`."""
        return _estimate(self._brain.estimate())

    @property
    def particles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Poses (n, 3) [m, m, rad], world frame, and their weights (n,), which sum to 1."""
        return self._brain.particles()

    def likelihood(self, pose: ArrayLike, ranges_m: ArrayLike) -> float:
        """Return the mean logarithm of the likelihood of a range at `pose`; -inf in a wall.

        Raises:
            LocaliseRangeCount: not one range for each sensor.
        """
        return self._brain.likelihood(_pose(pose), _ranges(ranges_m))


class Localiser:
    """Odometry kept on a known map, found when nothing is known, noticed when it is wrong.

    Ranges matched to the map correct the pose a little at each tick. A set of poses is weighed
    beside it: where the map explains more at its heaviest place, the pose goes there. When the map
    explains too little, all of it is searched; the pose is moved only to what has proven itself on
    the way.

    Args:
        world: the map.
        profile: the robot, or the name of its profile.
        start: (x, y, heading), about right [m, m, rad]; None: it may be anywhere.
        seed: of everything drawn, at least 0.
        config, matching, odometry: settings that differ from `default_config` of this class, of
            `cairn.odometry.MapMatcher` and of `cairn.odometry.Odometry`.

    Raises:
        LocaliseValueOutOfRange, MatchingValueOutOfRange, OdometryValueOutOfRange: a setting cannot
            be.
        LocaliseMapEmpty, LocaliseNoSensor: there is nothing to recognise, or nothing to see with.
    """

    def __init__(
        self,
        world: World,
        profile: Profile | str = "p3at",
        *,
        start: ArrayLike | None = None,
        seed: int = 1,
        config: Mapping[str, Any] | None = None,
        matching: Mapping[str, Any] | None = None,
        odometry: Mapping[str, Any] | None = None,
    ) -> None:
        self.profile = profile if isinstance(profile, Profile) else Profile.load(profile)
        self._brain = _brain.Localiser(
            _parts(world),
            self.profile,
            None if start is None else _pose(start),
            {**(config or {}), "seed": int(seed)},
            None if matching is None else dict(matching),
            None if odometry is None else dict(odometry),
        )

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.Localiser.default_config()

    def step(
        self,
        ranges: ArrayLike,
        wheels: tuple[float, float],
        gyro: float | None,
        dt_s: float,
    ) -> LocaliseReport:
        """One tick: what was measured since the last one.

        Args:
            ranges: (n,) the sonars, then the lidar's beams [m]; inf no echo, nan not measured.
            wheels: (left, right) travel of each side by encoders [m].
            gyro: mean turn rate [rad/s]; None without a gyroscope.
            dt_s: length of the tick.

        Raises:
            LocaliseRangeCount, OdometryInputNotFinite, OdometryValueOutOfRange: what was given
                cannot be a measurement.
        """
        left, right = wheels
        report = self._brain.step(
            _ranges(ranges),
            (float(left), float(right)),
            None if gyro is None else float(gyro),
            float(dt_s),
        )
        matching, jump = report["matching"], report["jump"]
        if matching is not None:
            matching = MatchReport(**{**matching, "correction": _triple(matching["correction"])})
        return LocaliseReport(
            is_found=report["state"] == "tracking",
            fit=report["fit"],
            contradicted=report["contradicted"],
            candidate=_estimate(report["candidate"]),
            candidate_fit=report["candidate_fit"],
            searched=report["searched"],
            lead=report["lead"],
            jump=None if jump is None else _triple(jump),
            matching=matching,
        )

    def set_pose(self, pose: ArrayLike) -> None:
        """Put the robot at about (x, y, heading) [m, m, rad].

        Raises:
            OdometryInputNotFinite: it is not a pose.
        """
        self._brain.set_pose(_pose(pose))

    def forget(self) -> None:
        """Forget the pose: the robot may be anywhere."""
        self._brain.forget()

    @property
    def is_found(self) -> bool:
        """Whether the pose is known."""
        return self._brain.is_found

    @property
    def learnt(self) -> tuple[float, float, float]:
        """(path scale [m/m], gyro scale [rad/rad], gyro bias [rad/s]), as `Odometry` has them."""
        return self._brain.learnt

    @property
    def pose(self) -> tuple[float, float, float]:
        """(x, y, heading) in the world [m, m, rad]; of the odometry's own frame until found."""
        return self._brain.pose

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of `pose`, (3, 3) [m², m·rad, rad²]."""
        return self._brain.covariance()

    @property
    def particles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The set of poses: (n, 3) [m, m, rad], world frame, and their weights (n,)."""
        return self._brain.particles()


def _parts(world: World) -> tuple[NDArray[np.uint8], float, tuple[float, float, float]]:
    return (world.occupancy, world.resolution_m, world.origin)


def _ranges(ranges_m: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(np.atleast_1d(np.asarray(ranges_m, dtype=float)))


def _triple(pose: Mapping[str, float]) -> tuple[float, float, float]:
    return (pose["x"], pose["y"], pose["heading"])


def _estimate(estimate: dict[str, Any] | None) -> PoseEstimate | None:
    if estimate is None:
        return None
    rival = estimate["rival"]
    return PoseEstimate(
        pose=_triple(estimate["pose"]),
        covariance=np.array(estimate["covariance"]),
        share=estimate["share"],
        rival=None if rival is None else _triple(rival),
        rival_share=estimate["rival_share"],
        particles=estimate["particles"],
    )
