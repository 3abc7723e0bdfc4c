"""The map of a run as SVG: what is known, what is not, the plans, the ways driven by mode, and "
"why."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from markupsafe import Markup
from PIL import Image

from cairn.view.report.heat import address
from cairn.view.report.svg import as_markup
from cairn.view.story import RobotStory, Story
from cairn.world import World

OUTLINE_EVERY_M = 1.5
JUMP_M = 0.3


def drawn(story: Story) -> Markup:
    """Return the map; y is up, units are metres, colours come from the page."""
    x0, x1, y0, y1 = story.view
    unit = max(x1 - x0, 1.3 * (y1 - y0)) / 1000.0  # about a pixel on the page
    svg = Element("svg", {
        "id": "map", "viewBox": f"{x0:.3f} {-y1:.3f} {x1 - x0:.3f} {y1 - y0:.3f}", "role": "img",
    })  # fmt: skip
    defs = SubElement(svg, "defs")
    hatch = SubElement(defs, "pattern", {
        "id": "hatch", "width": f"{9 * unit:.4f}", "height": f"{9 * unit:.4f}",
        "patternUnits": "userSpaceOnUse", "patternTransform": "rotate(45)",
    })  # fmt: skip
    SubElement(hatch, "line", {"class": "hatch", "x1": "0", "y1": "0", "x2": "0",
                               "y2": f"{9 * unit:.4f}"})  # fmt: skip
    if story.world is not None and story.world is not story.known:
        _draw_world(svg, defs, story.world, "real")
    if story.known is not None:
        _draw_world(svg, defs, story.known, "known")
    for box in story.scenario.get("boxes", ()):
        pose = (box["x_m"], box["y_m"], box.get("yaw_rad", 0.0))
        shape = {"class": "box", "points": _points(_outline(pose, box["length_m"], box["width_m"]))}
        element = SubElement(svg, "polygon", shape)
        SubElement(element, "title").text = f"{box.get('name', 'box')}: not on the map"
    for robot in story.robots:
        _draw_way(svg, story, robot)
    placed: list[tuple[float, float]] = []
    for robot in story.robots:
        _draw_ends(svg, story, robot, unit)
        _draw_notes(svg, robot, label_of(story, robot), unit, placed)
    for number, robot in enumerate(story.robots):
        _draw_robot(svg, story, robot, number)
    _draw_scale(svg, story, unit)
    return as_markup(svg)


def _draw_world(svg: Element, defs: Element, world: World, name: str) -> None:
    """Walls and unknown ground as masks, to be filled with the colours of the page."""
    r, (x, y, yaw) = world.resolution_m, world.origin
    c, s = r * math.cos(yaw), r * math.sin(yaw)
    rows, cols = world.shape
    cells = np.asarray(world.occupancy)
    group = SubElement(svg, "g", {
        "class": f"world {name}",
        "transform": f"matrix({c:.6g} {-s:.6g} {-s:.6g} {-c:.6g} {x:.6g} {-y:.6g})",
    })  # fmt: skip
    size = {"x": "0", "y": "0", "width": str(cols), "height": str(rows)}
    SubElement(group, "rect", {"class": "free", **size})
    for value, what in ((2, "unknown"), (1, "wall")):
        if not (cells == value).any():
            continue
        mask = SubElement(defs, "mask", {
            "id": f"{name}-{what}", "maskUnits": "userSpaceOnUse", **size,
        })  # fmt: skip
        white = Image.fromarray(np.where(cells == value, np.uint8(255), np.uint8(0))).convert("1")
        SubElement(mask, "image", {"href": address(white), "class": "cells", **size})
        SubElement(group, "rect", {"class": what, "mask": f"url(#{name}-{what})", **size})


def _draw_way(svg: Element, story: Story, robot: RobotStory) -> None:
    plans = [points for _, points in robot.plans if len(points) > 1]
    for number, points in enumerate(plans):
        kind = "plan" if number == len(plans) - 1 else "plan old"
        SubElement(svg, "polyline", {"class": kind, "points": _points(points)})
    if story.scenario.get("pose") != "truth":
        SubElement(svg, "path", {"class": "believed", "d": _path(robot.estimate)})
    _draw_outlines(svg, story, robot)
    for mode, ticks in robot.pieces():
        from_before = slice(max(ticks.start - 1, 0), ticks.stop)
        way = SubElement(
            svg, "path", {"class": f"way {mode}", "d": _path(robot.truth[from_before])}
        )
        SubElement(
            way, "title"
        ).text = f"{robot.time_s[ticks][0]:.1f} to {robot.time_s[ticks][-1]:.1f} s"


def _draw_outlines(svg: Element, story: Story, robot: RobotStory) -> None:
    steps = np.hypot(*np.diff(robot.truth[:, :2], axis=0).T)
    driven = np.concatenate([[0.0], np.cumsum(steps)])
    marks = np.arange(0.0, driven[-1], OUTLINE_EVERY_M)
    for row in np.searchsorted(driven, marks):
        shape = _outline(robot.truth[row], *story.outline_m)
        kind = f"was {robot.mode[row]}"
        SubElement(svg, "polygon", {"class": kind, "points": _points(shape)})


def _draw_robot(svg: Element, story: Story, robot: RobotStory, number: int) -> None:
    length, width = story.outline_m
    x, y, heading = robot.truth[-1]
    group = SubElement(svg, "g", {
        "class": f"robot {robot.mode[-1]}", "data-robot": str(number),
        "transform": f"translate({x:.3f} {-y:.3f}) rotate({-math.degrees(heading):.1f})",
    })  # fmt: skip
    SubElement(group, "path", {"class": "cones", "d": "M0 0"})  # the player's
    SubElement(group, "rect", {
        "x": f"{-length / 2:.3f}", "y": f"{-width / 2:.3f}", "width": f"{length:.3f}",
        "height": f"{width:.3f}", "rx": f"{0.12 * width:.3f}",
    })  # fmt: skip
    SubElement(group, "path", {"class": "nose", "d": f"M0 0H{length / 2:.3f}"})
    SubElement(group, "title").text = robot.name


def label_of(story: Story, robot: RobotStory) -> str:
    """What the numbers of a robot's transitions begin with: nothing where it is alone."""
    if len(story.robots) == 1:
        return ""
    initials = [one.name[:1].lower() for one in story.robots]
    number = story.robots.index(robot)
    return initials[number] if len(set(initials)) == len(initials) else f"{number + 1}."


