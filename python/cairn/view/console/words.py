"""What the console tells in words and bars: pieces of HTML, read from snapshots."""

from __future__ import annotations

import math
from html import escape
from typing import Any

from cairn.view.console import shapes
from cairn.view.console.shapes import AMBER, BLUE, GREEN, INK, PALE, RED, TEAL, Colour
from cairn.view.console.snapshot import RobotState, Snapshot

RULES_SHOWN = 6
_CANDIDATES = 3


def css(colour: Colour, alpha: float = 1.0) -> str:
    """A colour for a style sheet."""
    return f"rgba({colour[0]},{colour[1]},{colour[2]},{alpha:.2f})"


def _box(content: str, style: str = "") -> str:
    return (
        f"<div style=\"font:13px/1.45 system-ui,'Segoe UI',sans-serif;color:{css(INK)};"
        f'padding:2px 12px 4px;{style}">{content}</div>'
    )


# ---- the run -------------------------------------------------------------------------------------


def status(snapshot: Snapshot, robot: int) -> str:
    """Mode, its reason in words, and the numbers that matter."""
    state = snapshot.robots[robot]
    decision = state.decision
    name, colour = shapes.mode_of(decision["mode"])
    _, colon, why = decision["sentence"].partition(": ")
    why = why if colon else decision["sentence"]
    why = why[:1].upper() + why[1:]
    twist = decision["twist"]
    to_go = "–" if state.to_go_m is None else f"{state.to_go_m:.1f} m"
    clearance = "–" if math.isinf(state.clearance_m) else f"{state.clearance_m:.2f} m"
    drift = math.dist(state.truth[:2], state.estimate[:2])
    numbers = [
        ("V", f"{twist['linear_mps']:.2f} m/s"),
        ("ω", f"{_degrees(twist['angular_radps'])} °/s"),
        ("to go", to_go),
        ("clearance", clearance),
        ("driven", f"{state.driven_m:.1f} m"),
        ("plans", str(state.plan_count)),
        ("pose off by", f"{100 * drift:.0f} cm"),
        ("contacts", str(state.contacts)),
    ]
    cells = "".join(
        f"<div><div style='font-size:11px;color:{css(PALE)}'>{label}</div>"
        f"<div style='font-weight:600;font-variant-numeric:tabular-nums;"
        f"{_warning(label, state)}'>{escape(value)}</div></div>"
        for label, value in numbers
    )
    return _box(
        f"<div style='display:flex;align-items:center;gap:8px;flex-wrap:wrap'>"
        f"<span style='background:{css(colour)};color:#fff;border-radius:5px;padding:2px 9px;"
        f"font-weight:600;font-size:14px'>{escape(name)}</span>"
        f"<span style='margin-left:auto;color:{css(PALE)};font-variant-numeric:tabular-nums'>"
        f"{escape(clock(snapshot))}</span></div>"
        f"<div style='font-size:14px;min-height:44px;margin:7px 0 6px'>{escape(why)}</div>"
        f"<div style='display:grid;grid-template-columns:repeat(4,1fr);gap:5px 8px'>{cells}</div>"
    )


def _warning(label: str, state: RobotState) -> str:
    touched = label == "contacts" and state.contacts
    near = label == "clearance" and state.clearance_m < 0.05
    return f"color:{css(RED)}" if touched or near else ""


def clock(snapshot: Snapshot) -> str:
    """Simulated time and the pace of it."""
    if snapshot.over is not None:
        return f"{snapshot.time_s:.1f} s, over"
    if snapshot.paused:
        return f"{snapshot.time_s:.1f} s, paused"
    return f"{snapshot.time_s:.1f} s at {snapshot.pace:.1f}×"


def log(snapshot: Snapshot, robot: int) -> str:
    """What happened, newest first: changes of mode, ends of goals, what was refused."""
    state = snapshot.robots[robot]
    rows: list[tuple[float, int, str, Colour]] = []
    for i, change in enumerate(state.told):
        colour = shapes.mode_of(change["to"])[1]
        rows.append((change["time_s"], i, change["sentence"], colour))
    for note in snapshot.notes:
        rows.append((note.time_s, 10_000 + note.number, note.text, RED if note.wrong else GREEN))
    rows.sort(key=lambda row: row[:2], reverse=True)
    lines = "".join(
        f"<div style='display:flex;gap:8px;margin:0 0 5px'>"
        f"<span style='color:{css(PALE)};min-width:48px;text-align:right;"
        f"font-variant-numeric:tabular-nums'>{time_s:.1f} s</span>"
        f"<span style='border-left:3px solid {css(colour)};padding-left:7px'>"
        f"{escape(_sentence(text))}</span></div>"
        for time_s, _, text, colour in rows[:14]
    )
    return _box(lines or _faint("Nothing has happened yet."))


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _faint(text: str) -> str:
    return f"<span style='color:{css(PALE)}'>{escape(text)}</span>"


