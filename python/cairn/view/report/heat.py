"""Pictures of what happens over time to many things at once, small enough to be part of a page."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from cairn.view.story import RobotStory

COLUMNS = 700
RULES_AT_MOST = 14
TEAL, AMBER = (18, 161, 153), (214, 140, 40)
CURVATURE_PER_M = 2.0  # as far as the picture of curvatures goes, to either side
CURVATURE_ROWS = 81
SYMBOLS = {"alpha1": "α₁", "alpha2": "α₂", "dtheta": "dθ", "omega": "ω"}
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RuleHeat:
    """Strengths of a module's rules over time.

    Args:
        title: which rules.
        names: of the rows, from the top.
        picture: address of a PNG, a row per rule, a column per share of the run.
        shares: of all strength of the module that each row had.
        others: how many rules fired that are left out.
        others_most: their greatest strength.
    """

    title: str
    names: list[str]
    picture: str
    shares: list[float]
    others: int
    others_most: float


def rule_heats(robot: RobotStory, end_s: float) -> list[RuleHeat]:
    """Return the rules of both modules over time; empty for a robot that never tracked."""
    found = []
    for module, output, title in (
        ("look_ahead", "C", "look-ahead rules: turns ahead → curvature C"),
        ("tracker", "V", "speed rules: → V [m/s]"),
        ("tracker", "omega", "turning rules: → ω [rad/s]"),
    ):
        rules = [
            {} if t is None else _of(t.get(module, {}).get("rules", {}), output)
            for t in robot.tracking
        ]
        if any(rules):
            found.append(_heat(title, rules, robot.time_s, end_s))
    return found


def _of(rules: dict[str, float], output: str) -> dict[str, float]:
    return {
        rule: s for rule, s in rules.items() if f"then {output} " in rule or f", {output} " in rule
    }


def _heat(title: str, rules: list[dict[str, float]], time_s: Floats, end_s: float) -> RuleHeat:
    names = sorted({name for each in rules for name in each})
    number = {name: row for row, name in enumerate(names)}
    strengths = np.zeros((len(names), len(rules)))
    for tick, each in enumerate(rules):
        for name, strength in each.items():
            strengths[number[name], tick] = strength
    totals = strengths.sum(axis=1)
    order = np.argsort(-totals, kind="stable")
    shown, rest = order[:RULES_AT_MOST], order[RULES_AT_MOST:]
    firsts = [int(np.flatnonzero(strengths[row])[0]) if totals[row] else 0 for row in shown]
    shown = shown[np.argsort(firsts, kind="stable")]
    shares = totals[shown] / max(totals.sum(), 1e-12)
    return RuleHeat(
        title,
        [spoken(names[row]) for row in shown],
        picture_of(_columns(strengths[shown], time_s, end_s), TEAL),
        [float(share) for share in shares],
        int((totals[rest] > 0).sum()),
        float(strengths[rest].max()) if len(rest) else 0.0,
    )


def spoken(rule: str) -> str:
    """A rule, shorter: `if alpha1 Straight1 and ..` → `α₁ Straight1 · .. → C NoCurvature`."""
    text = rule.removeprefix("if ").replace(" and ", " · ").replace(" then ", " → ")
    return re.sub(r"\b(alpha1|alpha2|dtheta|omega)\b", lambda found: SYMBOLS[found[0]], text)


def _columns(values: Floats, time_s: Floats, end_s: float) -> Floats:
    """Spread ticks (.., n) over the columns of a picture: of several ticks the greatest counts."""
    columns = min(COLUMNS, max(len(time_s), 1))
    at = np.minimum((time_s / max(end_s, 1e-9) * columns).astype(int), columns - 1)
    out = np.zeros((columns, len(values)))
    np.maximum.at(out, at, values.T)
    return out.T


def curvature_picture(robot: RobotStory, end_s: float) -> str:
    """Address of a PNG: free length of every curvature over time, where arcs were asked for.

    Rows from +`CURVATURE_PER_M` (left) at the top to its negative; the fuller, the longer.
    """
    at = np.linspace(CURVATURE_PER_M, -CURVATURE_PER_M, CURVATURE_ROWS)
    free = np.zeros((CURVATURE_ROWS, len(robot.time_s)))
    most = 0.0
    for tick, avoidance in enumerate(robot.avoidance):
        for one in (avoidance or {}).get("intervals", ()):
            length = one["distance_m"]
            if length is None:
                continue
            most = max(most, length)
            inside = (at >= one["curvature_lo"]) & (at <= one["curvature_hi"])
            free[inside, tick] = np.maximum(free[inside, tick], length)
    if most == 0.0:
        return ""
    return picture_of(_columns(free / most, robot.time_s, end_s), AMBER, most=0.75)


def picture_of(shares: Floats, colour: tuple[int, int, int], most: float = 1.0) -> str:
    """Address of a PNG of one colour, the fuller the greater the share (rows, columns) in [0, "
    "1]."""
    pixels = np.empty((*shares.shape, 4), np.uint8)
    pixels[..., :3] = colour
    pixels[..., 3] = np.clip(255 * most * np.sqrt(np.clip(shares, 0, 1)), 0, 255)
    return address(Image.fromarray(pixels, "RGBA"))


def address(image: Image.Image, **how: Any) -> str:
    """An image as a data address."""
    written = io.BytesIO()
    image.save(written, "PNG", optimize=True, **how)
    return "data:image/png;base64," + base64.b64encode(written.getvalue()).decode()