def _draw_ends(svg: Element, story: Story, robot: RobotStory, unit: float) -> None:
    """Draw where it began, where it was to go, and what it touched."""
    start, several = robot.truth[0], len(story.robots) > 1
    tolerance_m = float(story.scenario.get("arrival_tolerance_m", 0.3))
    _pin(svg, start[:2], "start", robot.name if several else "start", unit)
    for number, goal in enumerate(robot.goals, start=1):
        if goal.get("goal_m") is None:
            continue
        name = goal.get("place") or (f"goal {number}" if len(robot.goals) > 1 else "goal")
        kind = "reached" if goal.get("outcome") == "reached" else "missed"
        ring = {"class": f"ring {kind}", "cx": f"{goal['goal_m'][0]:.3f}"}
        ring |= {"cy": f"{-goal['goal_m'][1]:.3f}", "r": f"{tolerance_m:.3f}"}
        SubElement(svg, "circle", ring)
        _pin(svg, goal["goal_m"], f"goal {kind}", str(name).replace("_", " "), unit)
    for contact in robot.contacts:
        x, y, _ = robot.truth[robot.at(contact["time_s"])]
        d = 9 * unit
        a, b = f"{2 * d:.3f}", f"{-2 * d:.3f}"
        cross = f"M{x - d:.3f} {-y - d:.3f}l{a} {a}m0 {b}l{b} {a}"
        mark = SubElement(svg, "path", {"class": "contact", "d": cross})
        SubElement(mark, "title").text = f"{contact['time_s']:.1f} s: touched {contact['name']}"


