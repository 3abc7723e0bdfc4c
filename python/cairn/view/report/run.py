"""The report of a run: what came out, where it drove, when and why it changed its mind."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cairn.strict_json import plain
from cairn.view.report import ground, heat, svg
from cairn.view.report.pages import rendered, written
from cairn.view.story import MODES, RobotStory, Story
from cairn.view.style import POSE_BY

NAMES = {
    "path_tracking": "tracking the path",
    "obstacle_avoidance": "avoiding obstacles",
    "path_planning": "planning",
    "stop": "standing",
}


_TRUTH = {
    True: ". Truth is the simulator's; the robot never saw it.",
    False: ". Nobody knew the truth: where the robot was is where it believed to be.",
}


class Fact(NamedTuple):
    """A number at the top of the page."""

    name: str
    value: str
    beside: str = ""
    kind: str = ""


def write_run(story: Story, path: Path) -> Path:
    """Write the report of a run as one HTML file that needs nothing else.

    Args:
        story: of `cairn.missions.retelling`, or of `cairn.view.story.tell`.
        path: the file.

    Returns:
        `path`.
    """
    return written(page_of(story), path)


def page_of(story: Story) -> str:
    """Return the page of a run."""
    end_s = story.duration_s
    seen = {mode for robot in story.robots for mode in robot.mode}
    return rendered(
        "run.html",
        story=story,
        sentence=_sentence(story),
        facts=_facts(story),
        map=ground.drawn(story),
        names=NAMES | {mode: words(mode) for mode in sorted(seen - set(NAMES))},
        modes_seen=seen,
        has_plan=any(robot.plans for robot in story.robots),
        has_belief=story.scenario.get("pose") != "truth",
        has_echoes=any(robot.echoes_m is not None for robot in story.robots),
        no_map=story.known is None and story.world is not None,
        contacts=any(robot.contacts for robot in story.robots),
        robots=[_robot(robot, story, end_s) for robot in story.robots],
        made_from=_made_from(story),
        scenario=json.dumps(plain(story.scenario), indent=2, ensure_ascii=False),
        plain_summary=_plain(story.summary),
        data=_data(story),
        end_s=round(end_s, 3),
        named=lambda mode: NAMES.get(mode, words(mode)),
        words=words,
        seconds=lambda value: f"{value:.1f} s",
        metres=metres,
        percent=lambda share: f"{100 * share:.0f} %",
        point=lambda at: "to explore" if at is None else f"({at[0]:.2f}, {at[1]:.2f}) m",
    )


def _robot(robot: RobotStory, story: Story, end_s: float) -> dict[str, Any]:
    pieces = [
        (mode, float(robot.time_s[ticks.start]), _until(robot, ticks.stop))
        for mode, ticks in robot.pieces()
    ]
    numbers = {
        id(transition): f"{ground.label_of(story, robot)}{first + place}"
        for first, group in ground.grouped(robot.transitions)
        for place, transition in enumerate(group)
    }
    return {
        "story": robot,
        "events": [{**t, "number": numbers[id(t)]} for t in robot.transitions],
        "recoveries": [{**one, "detail": _detail(one)} for one in robot.recoveries],
        "strip": svg.strip(pieces, NAMES, end_s),
        "charts": [
            {
                "title": chart.title,
                "note": chart.note,
                "legend": chart.legend,
                "svg": svg.drawn(chart, pieces, end_s),
            }
            for chart in _charts(robot, story, end_s)
        ],
        "rules": heat.rule_heats(robot, end_s),
    }


def _until(robot: RobotStory, tick: int) -> float:
    return float(robot.time_s[min(tick, len(robot.time_s) - 1)])


def _charts(robot: RobotStory, story: Story, end_s: float) -> list[svg.Chart]:
    time_s = robot.time_s
    fastest, hardest = story.limits
    recovered = [
        (one["time_s"], "change", f"{one['time_s']:.1f} s: {words(one['cause'])}")
        for one in robot.recoveries
    ]
    touched = [
        (one["time_s"], "contact", f"{one['time_s']:.1f} s: touched {one['name']}")
        for one in robot.contacts
    ]
    charts = [
        svg.Chart(
            "Speed V [m/s]", time_s,
            [svg.Line("first", robot.command[:, 0]), svg.Line("second", robot.measured[:, 0])],
            limits=[(fastest, "limit")], marks=touched,
            legend=[("track", "commanded"), ("box", "measured by wheels and gyroscope")],
        ),
        svg.Chart(
            "Turn rate ω [rad/s], left positive", time_s,
            [svg.Line("first", robot.command[:, 1]), svg.Line("second", robot.measured[:, 1])],
            limits=_turn_limits(robot, hardest), marks=touched,
        ),
        svg.Chart(
            "Clearance [m]", time_s,
            [svg.Line("first", np.where(robot.clearance_m > 2.0, np.nan, robot.clearance_m))],
            low=0.0, marks=[*recovered, *touched],
            note="From the outline to the nearest thing that really stands there, by truth, up to "
            "2 m. Dotted lines: recoveries.",
        ),
    ]  # fmt: skip
    if np.isfinite(robot.cost_to_go).any():
        charts.append(
            svg.Chart(
                "Cost to go", time_s, [svg.Line("first", robot.cost_to_go)], low=0.0,
                height=110.0, marks=recovered,
                note="Of the field under the robot: it falls while the robot gets on, and jumps "
                "where the map turned out to be another.",
            )
        )  # fmt: skip
    charts.append(_curvatures(robot, end_s))
    if not robot.judged:
        return charts
    charts.append(
        svg.Chart(
            "Localisation error [m]", time_s, [svg.Line("first", robot.off_m)],
            [svg.Band("believed", np.zeros(len(time_s)), 2 * robot.sigma_m)],
            low=0.0, high=_most_off(robot),
            legend=[("track", "off, by truth"), ("soft", "two sigma of what it believes")],
        )
    )  # fmt: skip
    return charts


def _curvatures(robot: RobotStory, end_s: float) -> svg.Chart:
    v, w = robot.command.T
    moving = np.abs(v) > 0.03
    curvature = np.divide(w, v, out=np.full(len(v), np.nan), where=moving)
    modes = np.array(robot.mode)
    lines = [
        svg.Line(mode, np.where(modes == mode, curvature, np.nan), dots=True)
        for mode in MODES[2:]
        if (modes == mode).any()
    ]
    picture = heat.curvature_picture(robot, end_s)
    note = "Curvature ω/V of the command, a dot per tick."
    if picture:
        note += (
            " Behind: how far arcs of every curvature were free where the curvature velocity "
            "method "
            "was asked; the fuller, the longer."
        )
    return svg.Chart(
        "Curvature chosen [1/m], left positive", robot.time_s, lines,
        low=-heat.CURVATURE_PER_M, high=heat.CURVATURE_PER_M, height=190.0, note=note,
        image=picture,
    )  # fmt: skip


def _turn_limits(robot: RobotStory, hardest: float) -> list[tuple[float, str]]:
    """Show the limit only where the robot came near it: otherwise it flattens the chart."""
    most = float(np.nanmax(np.abs(robot.command[:, 1]), initial=0.0))
    return [(hardest, "limit"), (-hardest, "limit")] if most > 0.8 * hardest else []


def _most_off(robot: RobotStory) -> float:
    """What the chart of errors must show: the error, and the belief where it is not far larger."""
    off = float(np.nanmax(robot.off_m, initial=0.0))
    sigmas = 2 * robot.sigma_m[np.isfinite(robot.sigma_m)]
    believed = float(np.quantile(sigmas, 0.98)) if len(sigmas) else 0.0
    return max(1.15 * off, min(1.1 * believed, 3 * max(off, 0.05)), 0.02)


def _facts(story: Story) -> list[Fact]:
    told = story.headline
    if not told:
        driven = sum(
            float(np.hypot(*np.diff(robot.truth[:, :2], axis=0).T).sum()) for robot in story.robots
        )
        return [Fact("time", f"{story.duration_s:.1f} s"), Fact("driven", metres(driven, 1))]
    planned = told.get("planned_length_m")
    contacts, clearance = told.get("contacts", 0), told.get("least_clearance_m")
    return [
        Fact("time", f"{told['time_s']:.1f} s"),
        Fact("driven", metres(told["path_length_m"], 1), f"of {metres(planned, 1)} planned"
             if planned and len(story.robots) == 1 else ""),
        Fact("off the goal", metres(told.get("arrival_error_m")), "by truth"),
        Fact("contacts", str(contacts) if contacts else "none", kind="bad" if contacts else ""),
        Fact("least clearance", "nothing near" if clearance is None else metres(clearance)),
        Fact("plans", str(told.get("plan_count", "–"))),
        Fact("changes of mode", str(told.get("transitions", "–"))),
        Fact("recoveries", str(told.get("recoveries", "–"))),
        Fact("pose off", metres(told.get("drift_m")), f"at most {metres(told.get('drift_max_m'))}"),
    ]  # fmt: skip


def _sentence(story: Story) -> str:
    sentence = story.headline.get("sentence")
    if sentence is None:
        return f"Cut off after {story.duration_s:.1f} s; last: {story.robots[0].sentence[-1]}"
    return sentence[:1].upper() + sentence[1:]


def _made_from(story: Story) -> str:
    scenario = story.scenario
    parts = [
        f"scenario {story.name}",
        f"seed {story.headline.get('seed', scenario.get('seed', '?'))}",
        f"{scenario.get('robot', '?')} robot, profile {scenario.get('profile', '?')}",
        f"pose by {POSE_BY.get(str(scenario.get('pose')), '?')}",
        f"map {scenario.get('map', '?')}",
    ]
    if "version" in story.summary:
        parts.append(f"Cairn {story.summary['version']}")
    if "config_hash" in story.summary:
        parts.append(f"configuration {story.summary['config_hash']}")
    return "; ".join(parts) + _TRUTH[all(r.judged for r in story.robots)]


def _plain(summary: dict[str, Any]) -> str:
    if not summary:
        return ""
    return json.dumps(plain(summary.get("summary", {})), indent=2, ensure_ascii=False)


def _data(story: Story) -> dict[str, Any]:
    """What the player moves: positions, modes and sentences by tick."""
    sentences: dict[str, int] = {}
    modes = list(dict.fromkeys([*MODES, *(m for robot in story.robots for m in robot.mode)]))
    robots = []
    for robot in story.robots:
        robots.append(
            {
                "t": _short(robot.time_s, 2),
                "x": _short(robot.truth[:, 0], 3),
                "y": _short(robot.truth[:, 1], 3),
                "h": _short(robot.truth[:, 2], 3),
                "v": _short(np.nan_to_num(robot.command[:, 0]), 2),
                "mode": [modes.index(mode) for mode in robot.mode],
                "echoes": _echoes(robot),
                "said": [sentences.setdefault(text, len(sentences)) for text in robot.sentence],
            }
        )
    return {
        "end_s": round(story.duration_s, 3),
        "modes": modes,
        "names": NAMES,
        "sentences": list(sentences),
        "sonars": [[round(value, 4) for value in sonar] for sonar in story.sonars],
        "robots": robots,
    }


def _echoes(robot: RobotStory) -> list[list[int]] | None:
    """What the sonars measured at every tick [cm]; -1: no echo."""
    if robot.echoes_m is None:
        return None
    whole = np.where(np.isfinite(robot.echoes_m), np.round(100 * robot.echoes_m), -1)
    return whole.astype(int).tolist()


def _short(values: np.ndarray, decimals: int) -> list[float]:
    return [round(float(value), decimals) for value in values]


def _detail(recovery: dict[str, Any]) -> str:
    """The numbers of a cause, as text."""
    parts = []
    for key, value in recovery.items():
        if key in ("time_s", "cause", "remedy"):
            continue
        name, _, unit = key.rpartition("_")
        known = {"m": " m", "s": " s", "rad": " rad", "mps": " m/s", "radps": " rad/s"}.get(unit)
        said = _value(value)
        parts.append(f"{words(name)} {said}{known}" if known and name else f"{words(key)} {said}")
    return ", ".join(parts)


def _value(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, dict) and {"x", "y"} <= set(value):
        return f"({value['x']:.2f}, {value['y']:.2f}) m"
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def words(code: str) -> str:
    """A code as words."""
    return str(code).replace("_", " ")


def metres(value: float | None, decimals: int = 2) -> str:
    """A length, or a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:.{decimals}f} m"