# ---- why: rules and arcs -------------------------------------------------------------------------


def why(state: RobotState) -> str:
    """The rules that fire, or the arcs that were scored, of the last tick."""
    decision = state.decision
    if decision.get("tracking"):
        return _tracking(decision["tracking"])
    if decision.get("avoidance"):
        return _avoidance(decision["avoidance"])
    return _box(_faint(
        "No rule is asked while the robot stands or plans. Give it a goal: the fuzzy rules light "
        "up while it tracks its path, the scored arcs while it avoids."
    ))  # fmt: skip


def _heading(text: str, more: str = "") -> str:
    return (
        f"<div style='margin:9px 0 3px;font-weight:600'>{escape(text)}"
        f"<span style='font-weight:400;color:{css(PALE)}'> {escape(more)}</span></div>"
    )


def _tracking(tracking: dict[str, Any]) -> str:
    look, tracker = tracking["look_ahead"], tracking["tracker"]
    parts = [
        _heading("Bend ahead", f"C = {tracking['C']:.2f} of 5, from the next three waypoints"),
        _table_of_bends(look),
    ]
    outputs = tracker["outputs"]
    for output, unit in (("V", "m/s"), ("omega", "rad/s")):
        name = "ω" if output == "omega" else output
        parts.append(_heading(f"Rules for {name}", f"→ {outputs[output]:.2f} {unit}"))
        parts.append(_rules(tracker["rules"], output))
    parts.append(_heading("What they see"))
    inputs = {
        "C": f"{tracking['C']:.2f}",
        "dR": f"{tracking['dR']:.2f} m",
        "dtheta": f"{_degrees(tracking['dtheta'])}°",
        "Vc": f"{tracking['Vc']:.2f} m/s",
    }
    for name, sets in tracker["memberships"].items():
        parts.append(_sets(name, inputs.get(name, ""), sets))
    return _box("".join(parts))


def _table_of_bends(look: dict[str, Any]) -> str:
    """Table 1 of the paper, lit by the strengths of its rules [Maalouf06 Table 1]."""
    columns = sorted(look["memberships"].get("alpha1", {}), key=_severity)
    rows = sorted(look["memberships"].get("alpha2", {}), key=_severity)
    strengths = look["rules"]

    def cell(row: str, column: str) -> str:
        found = [
            (strength, rule.rpartition(" ")[2])
            for rule, strength in strengths.items()
            if f"alpha1 {column} " in rule and f"alpha2 {row} " in rule
        ]
        strength, answer = found[0] if found else (0.0, "")
        lit = css(TEAL, 0.10 + 0.9 * strength) if strength > 0 else css(PALE, 0.12)
        ink = "#fff" if strength > 0.45 else css(INK)
        return (
            f"<td style='background:{lit};color:{ink};padding:2px 5px;border-radius:3px;"
            f"text-align:center;height:19px'>{escape(answer)}</td>"
        )

    head = "".join(
        f"<th style='font-weight:400;color:{css(PALE)}'>{escape(c)}</th>" for c in columns
    )
    body = "".join(
        f"<tr><td style='color:{css(PALE)}'>{escape(row)}</td>"
        + "".join(cell(row, column) for column in columns)
        + "</tr>"
        for row in rows
    )
    return (
        "<table style='border-spacing:3px;width:100%;font-size:11.5px;table-layout:fixed'>"
        f"<tr><th></th>{head}</tr>{body}</table>"
    )


def _severity(name: str) -> tuple[int, str]:
    for rank, word in enumerate(("Straight", "VeryHigh", "High")):
        if name.startswith(word):
            return ((0, 2, 1)[rank], name)
    return (3, name)


def _rules(rules: dict[str, float], output: str) -> str:
    mine = [(rule, s) for rule, s in rules.items() if f" then {output} " in rule and s > 0.005]
    mine.sort(key=lambda pair: -pair[1])
    rows = [_rule(rule, strength) for rule, strength in mine[:RULES_SHOWN]]
    more = len(mine) - RULES_SHOWN
    if more > 0:
        rows.append(_faint(f"and {more} weaker"))
    return "".join(rows)


def _rule(rule: str, strength: float) -> str:
    text = rule.removeprefix("if ").replace("dtheta", "dθ").replace("omega", "ω")
    condition, _, answer = text.partition(" then ")
    lit, percent = css(TEAL, 0.20 + 0.45 * strength), round(100 * strength)
    return (
        f"<div style='position:relative;margin:2px 0;padding:1px 6px;border-radius:3px;"
        f"background:linear-gradient(90deg,{lit} {percent}%,{css(PALE, 0.10)} {percent}%);"
        f"display:flex;gap:6px;font-size:12px'>"
        f"<span>{escape(condition.replace(' and ', ' · '))}</span>"
        f"<span style='margin-left:auto;font-weight:600;white-space:nowrap'>{escape(answer)}</span>"
        f"<span style='color:{css(INK, 0.65)};min-width:30px;text-align:right'>"
        f"{percent} %</span></div>"
    )


