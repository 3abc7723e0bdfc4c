"""Traps in a run: where the robot could not go on as it did, and how long until it was out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cairn.strict_json import plain

if TYPE_CHECKING:
    from cairn.missions.result import Recovered

CAUSES = frozenset(
    {"circling", "dead_end", "no_gain", "no_free_waypoint", "wedged",
     "wheels_spin", "turn_held", "wheels_held"}
)  # fmt: skip
LEFT_M = 0.5
"""A trap is left once the robot is this far from where it noticed it."""


@dataclass(frozen=True)
class Trap:
    """One trap: since when the robot gained nothing, why, and how long it was in it [s]."""

    time_s: float
    cause: str
    seconds: float
    left: bool  # False: the run ended in it

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return plain(
            {"time_s": self.time_s, "cause": self.cause, "seconds": self.seconds,
             "left": self.left}, decimals=6,
        )  # fmt: skip


def traps(
    recoveries: Sequence[Recovered],
    time_s: Sequence[float],
    truth: Sequence[tuple[float, float, float]],
) -> list[Trap]:
    """Return the traps of a run, oldest first.

    A trap begins with the time without gain that its cause tells (`seconds`), or when it was
    noticed, and ends `LEFT_M` from there, by truth; causes noticed meanwhile are the same trap.

    Args:
        recoveries: what went wrong, in order.
        time_s: of every tick, rising.
        truth: true pose at every tick, (x, y, heading) [m, m, rad].
    """
    found: list[Trap] = []
    until_s = -math.inf
    for recovered in recoveries:
        shut_off = recovered.cause == "way_shut" and recovered.remedy == "plan_anew"
        is_trap = recovered.cause in CAUSES or shut_off
        if not is_trap or recovered.time_s < until_s:
            continue
        begin = next(i for i, t in enumerate(time_s) if t >= recovered.time_s)
        at = truth[begin][:2]
        out = (i for i in range(begin, len(truth)) if math.dist(truth[i][:2], at) >= LEFT_M)
        end = next(out, None)
        until_s = math.inf if end is None else time_s[end]
        since_s = max(recovered.time_s - float(recovered.detail.get("seconds", 0.0)), 0.0)
        last_s = time_s[-1] if end is None else until_s
        found.append(Trap(since_s, recovered.cause, last_s - since_s, end is not None))
    return found
