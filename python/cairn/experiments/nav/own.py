"""Our own stack: the whole navigator, with the lidar or the sonars of its profile and no map."""

from __future__ import annotations

from typing import Any

import numpy as np

from cairn.experiments.nav.stacks import Observation, Task
from cairn.navigator import Navigator


class CairnStack:
    """A navigator behind the benchmark's callable."""

    def __init__(self, task: Task) -> None:
        self._navigator = Navigator(task.profile, None, start=(0.0, 0.0, 0.0))
        self._navigator.set_goal(task.goal)
        self._period_s = task.period_s

    def __call__(self, seen: Observation) -> Any:
        """One tick of the navigator."""
        decision = self._navigator.step(
            seen.ranges_m, seen.wheels_m, seen.gyro_radps, seen.dt_s or self._period_s
        )
        return decision.twist

    @property
    def path(self) -> np.ndarray | None:
        """What it wanted to drive last."""
        return self._navigator.path

    def notes(self) -> dict[str, Any]:
        """How often it planned."""
        return {"plans": self._navigator.plan_count, "mode": self._navigator.mode}


def cairn_stack(task: Task) -> CairnStack:
    """Make the `cairn` stack."""
    return CairnStack(task)