def _sets(name: str, value: str, sets: dict[str, float]) -> str:
    lit = [(label, s) for label, s in sets.items() if s > 0.005]
    lit.sort(key=lambda pair: -pair[1])
    chips = "".join(
        f"<span style='background:{css(BLUE, 0.12 + 0.6 * s)};border-radius:3px;padding:0 5px;"
        f"margin-right:4px;color:{'#fff' if s > 0.6 else css(INK)}'>{escape(label)} {s:.2f}</span>"
        for label, s in lit
    )
    label = name.replace("dtheta", "dθ")
    return (
        f"<div style='display:flex;gap:6px;margin:2px 0;font-size:12px'>"
        f"<span style='min-width:22px;font-weight:600'>{escape(label)}</span>"
        f"<span style='min-width:58px;font-variant-numeric:tabular-nums'>{escape(value)}</span>"
        f"<span>{chips}</span></div>"
    )


def _avoidance(avoidance: dict[str, Any]) -> str:
    window = avoidance["window"]
    reason = avoidance["why"]
    kind = reason["kind"].replace("_", " ")
    inner = reason.get("reason")
    if isinstance(inner, dict) and "kind" in inner:
        kind += f": {inner['kind'].replace('_', ' ')}"
    intervals = avoidance["intervals"]
    low, high = (_degrees(window[f"angular_{end}_radps"]) for end in ("lo", "hi"))
    speeds = f"{window['linear_lo_mps']:.2f} to {window['linear_hi_mps']:.2f}"
    reach = f"V {speeds} m/s, ω {low} to {high} °/s"
    goal = f"{_degrees(avoidance['goal_bearing_rad'])}° off"
    parts = [
        _heading("Chosen", kind),
        _line("within reach", reach),
        _line("goal", goal + _metres(avoidance["goal_distance_m"])),
    ]  # fmt: skip
    guided = avoidance.get("guided")
    if guided:
        count = guided["moving"]
        moving = f", {count} thing{'s' * (count > 1)} moving" if count else ""
        tight = ", tight" if guided["tight"] else ""
        parts.append(_line("by the field", f"{guided['to_go_s']:.1f} s to the goal{moving}{tight}"))
    if intervals:
        parts.append(_heading("Free arc by curvature", f"{len(intervals)} intervals"))
        parts.append(_bars(intervals))
    scored = [c for c in avoidance["candidates"] if c.get("total") is not None]
    open_ones = [c for c in scored if c["refused"] is None]
    best = sorted(open_ones or scored, key=lambda c: -c["total"])[:_CANDIDATES]
    if best:
        shut = len(scored) - len(open_ones)
        parts.append(_heading("Best candidates", f"of {len(scored)}, {shut} refused"))
        weights = None if guided else avoidance["weights"]
        parts += [_candidate(each, weights) for each in best]
        parts.append(_key_of_terms() if weights else _faint("seconds to the goal"))
    return _box("".join(parts))


def _degrees(angle_rad: float) -> str:
    """Whole degrees with their sign, `+12`, `−3`; nothing has no sign."""
    whole = round(math.degrees(angle_rad))
    return f"{whole:+d}".replace("-", "−") if whole else "0"


def _metres(distance: float | None) -> str:
    return "" if distance is None or not math.isfinite(distance) else f", {distance:.1f} m away"


def _line(label: str, value: str) -> str:
    return (
        f"<div style='font-size:12px'><span style='color:{css(PALE)}'>{escape(label)}</span> "
        f"{escape(value)}</div>"
    )


def _bars(intervals: list[dict[str, float]]) -> str:
    """One bar for each interval, leftmost the sharpest right turn; height: free arc length."""
    finite = [i for i in intervals if i["distance_m"] is not None]
    if not finite:
        return ""
    low = min(i["curvature_lo"] for i in finite)
    high = max(i["curvature_hi"] for i in finite)
    top = max(max(i["distance_m"] for i in finite), 1e-6)
    pieces = []
    for each in finite:
        x = 100 * (each["curvature_lo"] - low) / max(high - low, 1e-9)
        width = 100 * (each["curvature_hi"] - each["curvature_lo"]) / max(high - low, 1e-9)
        height = 46 * min(each["distance_m"] / top, 1.0)
        colour = (RED, AMBER, GREEN)[sum(each["distance_m"] > limit for limit in shapes.NEAR_M)]
        pieces.append(
            f"<rect x='{x:.2f}' y='{48 - height:.1f}' width='{max(width, 0.3):.2f}' "
            f"height='{height:.1f}' fill='{css(colour)}'/>"
        )
    return (
        "<svg viewBox='0 0 100 48' preserveAspectRatio='none' "
        f"style='width:100%;height:56px;background:{css(PALE, 0.10)}'>{''.join(pieces)}</svg>"
        f"<div style='display:flex;font-size:11px;color:{css(PALE)}'><span>{low:+.1f} 1/m, right"
        f"</span><span style='margin:auto'>{top:.1f} m high</span>"
        f"<span>left, {high:+.1f} 1/m</span></div>"
    )


