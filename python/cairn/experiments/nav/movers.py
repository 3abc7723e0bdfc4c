"""Obstacles that move on looping Catmull-Rom splines, as Gazebo's animations do [Nair22]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mover:
    """A round obstacle on a loop.

    Attributes:
        name: as its world calls it.
        radius_m: of the disc.
        period_s: after so long it jumps back to where it began.
        keyframes: (k, 3) time [s], x, y [m]; times rise from 0, k ≥ 2.
    """

    name: str
    radius_m: float
    period_s: float
    keyframes: Floats


class Movers:
    """All moving obstacles of a world at once."""

    def __init__(self, movers: Sequence[Mover]) -> None:
        """Lay out every segment as a cubic in the time since its key frame, scaled to 0…1."""
        self.movers = tuple(movers)
        self.radii = np.array([mover.radius_m for mover in movers], float)
        self.periods = np.array([mover.period_s for mover in movers], float)
        most = max((len(mover.keyframes) for mover in movers), default=2)
        self._begins = np.full((len(movers), most), np.inf)
        self._spans = np.ones((len(movers), most))
        self._cubics = np.zeros((len(movers), most, 4, 2))
        self.jumps = np.zeros(len(movers), bool)
        for i, mover in enumerate(movers):
            times, points = mover.keyframes[:, 0], mover.keyframes[:, 1:]
            n = len(times) - 1
            self._begins[i, :n] = times[:-1]
            self._spans[i, :n] = np.diff(times)
            self._cubics[i, :n] = _catmull_rom(points)
            # Past its last key frame it stands until the period is over.
            self._begins[i, n], self._cubics[i, n, 0] = times[-1], points[-1]
            self.jumps[i] = bool(np.hypot(*(points[-1] - points[0])) > 1e-6)

    def __len__(self) -> int:
        return len(self.movers)

    def at(self, times_s: Any) -> Floats:
        """Where all are at some times of the world: (n, k, 3) x, y, radius."""
        times = np.asarray(times_s, float).reshape(-1, 1)
        into = np.mod(times, self.periods)
        segment = (self._begins <= into[:, :, None]).sum(axis=2) - 1
        segment = np.maximum(segment, 0)
        who = np.arange(len(self))
        u = np.clip((into - self._begins[who, segment]) / self._spans[who, segment], 0.0, 1.0)
        cubic = self._cubics[who, segment]
        u = u[:, :, None]
        xy = cubic[:, :, 0] + u * (cubic[:, :, 1] + u * (cubic[:, :, 2] + u * cubic[:, :, 3]))
        return np.concatenate(
            [xy, np.broadcast_to(self.radii[:, None], (*xy.shape[:2], 1))], axis=2
        )

    def from_jump_s(self, which: int, time_s: float) -> float:
        """How long before or after a jump of one of them a time is; inf if it never jumps [s]."""
        if not self.jumps[which]:
            return float("inf")
        into = float(np.mod(time_s, self.periods[which]))
        return min(into, float(self.periods[which]) - into)


def _catmull_rom(points: Floats) -> Floats:
    """Coefficients (n − 1, 4, 2) in powers of 0…1 of the segments through `points` (n, 2).

    Tangents are half the chord between the neighbours; at the two ends half the chord to the one
    neighbour, as in the splines of Gazebo.
    """
    padded = np.vstack([points[:1], points, points[-1:]])
    tangents = (padded[2:] - padded[:-2]) / 2
    p0, p1, m0, m1 = points[:-1], points[1:], tangents[:-1], tangents[1:]
    return np.stack([p0, m0, 3 * (p1 - p0) - 2 * m0 - m1, 2 * (p0 - p1) + m0 + m1], axis=1)