def _draw_notes(
    svg: Element, robot: RobotStory, label: str, unit: float, placed: list[tuple[float, float]]
) -> None:
    """Draw a number wherever the mode changed, beside numbers placed before."""
    for first, group in grouped(robot.transitions):
        at = tuple(group[0]["at_m"])
        x, y = at[0] + 14 * unit, at[1] + 16 * unit
        while any(math.dist((x, y), other) < 25 * unit for other in placed):
            x, y = x + 16 * unit, y + 9 * unit
        placed.append((x, y))
        last = first + len(group) - 1
        text = f"{label}{first}" if first == last else f"{label}{first}–{last}"
        mark = SubElement(svg, "g", {
            "class": "note", "data-time": f"{group[0]['time_s']:g}", "tabindex": "0",
        })  # fmt: skip
        SubElement(mark, "path", {"d": f"M{at[0]:.3f} {-at[1]:.3f}L{x:.3f} {-y:.3f}"})
        half = (8 + 3.5 * (len(text) - 1)) * unit
        SubElement(mark, "rect", {
            "x": f"{x - half:.3f}", "y": f"{-y - 9 * unit:.3f}", "width": f"{2 * half:.3f}",
            "height": f"{18 * unit:.3f}", "rx": f"{9 * unit:.3f}",
        })  # fmt: skip
        place = {"x": f"{x:.3f}", "y": f"{-y + 4.5 * unit:.3f}", "font-size": f"{12.5 * unit:.4f}"}
        SubElement(mark, "text", place).text = text
        SubElement(mark, "title").text = " ".join(t["sentence"] for t in group)


def grouped(transitions: Sequence[dict[str, Any]]) -> list[tuple[int, list[dict[str, Any]]]]:
    """Put transitions of one place and moment together: (number of the first, them)."""
    groups: list[tuple[int, list[dict[str, Any]]]] = []
    for number, transition in enumerate(transitions, start=1):
        last = groups[-1][1][-1] if groups else None
        if (
            last is not None
            and math.dist(last["at_m"], transition["at_m"]) < 0.15
            and transition["time_s"] - last["time_s"] < 3.0
        ):
            groups[-1][1].append(transition)
        else:
            groups.append((number, [transition]))
    return groups


def _pin(svg: Element, at: Any, kind: str, name: str, unit: float) -> None:
    x, y = float(at[0]), float(at[1])
    SubElement(svg, "circle", {
        "class": kind, "cx": f"{x:.3f}", "cy": f"{-y:.3f}", "r": f"{7 * unit:.4f}",
    })  # fmt: skip
    label = {
        "class": "name", "x": f"{x:.3f}", "y": f"{-y + 22 * unit:.3f}",
        "font-size": f"{13 * unit:.4f}", "stroke-width": f"{3.5 * unit:.4f}",
    }  # fmt: skip
    SubElement(svg, "text", label).text = name


def _draw_scale(svg: Element, story: Story, unit: float) -> None:
    x0, x1, y0, _ = story.view
    wanted = 0.15 * (x1 - x0)
    lengths = (m * 10.0**e for e in range(-2, 5) for m in (1, 2, 5))
    length = max((one for one in lengths if one <= wanted), default=1.0)
    right, y = x1 - 12 * unit, y0 + 10 * unit
    SubElement(svg, "path", {"class": "scale", "d": f"M{right - length:.3f} {-y:.3f}H{right:.3f}"})
    label = {
        "class": "name scale", "x": f"{right - length - 8 * unit:.3f}", "y": f"{-y + 4 * unit:.3f}",
        "font-size": f"{12 * unit:.4f}", "stroke-width": f"{3.5 * unit:.4f}",
    }  # fmt: skip
    SubElement(svg, "text", label).text = f"{length:g} m"


def _outline(pose: Any, length: float, width: float) -> np.ndarray:
    x, y, heading = (float(v) for v in pose)
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length / 2, width / 2)
    c, s = math.cos(heading), math.sin(heading)
    return half @ np.array([[c, s], [-s, c]]) + (x, y)


def _points(points: Iterable[Any]) -> str:
    return " ".join(f"{x:.3f},{-y:.3f}" for x, y in np.asarray(points, float)[:, :2])


def _path(poses: np.ndarray) -> str:
    """A way as path data, torn where the robot was pushed."""
    steps = []
    before = None
    for x, y in np.asarray(poses, float)[:, :2]:
        torn = before is None or math.hypot(x - before[0], y - before[1]) > JUMP_M
        steps.append(f"{'M' if torn else 'L'}{x:.3f} {-y:.3f}")
        before = (x, y)
    return "".join(steps)
