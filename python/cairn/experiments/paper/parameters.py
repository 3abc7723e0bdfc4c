"""The parameters of the fuzzy controller in one posture, after Fig. 5 [Maalouf06 §4]."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

import cairn

PATH = ((0.0, 0.7), (0.9, 0.05), (1.75, 0.4), (2.2, 1.2), (3.2, 1.35), (4.05, 1.1))  # [m]
POSE = (0.75, -0.3, 0.8)  # of the robot: x, y [m], heading [rad]
TWIST = (0.35, 0.1)


def measure() -> dict[str, Any]:
    """Let the tracker take one step beside a bend.

    Returns:
        `waypoints` (n, 2), `pose` and `ahead` (where the robot will be when the command takes
        hold), `index` of N_i, what the tracker says of dR, dθ, α₁, α₂, C and its command, and
        `by_hand`: the same distance and angles worked out anew from the points.
    """
    tracker = cairn.Tracker("p3at", cairn.Profile.load("p3at"))
    tracker.follow(PATH, spacing_m=None)
    for x, y in (PATH[0], POSE[:2]):
        tracker.advance_pointer((x, y))
    told = tracker.step(POSE, TWIST, 0.1)
    waypoints = np.asarray(tracker.waypoints)
    ahead = [told["world_from_robot_ahead"][key] for key in ("x", "y", "heading")]
    index = told["waypoint_index"]
    points = waypoints[index : index + 4]
    legs = np.diff(points, axis=0)
    bearings = np.arctan2(legs[:, 1], legs[:, 0])
    turns = [abs(_wrapped(b - a)) for a, b in itertools.pairwise(bearings)]
    to_next = points[1] - ahead[:2]
    by_hand = {
        "dR": float(np.hypot(*to_next)),
        "dtheta": _wrapped(math.atan2(to_next[1], to_next[0]) - ahead[2]),
        "alpha1": turns[0],
        "alpha2": turns[1],
    }
    parameters = {key: float(told[key]) for key in (*by_hand, "C", "Vc")}
    most_off = max(abs(parameters[key] - value) for key, value in by_hand.items())
    return {
        "summary": {**parameters, "most_off_by_hand": most_off, "twist": dict(told["twist"])},
        "waypoints": waypoints,
        "pose": list(POSE),
        "ahead": ahead,
        "index": index,
        "by_hand": by_hand,
    }


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
