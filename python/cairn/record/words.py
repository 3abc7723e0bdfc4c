"""The words for every code of the decision record. They live here and nowhere else in the body.

The brain words the one sentence that goes with a decision (`sentence`); whatever more is told of a
tick or of a run is put together from these, by `cairn.record.tick_story` and `run_story`.
"""

from __future__ import annotations

import math
import re
from typing import Any

MODES = {
    "stop": "Stop",
    "path_planning": "Path planning",
    "path_tracking": "Path tracking",
    "obstacle_avoidance": "Obstacle avoidance",
}

# What held a command of the tracker back, `tracking.caps`.
CAPS = {
    "no_path": "there is no path to follow",
    "arrived": "it stands at the goal",
    "at_goal": "so near to the goal its bearing says nothing: straight on",
    "braking_distance": "no faster than it can still stop at the goal",
    "joining_path": "slow enough to turn into the path that it meets at an angle",
    "bend_ahead": "slow enough for a sharp bend within the braking distance",
    "no_reversing": "the tracker never drives backwards",
    "cruise_speed": "no faster than was asked for",
    "linear_speed": "at the robot's greatest speed",
    "angular_speed": "at the robot's greatest turn rate",
    "linear_acceleration": "no more change of speed than one tick can reach",
    "angular_acceleration": "no more change of turn rate than one tick can reach",
    "measurement_not_finite": "a measurement was not a number: stop",
}

# Why the curvature velocity method brakes, `avoidance.why.reason.kind`.
BRAKES = {
    "stops_to_turn": "no arc ahead is free; it must stand before it turns on the spot",
    "ends_turn": "the turn has found a free arc; it must slow its rotation to drive it",
    "too_fast": "every motion within reach is too fast to stop before what lies on its arc",
    "no_room_to_turn": "no arc ahead is free and there is no room to turn",
    "nothing_free": "no arc ahead is free and no heading is better than the present one",
    "cannot_gain_clearance": "something is within the margin and no motion gets away from it",
    "at_goal": "the goal is under the robot",
    "input_refused": "an input was not usable",
}

# Why a candidate was not driven, `avoidance.candidates[].refused`.
REFUSED = {
    "too_short": "its arc is free for too short a way; turning is better",
    "stopping_meets_obstacle": "stopping after it would meet an obstacle",
}

# What is done about a cause, `recovery.remedy`.
REMEDIES = {
    "walk_anew": "the repaired field is walked anew from where it is, with no stop and no plan",
    "plan_anew": "it stops and plans on the map as it is now",
    "manoeuvre": "it drives a manoeuvre found by a search over place and heading",
    "back_off": "what holds it goes on the map, and it backs off",
    "wait_then_plan": "it stops, waits for the motors, and plans then",
}

# Why a goal is refused, `status.refusal.code`: what it means, and what would help.
REFUSALS = {
    "goal_outside_map": (
        "the goal lies beyond the map",
        "give a goal on the map, or a map that reaches so far",
    ),
    "goal_blocked": (
        "something stands on the goal, or too near to it for the robot to stand there",
        "give a goal with more room, or correct the map if nothing stands there",
    ),
    "start_outside_map": (
        "the robot is outside the map",
        "start it on the map, or tell it where it really is",
    ),
    "start_blocked": (
        "by the map the robot stands inside an obstacle, with nothing free near enough",
        "tell it where it really is, or correct the map there",
    ),
    "no_path": (
        "nothing joins the robot's part of the map to the goal's",
        "open a way, or correct the map; a passage narrower than the robot counts as shut",
    ),
    "no_progress": (
        "it planned again and again and came no nearer",
        "see what it met on the way: something there is not on its map, or holds it",
    ),
    "nothing_left_to_explore": (
        "nothing unknown is left that it can reach",
        "nothing: exploring is done",
    ),
}

# How it stands with a task, `status.code`.
STATUS = {
    "idle": "nothing has been asked for yet",
    "driving": "under way",
    "reached": "the goal is reached",
    "refused": "it cannot be done",
    "cancelled": "called off by the user",
}

# Whether the pose on the map is known, `localisation.state`.
STATES = {
    "searching": "it does not know where on the map it is, and looks around",
    "tracking": "its place on the map is known",
}

