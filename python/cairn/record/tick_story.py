"""One tick told in sentences, read from its record: nothing is computed again."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from cairn.record import words

RULES = 4  # told of each fuzzy module, strongest first
WEAK = 0.01  # rules that fire less than this are not told
CANDIDATES = 3


class Paragraph(NamedTuple):
    """Sentences under a heading."""

    heading: str
    sentences: list[str]


def tell_tick(tick: dict[str, Any]) -> list[Paragraph]:
    """Tell a tick of `Run.ticks`: mode and why, how the command came about, what comes next."""
    decision = tick["decision"]
    told = [
        Paragraph("Mode", _mode(decision)),
        Paragraph("Command", _command(decision)),
        Paragraph("Fuzzy rules", _tracking(decision)),
        Paragraph("Arcs", _avoidance(decision)),
        Paragraph("Seen", _seen(tick)),
        Paragraph("Where it is", _place(tick)),
        Paragraph("Limits", _limits(decision)),
        Paragraph("What comes next", _next(decision)),
    ]
    return [paragraph for paragraph in told if paragraph.sentences]


def _mode(decision: dict[str, Any]) -> list[str]:
    told = [decision["sentence"]]
    if decision["mode_before"] != decision["mode"]:
        before, now = (words.MODES[decision[key]] for key in ("mode_before", "mode"))
        told.append(f"In this tick the mode changed from {before.lower()} to {now.lower()}.")
    plan = decision["plan"]
    if plan and plan["refusal"] is None:
        told.append(_plan(plan))
    refusal = decision["status"].get("refusal") or (plan or {}).get("refusal")
    if refusal:
        told += refused(refusal)
    recovery = decision["recovery"]
    if recovery:
        told.append(f"What went wrong: {words.cause(recovery['cause'])}.")
        told.append(f"What is done about it: {words.REMEDIES[recovery['remedy']]}.")
    return told


def _plan(plan: dict[str, Any]) -> str:
    if plan["shared"]:
        made = "The field was given with the goal"
    else:
        made = f"Plan {plan['plan_count']} was made in this tick"
    if plan["path_length_m"] is not None:
        made += f": {plan['path_length_m']:.1f} m over {plan['waypoints']} waypoints"
    if plan["doubted"]:
        made += "; only after what was seen from afar had been forgotten"
    return made + "."


def refused(refusal: dict[str, Any]) -> list[str]:
    """Tell a refusal: its code, what it means and what would help."""
    code = refusal["code"]
    means, helps = words.REFUSALS.get(code, (words.legible(code), ""))
    numbers = ", ".join(
        f"{words.legible(key.removesuffix('_m'))} {value:.2f} m"
        if key.endswith("_m")
        else f"{words.legible(key)} {value}"
        for key, value in refusal.items()
        if key != "code" and value is not None
    )
    told = [f"Refused with the code `{code}`: {means}{f' ({numbers})' if numbers else ''}."]
    return told + ([f"What would help: {helps}."] if helps else [])


def _command(decision: dict[str, Any]) -> list[str]:
    twist = decision["twist"]
    told = [f"It {words.motion(twist['linear_mps'], twist['angular_radps'])}."]
    tracking, avoidance = decision["tracking"], decision["avoidance"]
    if tracking and avoidance:
        wanted = tracking["twist"]
        wants = words.motion(wanted["linear_mps"], wanted["angular_radps"])
        told.append(
            f"The tracker's command ({wants}) could not have been stopped from in time: the"
            " curvature velocity method took over."
        )
    backing = decision.get("backing")
    if backing:
        told.append(
            f"It backs off from what holds it: {backing['moved_m']:.2f} m of"
            f" {backing['back_off_m']:.2f} m are done."
        )
    elif decision["mode"] in ("stop", "path_planning") and any(twist.values()):
        told.append("It brakes along its present curve.")
    caution = decision["caution"]
    if caution:
        told.append(
            f"It was slowed to {caution['speed_mps']:.2f} m/s, because ahead it has seen only"
            f" {caution['sight_m']:.2f} m of ground."
        )
    return told


def _tracking(decision: dict[str, Any]) -> list[str]:
    seen = decision["tracking"]
    if not seen:
        return []
    if seen["target"] is None:
        return ["There is no path to follow."]
    bend = "straight" if seen["C"] < 0.05 else f"bend of {seen['C']:.1f} out of 5"
    told = [
        f"Past waypoint {seen['waypoint_index'] + 1} it heads for {_point(seen['target'])},"
        f" {seen['dR']:.2f} m away, {_bearing(seen['dtheta'])};"
        f" the speed is {abs(seen['Vc']):.2f} m/s.",
        f"The path ahead: {bend} (it turns by {words.degrees(seen['alpha1'])}, then by"
        f" {words.degrees(seen['alpha2'])}); {seen['remaining_m']:.1f} m to the goal along it.",
    ]
    if seen["look_ahead"] and seen["C"] >= 0.05:
        told += _rules(seen["look_ahead"]["rules"], "What the rules make of the bend")
    if seen["tracker"]:
        told += _rules(seen["tracker"]["rules"], "What the rules say of speed and turn")
    raw, sent = seen["raw"], seen["twist"]
    asks = words.motion(raw["linear_mps"], raw["angular_radps"])
    told.append(
        f"Together the rules say: {asks.replace('drives', 'drive').replace('turns', 'turn')}."
    )
    caps = [words.CAPS.get(cap, words.legible(cap)) for cap in seen["caps"]]
    if caps:
        left = words.motion(sent["linear_mps"], sent["angular_radps"])
        told.append(f"Held back ({'; '.join(caps)}): it {left}.")
    return told


def _rules(strengths: dict[str, float], about: str) -> list[str]:
    """The strongest rules, first those that say most."""
    fired = sorted(strengths.items(), key=lambda item: -item[1])
    strong = [(rule, strength) for rule, strength in fired if strength >= WEAK]
    rest = len(strong) - RULES
    return [
        f"{about}, strongest first:",
        *(f"  {strength:.2f}  {words.rule(rule)}" for rule, strength in strong[:RULES]),
        *([f"  and {words.counted(rest, 'weaker rule')}."] if rest > 0 else []),
    ]


def _avoidance(decision: dict[str, Any]) -> list[str]:
    seen = decision["avoidance"]
    if not seen:
        return []
    goal = f"It wants to go {_bearing(seen['goal_bearing_rad'])}"
    if seen["clearance_m"] is not None and math.isfinite(seen["clearance_m"]):
        goal += f"; the nearest thing is {seen['clearance_m']:.2f} m from its outline"
    told = [goal + "."]
    intervals = seen["intervals"]
    if intervals:
        free = max(intervals, key=lambda each: each["distance_m"])
        told.append(
            f"{words.counted(len(intervals), 'interval')} of curvature; the freest,"
            f" {words.arc(_middle(free))}, runs {free['distance_m']:.2f} m clear."
        )
    told += _why(seen)
    chosen = seen["chosen"]
    ranked = sorted(
        range(len(seen["candidates"])), key=lambda i: (i != chosen, -seen["candidates"][i]["total"])
    )
    for place, number in enumerate(ranked[:CANDIDATES]):
        told.append(
            _candidate(seen, number, "Chosen" if number == chosen else f"Also weighed {place}")
        )
    return told


def _candidate(seen: dict[str, Any], number: int, called: str) -> str:
    one = seen["candidates"][number]
    interval = seen["intervals"][one["interval"]]
    twist = one["twist"]
    told = (
        f"{called}: {words.motion(twist['linear_mps'], twist['angular_radps'])}"
        f" ({words.arc(_middle(interval))}, {interval['distance_m']:.2f} m clear)"
    )
    if seen["guided"]:
        told += f", {-one['total']:.1f} s to the goal by the field"
    else:
        weights = seen.get("weights") or {}
        terms = " + ".join(
            (f"{weights[name]:g} × " if name in weights else "") + f"{one[name]:.2f} {name}"
            for name in ("speed", "distance", "heading")
        )
        told += f", scored {one['total']:.3f} = {terms}"
    if one["refused"]:
        told += f"; not driven: {words.REFUSED.get(one['refused'], words.legible(one['refused']))}"
    return told + "."


def _why(seen: dict[str, Any]) -> list[str]:
    why, guided = seen["why"], seen["guided"]
    told = []
    match why["kind"]:
        case "best_arc":
            told.append("It takes the best-scored motion along a free arc.")
        case "turning_in_place":
            told.append(
                f"No arc ahead will do: it turns on the spot to the {why['direction']}, to a"
                f" heading {words.degrees(why['to_heading_rad'])} from the present one."
            )
        case "leaving_obstacle":
            told.append(
                f"Something is within the margin ({why['clearance_m']:.2f} m): it moves so as to"
                " gain clearance."
            )
        case "giving_way":
            touch = why["touches_s"]
            ends = f"; it would still be touched in {touch:.1f} s" if touch is not None else ""
            told.append(
                f"It gives way to {why['things']} moving things, coming no nearer than"
                f" {why['nearest_m']:.2f} m{ends}."
            )
        case "backing_out":
            told.append(
                f"No arc ahead is free and there is no room to turn: it runs back"
                f" {why['to_room_m']:.2f} m to where there is."
            )
        case "braking":
            reason = why["reason"]
            detail = f" ({reason['message']})" if "message" in reason else ""
            told.append(f"It brakes: {words.BRAKES[reason['kind']]}{detail}.")
    if guided:
        told.append(f"By the field it is {guided['to_go_s']:.1f} s to the goal from here.")
        if guided["tight"]:
            told.append("It is tight: the margin could not be kept, only the touch kept off.")
    return told


def _seen(tick: dict[str, Any]) -> list[str]:
    decision, told = tick["decision"], []
    way = decision["way"]
    if way and way["blocked"]:
        blocked = way["blocked"]
        told.append(
            f"Something the plan did not know, at {_point(blocked['obstacle'])}, stands"
            f" {blocked['distance_m']:.2f} m from the way to waypoint {blocked['waypoint']}; "
            + (
                "no waypoint beyond it is free."
                if way["free_beyond"] is None
                else f"beyond it, waypoint {way['free_beyond']} is free."
            )
        )
    elif way:
        told.append(f"The way is free up to waypoint {way['looked_to']}, as far as it looks.")
    told += _trap(decision["trap"])
    repair = decision["repair"]
    if repair and repair["anew"]:
        told.append("The map changed so much that the field was solved anew.")
    elif repair:
        told.append(
            f"The map changed: {repair['cells']} cells cost something else now, and the field was"
            " repaired."
        )
    lidar = decision["lidar"]
    if lidar:
        told.append(
            f"The lidar: {lidar['matching']['matched']} returns laid on {lidar['points']} points"
            f" kept, {lidar['moving']} things seen to move."
        )
    clearance_m = tick["clearance_m"]
    if clearance_m is not None and math.isfinite(clearance_m):
        told.append(f"By truth, the nearest thing is {clearance_m:.2f} m from its outline.")
    return told


def _trap(trap: dict[str, Any] | None) -> list[str]:
    if not trap:
        return []
    told = []
    if trap["revisited"]:
        told.append(f"It was near {_point(trap['revisited'])} before: it goes in circles.")
    if trap["dead_end"] and trap["detour_m"] is not None:
        told.append(f"Straight on is a dead end: the way round is {trap['detour_m']:.1f} m longer.")
    if trap["stuck"] or trap["without_progress_s"] >= 2.0:
        told.append(f"It has come no nearer for {trap['without_progress_s']:.1f} s.")
    return told


def _place(tick: dict[str, Any]) -> list[str]:
    decision = tick["decision"]
    pose, covariance = decision["pose"], decision["covariance"]
    sigma_m = math.sqrt(max(covariance[0][0] + covariance[1][1], 0.0))
    sigma_rad = math.sqrt(max(covariance[2][2], 0.0))
    told = [
        f"It believes to be at {_point(pose)}, heading {words.heading(pose['heading'])},"
        f" give or take {100 * sigma_m:.0f} cm and {words.degrees(sigma_rad)}."
    ]
    truth = tick["truth"]
    if truth is not None:
        off_m = math.dist(truth[:2], (pose["x"], pose["y"]))
        told.append(f"By truth it is {100 * off_m:.0f} cm from there.")
    found = decision["localisation"]
    if found:
        told.append(
            f"On the map: {words.STATES[found['state']]}; the map explains"
            f" {100 * found['fit']:.0f} % of what it hears."
        )
        if found["jump"]:
            told.append(
                f"Its pose was moved to a place that explains more: by {_point(found['jump'])}."
            )
    matching = decision["matching"]
    if matching and matching["used"]:
        shift_m = math.hypot(matching["correction"]["x"], matching["correction"]["y"])
        told.append(
            f"{matching['used']} echoes agree with the map and moved the pose by"
            f" {100 * shift_m:.1f} cm; {matching['rejected']} do not."
        )
    return told


def _limits(decision: dict[str, Any]) -> list[str]:
    limits = decision["limits"]
    told = (
        f"At most {limits['linear_mps']:.2f} m/s and {words.degrees(limits['angular_radps'])}/s,"
        f" changing by {limits['linear_mps2']:.2f} m/s² and"
        f" {words.degrees(limits['angular_radps2'])}/s²."
    )
    window = decision["avoidance"] and decision["avoidance"]["window"]
    if not window:
        return [told]
    return [
        told,
        f"Within this tick it can reach {window['linear_lo_mps']:.2f} to"
        f" {window['linear_hi_mps']:.2f} m/s and"
        f" {words.heading(window['angular_lo_radps'])}/s to"
        f" {words.heading(window['angular_hi_radps'])}/s.",
    ]


def _next(decision: dict[str, Any]) -> list[str]:
    told = []
    if decision["status"]["code"] != "driving":
        status = decision["status"]["code"]
        return [f"Its task: {words.STATUS[status]}. It waits for the next command."]
    if decision["intermediate"] is not None:
        told.append(
            f"It makes for waypoint {decision['intermediate']}, beyond what is in the way; from"
            " there it follows the path again."
        )
    elif decision["mode"] == "path_tracking" and decision["waypoint_index"] is not None:
        told.append(f"It goes on along the path, past waypoint {decision['waypoint_index'] + 1}.")
    task = decision["task"]
    if task and task["kind"] == "goal":
        left = f"The goal is {_point(task['point'])}"
        if decision["cost_to_go"] is not None and math.isfinite(decision["cost_to_go"]):
            left += f"; the field says {decision['cost_to_go']:.1f} still to pay from here"
        told.append(left + ".")
    elif task:
        told.append("It explores: what is unknown is its goal.")
    return told


def _bearing(angle_rad: float) -> str:
    if abs(angle_rad) < math.radians(1.5):
        return "straight ahead"
    return f"{words.degrees(angle_rad)} to the {words.side(angle_rad)}"


def _point(point: dict[str, float]) -> str:
    return f"({point['x']:.2f}, {point['y']:.2f}) m"


def _middle(interval: dict[str, float]) -> float:
    return (interval["curvature_lo"] + interval["curvature_hi"]) / 2
