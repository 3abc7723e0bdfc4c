"""From ranges to points in the robot's frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cairn.profile import Profile

Floats = NDArray[np.float64]


class PointsOfRanges:
    """Where the readings of a profile's sensors are, in the frame of the robot."""

    def __init__(self, profile: Profile) -> None:
        origins, headings, most = [], [], []
        for sonar in profile.sonars:
            origins.append((sonar.pose.x, sonar.pose.y))
            headings.append(sonar.pose.heading)
            most.append(sonar.max_range_m)
        if profile.lidar is not None:
            lidar = profile.lidar
            at = lidar.pose
            origins += [(at.x, at.y)] * lidar.beams
            headings += list(at.heading + lidar.first_rad + lidar.step_rad * np.arange(lidar.beams))
            most += [lidar.max_range_m] * lidar.beams
        self._origins = np.asarray(origins, float).reshape(-1, 2)
        self._units = np.column_stack([np.cos(headings), np.sin(headings)])
        self._most = np.asarray(most)

    def __call__(self, ranges_m: Floats, within_m: float) -> Floats:
        """(k, 2) points of the readings within a distance of their sensor [m]."""
        seen = np.isfinite(ranges_m) & (ranges_m < np.minimum(self._most, within_m))
        return self._origins[seen] + self._units[seen] * ranges_m[seen, None]


def thinned(points: Floats, cell_m: float) -> Floats:
    """One of the points in every square cell that holds any: the first."""
    cells = np.floor(points / cell_m).astype(np.int64)
    _, first = np.unique(cells[:, 0] * 1_000_003 + cells[:, 1], return_index=True)
    return points[np.sort(first)]