# What went wrong, `recovery.cause.code`, with its numbers.
CAUSES = {
    "off_path": "it is {off_m:.1f} m off its path",
    "way_shut": "the way is shut {ahead_m:.1f} m ahead",
    "cheaper_way": "a way opened that is cheaper by {gain:.1f}",
    "no_free_waypoint": "no waypoint that remains is free",
    "circling": "it was near ({at[x]:.2f}, {at[y]:.2f}) m before: it goes in circles",
    "dead_end": "straight on is a dead end: the way round is {detour_m:.1f} m longer",
    "no_gain": "it has come no nearer for {seconds:.1f} s",
    "wheels_spin": "its wheels turned {spun_m:.2f} m and nothing around came nearer",
    "turn_held": "its wheels turned it {turned_rad:.1f} rad and the gyroscope saw none of it",
    "wedged": "it has hardly moved for {seconds:.1f} s: too tight to go on as it stands",
    "wheels_held": "its wheels have stood for {seconds:.1f} s although told to turn",
    "motors_silent": "its wheels have stood for {seconds:.1f} s whatever they were told",
}

# Inputs of the fuzzy systems. A name that no table has is told as it is.
INPUTS = {
    "C": "bend ahead",
    "dR": "next waypoint",
    "dtheta": "bearing",
    "Vc": "speed",
    "alpha1": "next turn",
    "alpha2": "turn after it",
}

_RULE = re.compile(r"^if (?P<when>.+) then (?P<then>.+)$")


def rule(sentence: str) -> str:
    """A fuzzy rule as a person says it; one that is not of the usual form stays as it is."""
    match = _RULE.match(sentence)
    if match is None:
        return sentence
    when, then = (
        [pair.split(" ", 1) for pair in match[part].split(" and ")] for part in ("when", "then")
    )
    if not all(len(pair) == 2 for pair in [*when, *then]):
        return sentence
    conditions = ", ".join(f"{INPUTS.get(name, name)} {_set(label)}" for name, label in when)
    return f"{conditions} → {', '.join(_asked(name, value) for name, value in then)}"


def _asked(output: str, value: str) -> str:
    """What a rule asks for: a number of V or ω, or a named one."""
    try:
        number = float(value)
    except ValueError:
        return f"{INPUTS.get(output, output)} {_set(value)}"
    if output == "V":
        return f"drive at {number:.2f} m/s" if number else "do not drive"
    if output == "omega":
        return f"turn {side(number)} at {degrees(number)}/s" if number else "do not turn"
    return f"{INPUTS.get(output, output)} {value}"


def _set(label: str) -> str:
    """`SlightLeft` as `slight left`; the digit that tells twins apart, and the paper's c, go."""
    words = re.findall(r"[A-Z][a-z]*|[a-z]+|[-\d.]+", re.sub(r"(?<=[a-z])[12]$", "", label))
    return " ".join(word.lower() for word in words if word != "c") or label


def side(angle: float) -> str:
    """`left` or `right` of an angle or turn rate, left positive."""
    return "left" if angle >= 0 else "right"


def degrees(angle_rad: float) -> str:
    """An angle without its sign, in degrees: fine ones with a decimal."""
    value = abs(math.degrees(angle_rad))
    return f"{value:.1f}°" if value < 10 else f"{value:.0f}°"


def motion(linear_mps: float, angular_radps: float) -> str:
    """A command in words."""
    turns = abs(angular_radps) >= math.radians(0.5)
    turning = f"{side(angular_radps)} at {degrees(angular_radps)}/s"
    if abs(linear_mps) < 0.005:
        return f"turns on the spot, {turning}" if turns else "stands still"
    drives = f"drives {'ahead' if linear_mps > 0 else 'back'} at {abs(linear_mps):.2f} m/s"
    return f"{drives}, turning {turning}" if turns else f"{drives}, straight"


def arc(curvature_per_m: float) -> str:
    """An arc in words."""
    if abs(curvature_per_m) < 0.05:
        return "straight on"
    return f"to the {side(curvature_per_m)} on a radius of {1 / abs(curvature_per_m):.2f} m"


def cause(of: dict[str, Any]) -> str:
    """What went wrong, with its numbers; `recovery.cause`."""
    told = CAUSES[of["code"]].format(**of) if of["code"] in CAUSES else legible(of["code"])
    detour = of.get("detour")
    if detour is None:
        return told
    return told + (
        f", another one costs {detour:.1f} more"
        if math.isfinite(detour)
        else ", and no other leads on"
    )


def counted(number: int, what: str) -> str:
    """`1 rule`, `2 rules`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def heading(angle_rad: float) -> str:
    """A heading in whole degrees, without a sign to its zero."""
    return f"{round(math.degrees(angle_rad)) + 0}°"


def legible(code: str) -> str:
    """A code that no table words."""
    return code.replace("_", " ")
