"""Which transitions of the strategy a set of runs reached, and where [Maalouf06 Fig. 11]."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from cairn.navigator import transitions

# Rows that the table has because it is total. Perception gives these events in other modes only:
# planning ends with a path or without one, and only planning finds out that a goal is unattainable.
NEVER_PERCEIVED = frozenset(
    {
        ("path_planning", "arrived"),
        ("path_tracking", "goal_unattainable"),
        ("obstacle_avoidance", "goal_unattainable"),
    }
)


class Change(NamedTuple):
    """A transition to another mode."""

    before: str
    event: str
    after: str


def changes_of_mode() -> list[Change]:
    """Return every transition to another mode that runs can reach, in the table's order."""
    return [
        Change(mode, event, after)
        for mode, event, after, _ in transitions()
        if after != mode and (mode, event) not in NEVER_PERCEIVED
    ]


def coverage(
    records: Mapping[str, Iterable[Mapping[str, Any]]],
) -> dict[Change, dict[str, int]]:
    """Count how often each transition was reached in each scenario.

    Args:
        records: of runs, see `Result.to_dict`, by the name of the scenario.

    Returns:
        For every change of mode {scenario: times}, scenarios without it left out; a change that no
        table names (there is none unless the brain is of another version) comes last.
    """
    counts: dict[Change, dict[str, int]] = {change: {} for change in changes_of_mode()}
    for name, runs in records.items():
        for record in runs:
            for robot in record["robots"]:
                for seen in robot["transitions"]:
                    change = Change(seen["from"], seen["event"], seen["to"])
                    places = counts.setdefault(change, {})
                    places[name] = places.get(name, 0) + 1
    return counts
