"""The curvature velocity method alone: the last scan and the direction of the goal, no map."""

from __future__ import annotations

import math

from cairn.avoidance import Cvm
from cairn.experiments.nav.points import PointsOfRanges, thinned
from cairn.experiments.nav.stacks import Observation, Task
from cairn.robots.robot import wrap_angle

SEEN_WITHIN_M = 4.0
CELL_M = 0.05


class PureCvm:
    """CVM with its default weights [Simmons96]."""

    def __init__(self, task: Task) -> None:
        self._cvm = Cvm(task.profile)
        self._points = PointsOfRanges(task.profile)
        self._goal, self._period_s = task.goal, task.period_s
        self._pending: tuple[float, float] | None = None

    def __call__(self, seen: Observation) -> tuple[float, float]:
        """One choice."""
        x, y, heading = seen.odometry
        dx, dy = self._goal[0] - x, self._goal[1] - y
        choice = self._cvm.choose(
            seen.twist,
            wrap_angle(math.atan2(dy, dx) - heading),
            math.hypot(dx, dy),
            thinned(self._points(seen.ranges_m, SEEN_WITHIN_M), CELL_M),
            self._period_s,
            pending=self._pending,
        )
        self._pending = choice.twist
        return choice.twist


def cvm(task: Task) -> PureCvm:
    """Make the `cvm` stack."""
    return PureCvm(task)