_TERMS = (("speed", BLUE), ("distance", GREEN), ("heading", AMBER))


def _candidate(candidate: dict[str, Any], weights: dict[str, float] | None) -> str:
    """One motion with its score: bars of what each term adds, or, by a field, seconds."""
    twist = candidate["twist"]
    score = f"{-candidate['total']:.1f} s" if weights is None else f"{candidate['total']:.2f}"
    terms = "".join(
        f"<span style='display:inline-block;height:9px;"
        f"width:{100 * max(weights[name] * candidate[name], 0):.0f}px;"
        f"background:{css(colour)}'></span>"
        for name, colour in (_TERMS if weights else ())
        if weights and candidate.get(name) is not None
    )
    refused = _faint(candidate["refused"].replace("_", " ")) if candidate["refused"] else ""
    speeds = f"{twist['linear_mps']:.2f} m/s {_degrees(twist['angular_radps'])} °/s"
    bars = f"<span style='min-width:104px'>{terms}</span>" if weights else ""
    return (
        "<div style='display:flex;gap:7px;font-size:12px;align-items:center;margin:2px 0'>"
        f"<span style='min-width:116px;font-variant-numeric:tabular-nums'>{speeds}</span>"
        f"{bars}<b>{score}</b>{refused}</div>"
    )


def _key_of_terms() -> str:
    return "<div style='font-size:11px'>" + "".join(
        f"<span style='color:{css(colour)};margin-right:10px'>■ {name}</span>"
        for name, colour in _TERMS
    ) + "</div>"  # fmt: skip


# ---- the legend ----------------------------------------------------------------------------------


def legend() -> str:
    """What the colours of the map mean."""
    more = f"<i style='color:{css(PALE)}'>robot and way driven</i>"
    rows = [
        *[(_patch(colour), f"{name} {more}") for name, colour in shapes.MODES.values()],
        (_frame(INK), "where the robot believes it is"),
        (_stroke(BLUE), "plan"),
        (_dot(RED), "waypoints looked at"),
        (_ring(RED), "goal"),
        (_patch((226, 160, 63), 0.45), "sonar heard something"),
        (_patch((120, 170, 214), 0.3), "sonar heard nothing"),
        (_stroke(AMBER), "lidar saw something"),
        (_patch(RED, 0.5) + _patch(AMBER, 0.5) + _patch(GREEN, 0.5),
         "arc free to 0.5 m, 1.5 m, further"),
        (_gradient(), "cost to go: at the goal … far"),
        (_patch(AMBER), "box no map shows"),
        (_patch(shapes.OCCUPIED) + _patch(shapes.FREE) + _patch(shapes.UNKNOWN),
         "occupied, free, unknown"),
    ]  # fmt: skip
    lines = "".join(
        f"<div style='display:flex;align-items:center;gap:8px;margin:2px 0'>"
        f"<span style='min-width:54px;display:flex;gap:3px'>{mark}</span><span>{text}</span></div>"
        for mark, text in rows
    )
    return _box(f"<div style='font-size:12px'>{lines}</div>")


def _patch(colour: Colour, alpha: float = 1.0) -> str:
    return (
        f"<span style='width:15px;height:12px;background:{css(colour, alpha)};"
        f"border:1px solid {css(PALE, 0.4)}'></span>"
    )


def _frame(colour: Colour) -> str:
    return f"<span style='width:18px;height:11px;border:2px solid {css(colour)}'></span>"


def _stroke(colour: Colour) -> str:
    return f"<span style='width:34px;height:0;border-top:3px solid {css(colour)}'></span>"


def _dot(colour: Colour) -> str:
    return f"<span style='width:8px;height:8px;background:{css(colour)}'></span>"


def _ring(colour: Colour) -> str:
    return (
        f"<span style='width:12px;height:12px;border:2.5px solid {css(colour)};"
        "border-radius:50%'></span>"
    )


def _gradient() -> str:
    return (
        "<span style='width:48px;height:12px;"
        "background:linear-gradient(90deg,rgb(23,64,116),rgb(47,141,165),rgb(168,206,165))'></span>"
    )


def hint(text: str) -> str:
    """A line that says what to do."""
    return _box(f"<div style='font-size:12px;color:{css(INK, 0.75)}'>{escape(text)}</div>")
