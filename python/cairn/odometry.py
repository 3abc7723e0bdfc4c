"""Where the robot is by its own motion, and small corrections from sonar against a known map."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain
from cairn.profile import Profile
from cairn.world import World

__all__ = ["MapMatcher", "MatchReport", "Odometry"]


class Odometry:
    """Encoders and gyro fused into a pose with covariance: an extended Kalman filter.

    The turn of a tick is the mean of both, each weighted by the other's variance; the path is the
    mean of the two sides along the exact arc [Maalouf06 §2 (1)]. At rest the gyro shows its bias;
    in turns it teaches how the wheels slip. The scales of encoders and gyro are part of the state,
    and learnt where ranges are matched to a map [Martinelli07].

    Args:
        profile: whose wheels they are.
        start: (x, y, heading) in the world [m, m, rad].
        config: settings that differ from `default_config`.

    Raises:
        OdometryValueOutOfRange: a setting cannot be.
        OdometryInputNotFinite: the start is not a pose.
    """

    def __init__(
        self,
        profile: Profile,
        start: ArrayLike = (0.0, 0.0, 0.0),
        *,
        config: Mapping[str, Any] | None = None,
    ) -> None:
        self._brain = _brain.Odometry(
            profile, _pose(start), None if config is None else dict(config)
        )

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.Odometry.default_config()

    def predict(self, wheels_m: tuple[float, float], gyro_radps: float | None, dt_s: float) -> None:
        """Add one tick.

        Args:
            wheels_m: (left, right) path of the wheels since the last tick [m].
            gyro_radps: mean yaw rate the gyro showed [rad/s]; None without a gyro.
            dt_s: length of the tick [s].

        Raises:
            OdometryInputNotFinite, OdometryValueOutOfRange: nothing is changed then.
        """
        left, right = wheels_m
        gyro = None if gyro_radps is None else float(gyro_radps)
        self._brain.predict((float(left), float(right)), gyro, float(dt_s))

    def set_pose(self, pose: ArrayLike) -> None:
        """Put the robot at (x, y, heading) [m, m, rad]; the learnt gyro bias stays.

        Raises:
            OdometryInputNotFinite: it is not a pose.
        """
        self._brain.set_pose(_pose(pose))

    @property
    def pose(self) -> tuple[float, float, float]:
        """(x, y, heading) in the world [m, m, rad]."""
        return self._brain.pose

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of `pose`, (3, 3), symmetric and positive semidefinite."""
        return self._brain.covariance()

    @property
    def twist(self) -> tuple[float, float]:
        """Mean (V [m/s], ω [rad/s]) over the last tick."""
        return self._brain.twist

    @property
    def gyro_bias_radps(self) -> float:
        """What the gyro is believed to show at rest [rad/s]."""
        return self._brain.gyro_bias_radps

    @property
    def path_m(self) -> float:
        """Length of the path driven so far [m]."""
        return self._brain.path_m

    @property
    def effective_track_m(self) -> tuple[float, float]:
        """Effective track as learnt from the gyro, and its standard deviation [m]."""
        return self._brain.effective_track_m

    @property
    def veer_radpm(self) -> float:
        """Turn per path of wheels that are not alike, learnt from the gyro [rad/m]."""
        return self._brain.veer_radpm

    @property
    def path_scale(self) -> float:
        """What a metre of the encoders is too short by, learnt from a map [m/m]."""
        return self._brain.path_scale

    @property
    def gyro_scale(self) -> float:
        """What a radian of the gyro is too short by, learnt from a map [rad/rad]."""
        return self._brain.gyro_scale


@dataclass(frozen=True)
class MatchReport:
    """What one correction did."""

    used: int
    """Echoes the map explains."""
    rejected: int
    """Echoes it does not explain."""
    correction: tuple[float, float, float]
    """Added to the pose (x, y, heading) [m, m, rad]."""
    bounded: bool
    """The correction was larger than one tick allows, and was cut."""


class MapMatcher:
    """Corrects odometry by the sonar echoes that a known map explains, a little at each tick.

    Args:
        world: the known map.
        config: settings that differ from `default_config`.

    Raises:
        MatchingValueOutOfRange: a setting cannot be.
    """

    def __init__(self, world: World, *, config: Mapping[str, Any] | None = None) -> None:
        parts = (world.occupancy, world.resolution_m, world.origin)
        self._brain = _brain.MapMatcher(parts, None if config is None else dict(config))

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.MapMatcher.default_config()

    def correct(self, odometry: Odometry, profile: Profile, ranges_m: ArrayLike) -> MatchReport:
        """Correct `odometry` by ranges taken at its pose, (n,) [m], sonars first.

        Raises:
            MatchingRangeCount: fewer ranges than sonars.
        """
        ranges = np.atleast_1d(np.asarray(ranges_m, dtype=float))
        report = self._brain.correct(odometry._brain, profile, ranges)
        moved = report.pop("correction")
        return MatchReport(correction=(moved["x"], moved["y"], moved["heading"]), **report)


def _pose(pose: ArrayLike) -> tuple[float, float, float]:
    x, y, heading = np.asarray(pose, dtype=float)
    return float(x), float(y), float(heading)
