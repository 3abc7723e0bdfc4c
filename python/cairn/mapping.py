"""What stands where, learnt from ranges; and the ranges that a known map would give.

A sonar's cone is wider than a door two metres away, so an echo is not a point. Its evidence is
shared over the arc by the odds of each cell being what answered: known walls take all of it. Walls
hit obliquely do not answer, and are not forgotten for that [Elfes89] [KucSiegel87].
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain, errors
from cairn.profile import Profile
from cairn.world import World

__all__ = ["OccupancyMap", "raycast", "sonar_ranges"]


class OccupancyMap:
    """An occupancy map that ranges write into.

    Args:
        resolution_m: side of a cell [m]; with a `prior`, that of the prior.
        prior: the map to begin with, and to keep the shape of. Its walls give way only to much
            evidence. None: the map begins empty and grows in blocks as things are seen.
        config: settings that differ from `default_config`.

    Raises:
        MappingValueOutOfRange: a setting cannot be.
        SettingsInvalid: an unknown setting.
    """

    def __init__(
        self,
        resolution_m: float = 0.05,
        *,
        prior: World | None = None,
        config: Mapping[str, Any] | None = None,
    ) -> None:
        parts = None if prior is None else (prior.occupancy, prior.resolution_m, prior.origin)
        self._brain = _brain.OccupancyMap(
            float(resolution_m), parts, None if config is None else dict(config)
        )

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.OccupancyMap.default_config()

    def integrate(self, profile: Profile, pose: ArrayLike, ranges_m: ArrayLike) -> None:
        """Add one array of ranges.

        Args:
            profile: whose sensors they are.
            pose: (x, y, heading) of the robot in the world as they were taken [m, m, rad].
            ranges_m: (n,) the sonars, then the lidar's beams [m]; inf no echo, nan not measured.

        Raises:
            MappingPoseNotFinite, MappingRangeCount, MappingRangeNegative, MappingTooLarge: the map
            is then as before.
        """
        x, y, heading = np.asarray(pose, dtype=float)
        ranges = np.atleast_1d(np.asarray(ranges_m, dtype=float))
        self._brain.integrate(profile, (float(x), float(y), float(heading)), ranges)

    def world(self) -> World:
        """Return what is known now: 0 free, 1 occupied, 2 unknown.

        Raises:
            WorldShapeInvalid: nothing was seen yet, the map has no cell.
        """
        return World(self._brain.classes(), self._brain.resolution_m, self._brain.origin)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        rows, cols = self._brain.classes().shape
        return rows, cols

    @property
    def resolution_m(self) -> float:
        """Side of a cell [m]."""
        return self._brain.resolution_m

    @property
    def origin(self) -> tuple[float, float, float]:
        """(x, y, yaw) of the outer corner of cell (0, 0) in the world [m, m, rad]."""
        return self._brain.origin

    @property
    def revision(self) -> int:
        """Greater whenever a cell changed between free, occupied and unknown."""
        return self._brain.revision

    def probabilities(self) -> NDArray[np.float32]:
        """Return the probability of being occupied, (rows, cols), 0.5 where nothing is known."""
        return self._brain.probabilities()

    def unmapped(self) -> NDArray[np.bool_]:
        """Return True at cells occupied now that the prior map does not show, (rows, cols)."""
        return self._brain.unmapped()

    def occupied_near(self, center: ArrayLike, radius_m: float) -> NDArray[np.float64]:
        """Return the centres of occupied cells within `radius_m` of (x, y), (n, 2) [m]."""
        return self._brain.occupied_near(_point(center), float(radius_m))

    def unmapped_near(self, center: ArrayLike, radius_m: float) -> NDArray[np.float64]:
        """Like `occupied_near`, only what the prior map does not show, (n, 2) [m]."""
        return self._brain.unmapped_near(_point(center), float(radius_m))

    def clear_disc(self, center: ArrayLike, radius_m: float) -> None:
        """Free the cells within `radius_m` of (x, y), but no wall of the prior map."""
        self._brain.clear_disc(_point(center), float(radius_m))

    def __repr__(self) -> str:
        rows, cols = self.shape
        return f"<OccupancyMap {rows} x {cols} cells of {self.resolution_m} m>"


def raycast(
    occupied: ArrayLike,
    resolution_m: float,
    origin: ArrayLike,
    from_points: ArrayLike,
    directions_rad: ArrayLike,
    max_range_m: float = np.inf,
) -> NDArray[np.float64]:
    """Distance along rays to the first occupied cell, by exact traversal [AmanatidesWoo87].

    Args:
        occupied: bool (rows, cols), True where something stands. Outside is open space.
        resolution_m: side of a cell [m].
        origin: (x, y) or (x, y, yaw) of the outer corner of cell (0, 0) in the world [m, rad].
        from_points: (n, 2) starts in the world [m].
        directions_rad: (n,) directions in the world [rad].
        max_range_m: rays end here [m].

    Returns:
        (n,) [m]; 0 for a start in an occupied cell, inf where nothing is met, or for nan.

    Raises:
        RaysShapeMismatch: points and directions do not belong together, or the grid is not one.
    """
    grid = _grid(occupied)
    points = np.atleast_2d(np.asarray(from_points, dtype=float))
    directions = np.atleast_1d(np.asarray(directions_rad, dtype=float))
    if points.ndim != 2 or points.shape[1] != 2 or directions.shape != (len(points),):
        raise errors.RaysShapeMismatch(
            f"rays need points (n, 2) and directions (n,), not {points.shape} and"
            f" {directions.shape}",
            what="from_points, directions_rad",
            shape=points.shape,
        )
    return _brain.raycast(
        grid, float(resolution_m), _origin(origin), points, directions, float(max_range_m)
    )


def sonar_ranges(
    occupied: ArrayLike,
    resolution_m: float,
    origin: ArrayLike,
    world_from_sonar: ArrayLike,
    beam_rad: float,
    max_range_m: float,
) -> NDArray[np.float64]:
    """Ranges that sonars at these poses are expected to measure.

    The nearest surface in the cone that answers: walls hit at more than about 28 degrees of
    incidence do not, their ends and corners do.

    Args:
        occupied: bool (rows, cols), True where something stands.
        resolution_m: side of a cell [m].
        origin: (x, y) or (x, y, yaw) of the outer corner of cell (0, 0) in the world [m, rad].
        world_from_sonar: (n, 3) poses (x, y, heading) of the sonars [m, m, rad].
        beam_rad: full opening angle of the cones [rad].
        max_range_m: farthest distance they can tell [m].

    Returns:
        (n,) [m], inf for no echo.

    Raises:
        RaysShapeMismatch: the poses are not (n, 3), or the grid is not one.
    """
    grid = _grid(occupied)
    poses = np.atleast_2d(np.asarray(world_from_sonar, dtype=float))
    if poses.ndim != 2 or poses.shape[1] != 3:
        raise errors.RaysShapeMismatch(
            f"poses of sonars are (n, 3), not {poses.shape}",
            what="world_from_sonar",
            shape=poses.shape,
        )
    return _brain.sonar_ranges(
        grid, float(resolution_m), _origin(origin), poses, float(beam_rad), float(max_range_m)
    )


def _grid(occupied: ArrayLike) -> NDArray[np.bool_]:
    grid = np.asarray(occupied, dtype=bool)
    if grid.ndim != 2:
        raise errors.RaysShapeMismatch(
            f"a grid is (rows, cols), not {grid.shape}", what="occupied", shape=grid.shape
        )
    return grid


def _point(point: ArrayLike) -> tuple[float, float]:
    x, y = np.asarray(point, dtype=float)[:2]
    return float(x), float(y)


def _origin(origin: ArrayLike) -> tuple[float, float, float]:
    x, y, *yaw = np.asarray(origin, dtype=float)
    return float(x), float(y), float(yaw[0]) if yaw else 0.0
