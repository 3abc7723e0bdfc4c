"""The state machine of Fig. 11, read off the transition table that the navigator runs on."""

from __future__ import annotations

from typing import Any

from cairn.missions.coverage import NEVER_PERCEIVED
from cairn.navigator import transitions

# The arrows that §6 of the paper tells in words: a mode, the next one, and what for.
TOLD = {
    ("stop", "path_planning"): "a goal is given, the map is there and the position in it known",
    ("stop", "obstacle_avoidance"): "no model of the environment is there",
    ("path_planning", "path_tracking"): "the optimal path is determined",
    ("path_planning", "stop"): "the goal position is unattainable",
    ("path_tracking", "obstacle_avoidance"): "an obstacle lies on one of the next three waypoints",
    ("path_tracking", "stop"): "arrived; the same region twice; a local minimum",
    ("obstacle_avoidance", "path_tracking"): "the intermediate goal is reached, nothing in the way",
    ("obstacle_avoidance", "stop"): "arrived; the same region twice; a local minimum",
}


def measure() -> dict[str, Any]:
    """Group the table's rows by arrow.

    Returns:
        `rows` [(mode, event, next mode, reason)], all of them; `arrows`, one per ordered pair of
        different modes that the table has, with its rows; `stays`, rows that keep it, by mode.
    """
    rows = transitions()
    modes = list(dict.fromkeys(mode for mode, *_ in rows))
    arrows: dict[tuple[str, str], list[dict[str, Any]]] = {}
    stays: dict[str, list[dict[str, Any]]] = {mode: [] for mode in modes}
    for mode, event, after, reason in rows:
        row = {
            "event": event,
            "reason": reason,
            "perceived": (mode, event) not in NEVER_PERCEIVED,
        }
        if after == mode:
            stays[mode].append(row)
        else:
            arrows.setdefault((mode, after), []).append(row)
    return {
        "summary": {
            "modes": len(modes),
            "events": len({event for _, event, _, _ in rows}),
            "rows": len(rows),
            "total": len(rows) == len(modes) * len({event for _, event, _, _ in rows}),
            "changes_of_mode": sum(map(len, arrows.values())),
            "arrows": len(arrows),
            "arrows_as_told": set(arrows) == set(TOLD),
            "planning_only_from_stop": {a for a, b in arrows if b == "path_planning"} == {"stop"},
        },
        "modes": modes,
        "rows": [list(row) for row in rows],
        "arrows": [
            {"from": before, "to": after, "rows": group, "told": TOLD.get((before, after))}
            for (before, after), group in arrows.items()
        ],
        "stays": stays,
    }
