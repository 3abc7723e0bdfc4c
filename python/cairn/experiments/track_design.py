"""A driver's rules with numbers left open: from a design to the controller file, and what to tune.

The rules are those of [Maalouf06 §4]: Table 1 as printed, and a driver's sense in the second
module. What is open are the places of the sets, the speeds, and how hard to turn. Everything a
tuner may try keeps the surfaces monotone: farther off course means turning harder and slower, a
nearer or sharper bend means slower.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

DISTANCES = ("Touching", "Near", "Short", "Middle", "Far", "VeryFar")
BENDS = ("None", "Slight", "Bend", "Sharp")
TURNS = ("Slight", "Some", "Strong", "Full")

LEAST_STEP_MPS = 0.015


def _open(low: float, high: float, default: float) -> Any:
    from dataclasses import field

    return field(default=default, metadata={"bounds": (low, high)})


@dataclass(frozen=True)
class Design:
    """Every number of the controller; SI units and radians. Steps and shares keep orders."""

    # Turns at which the look-ahead module speaks of Straight, High and VeryHigh.
    alpha_straight: float = _open(0.02, 0.45, 0.367)
    alpha_high_step: float = _open(0.15, 0.7, 0.158)
    alpha_very_high_step: float = _open(0.25, 1.0, 0.998)
    c_moderate: float = _open(0.5, 2.4, 2.268)
    c_high: float = _open(2.5, 4.5, 3.425)
    # Distances at which the sets of dR have their peaks.
    touching_m: float = _open(0.03, 0.09, 0.075)
    near_step: float = _open(0.04, 0.12, 0.082)
    short_step: float = _open(0.06, 0.16, 0.078)
    middle_step: float = _open(0.08, 0.24, 0.09)
    far_step: float = _open(0.15, 0.45, 0.245)
    very_far_step: float = _open(0.25, 0.9, 0.425)
    # Bearings at which the sets of dtheta have theirs.
    slight_rad: float = _open(0.03, 0.2, 0.09)
    some_step: float = _open(0.08, 0.35, 0.17)
    strong_step: float = _open(0.15, 0.8, 0.22)
    full_step: float = _open(0.4, 1.4, 0.48)
    # V straight on, by distance; the last is the robot's own limit.
    touching_mps: float = _open(0.04, 0.4, 0.25)
    near_mps: float = _open(0.02, 0.4, 0.366)
    short_mps: float = _open(0.015, 0.1, 0.047)
    middle_mps: float = _open(0.015, 0.1, 0.017)
    far_mps: float = _open(0.015, 0.1, 0.016)
    # V towards a sharp bend, by distance.
    sharp_touching_mps: float = _open(0.02, 0.25, 0.2)
    sharp_near_mps: float = _open(0.0, 0.2, 0.08)
    sharp_short_mps: float = _open(0.0, 0.3, 0.097)
    sharp_middle_mps: float = _open(0.0, 0.3, 0.278)
    sharp_far_mps: float = _open(0.0, 0.3, 0.014)
    sharp_very_far_mps: float = _open(0.0, 0.4, 0.34)
    # How far a slight bend, and one beyond the next node, slow down: 0 not, 1 as a sharp one here.
    slight_bend_share: float = _open(0.0, 0.8, 0.629)
    bend_share: float = _open(0.05, 0.9, 0.787)
    # Of that speed, what is left at each bearing; nothing at the last.
    slight_keeps: float = _open(0.6, 1.0, 0.82)
    some_keeps: float = _open(0.3, 1.0, 0.42)
    strong_keeps: float = _open(0.1, 0.8, 0.55)
    # Weight of the rules that hold the present speed.
    holding: float = _open(0.0, 4.0, 0.141)
    # omega when standing, at each bearing, in rad/s per rad.
    standing_gain: float = _open(0.4, 3.0, 2.1)
    standing_most: float = _open(0.9, 2.4, 1.5)
    # omega at full speed: pure pursuit's 2 V sin(dtheta) / dR times these, by distance.
    touching_gain: float = _open(0.05, 0.9, 0.092)
    near_gain: float = _open(0.3, 1.1, 0.72)
    short_gain: float = _open(0.6, 1.05, 0.96)
    middle_gain: float = _open(0.7, 1.1, 0.854)
    far_gain: float = _open(0.7, 1.3, 0.987)
    very_far_gain: float = _open(0.6, 1.6, 0.861)
    moving_most: float = _open(1.2, 2.44, 2.386)
    # Speed of turning into a path at a right angle, and at one that is not seen in time; aiming
    # within a tick.
    joining_mps: float = _open(0.08, 0.45, 0.201)
    corner_mps: float = _open(0.08, 0.4, 0.253)
    hold_share: float = _open(0.0, 0.85, 0.82)

    @classmethod
    def bounds(cls) -> NDArray[np.float64]:
        """(n, 2) of the open numbers, in order of the fields."""
        return np.array([entry.metadata["bounds"] for entry in fields(cls)])

    @classmethod
    def from_unit(cls, unit: NDArray[np.float64]) -> Design:
        """The design at a point of the unit cube."""
        low, high = cls.bounds().T
        values = low + (high - low) * np.clip(unit, 0, 1)
        names = [entry.name for entry in fields(cls)]
        return cls(**dict(zip(names, map(float, values), strict=True)))

    def to_unit(self) -> NDArray[np.float64]:
        """The point of the unit cube where this design lies."""
        low, high = self.bounds().T
        return (np.array(list(asdict(self).values())) - low) / (high - low)

    def rounded(self, digits: int = 3) -> Design:
        """The design with numbers that a person would write."""
        return replace(self, **{k: round(v, digits) for k, v in asdict(self).items()})


@dataclass(frozen=True)
class Tables:
    """A design worked out: places of sets, and a number for every rule."""

    alphas: tuple[float, float, float]
    distances: list[float]
    bearings: list[float]
    speeds: NDArray[np.float64]  # (bearing 0..4, distance, bend)
    turns: NDArray[np.float64]  # (standing or full speed, distance, bearing 1..4)


def tables(design: Design, full_mps: float = 0.7, most_radps: float = 2.44) -> Tables:
    """The numbers that a design stands for."""
    d = design
    first = d.alpha_straight
    second = first + d.alpha_high_step
    alphas = (first, second, second + d.alpha_very_high_step)
    distances = np.cumsum(
        [d.touching_m, d.near_step, d.short_step, d.middle_step, d.far_step, d.very_far_step]
    )
    bearings = np.cumsum([d.slight_rad, d.some_step, d.strong_step, d.full_step])
    # Waypoints farther apart are always driven faster, if by little.
    straight = np.minimum(
        np.cumsum([d.touching_mps, d.near_mps, d.short_mps, d.middle_mps, d.far_mps, full_mps]),
        full_mps - LEAST_STEP_MPS * np.arange(len(DISTANCES) - 1, -1, -1),
    )
    sharp = np.cumsum(
        [d.sharp_touching_mps, d.sharp_near_mps, d.sharp_short_mps, d.sharp_middle_mps,
         d.sharp_far_mps, d.sharp_very_far_mps]
    )  # fmt: skip
    sharp = np.minimum(sharp, straight)
    shares = np.array([0.0, min(d.slight_bend_share, d.bend_share), d.bend_share, 1.0])
    ahead = straight[:, None] + (sharp - straight)[:, None] * shares
    keeps = np.cumprod([1.0, d.slight_keeps, d.some_keeps, d.strong_keeps, 0.0])
    speeds = np.round(ahead[None] * keeps[:, None, None], 2)
    standing = np.minimum(d.standing_gain * bearings, min(d.standing_most, most_radps))
    gains = np.array(
        [d.touching_gain, d.near_gain, d.short_gain, d.middle_gain, d.far_gain, d.very_far_gain]
    )
    arcs = 2 * full_mps * np.sin(np.minimum(bearings, math.pi / 2))[None] / distances[:, None]
    moving = np.minimum(arcs * gains[:, None], min(d.moving_most, most_radps))
    turns = np.round(np.stack([np.broadcast_to(standing, moving.shape), moving]), 3)
    first, second, third = (float(round(a, 3)) for a in alphas)
    return Tables(
        (first, second, third),
        [float(round(v, 3)) for v in distances],
        [float(round(v, 3)) for v in bearings],
        np.asarray(speeds, np.float64),
        np.asarray(turns, np.float64),
    )


HEADER = """\
# Fuzzy path tracker for the Pioneer P3-AT, after a driver: straight road, go fast; bend ahead, slow
# down; large heading error, turn hard and slowly [Maalouf06 §4]. SI units and radians. Zero-order
# Sugeno systems: an output is the mean of the numbers that rules name, weighted by their strengths.
"""


def controller_text(design: Design, header: str = HEADER) -> str:
    """The controller file of a design."""
    worked = tables(design)
    lines = [header, *_scalars(design), *_look_ahead(design, worked), *_tracker(design, worked)]
    return "\n".join(lines) + "\n"


def _scalars(d: Design) -> list[str]:
    return [
        "latency_s = 0.1      # from a command to the motion that follows it",
        "arrival_m = 0.03     # at rest within this distance of the goal: arrived",
        "braking_share = 0.9  # of the robot's deceleration, counted on for stopping at the goal",
        f"joining_mps = {d.joining_mps:<6.3g} # off its path, the robot turns into it at a right "
        "angle at this speed",
        f"corner_mps = {d.corner_mps:<7.3g} # at a right angle of the path that the rules "
        "do not see in time",
        f"hold_share = {d.hold_share:<7.3g} # of a tick: a command holds for one, and is aimed at "
        "this part of it",
        "",
        "# ---- First module: turns at the next two waypoints -> look-ahead curvature C "
        + "-" * 20,
        "",
        "[look_ahead]",
        'and = "product"',
    ]


def _look_ahead(d: Design, worked: Tables) -> list[str]:
    a, b, c = worked.alphas
    lines = []
    for number, where in (("1", "N_i+1, 0 is straight on"), ("2", "N_i+2")):
        lines += [
            "",
            f"[look_ahead.inputs.alpha{number}]                       # turn at {where}",
            "range = [0.0, 3.141593]",
            f"sets.Straight{number} = {{ left_shoulder = [{a}, {b}] }}",
            f"sets.High{number} = {{ triangle = [{a}, {b}, {c}] }}",
            f"sets.VeryHigh{number} = {{ right_shoulder = [{b}, {c}] }}",
        ]
    return [
        *lines,
        "",
        "[look_ahead.outputs.C]",
        "NoCurvature = 0.0",
        f"cModerate = {d.c_moderate:.3g}",
        f"cHigh = {d.c_high:.3g}",
        "cVeryHigh = 5.0",
        "",
        "[[look_ahead.tables]]                            # Table 1 of the paper",
        'output = "C"',
        'rows = "alpha2"',
        'columns = "alpha1"',
        'cells.Straight2 = { Straight1 = "NoCurvature", High1 = "cHigh", VeryHigh1 = "cVeryHigh" }',
        'cells.High2 =     { Straight1 = "cModerate",   High1 = "cHigh", VeryHigh1 = "cVeryHigh" }',
        'cells.VeryHigh2 = { Straight1 = "cHigh",       High1 = "cHigh", VeryHigh1 = "cVeryHigh" }',
        "",
        "# ---- Second module: C, dR, dtheta, Vc -> V, omega " + "-" * 48,
        "",
        "[tracker]",
        'and = "product"',
    ]


def _sets(names: list[str], peaks: list[float]) -> list[str]:
    last = len(names) - 1
    lines = [f"sets.{names[0]} = {{ left_shoulder = [{peaks[0]}, {peaks[1]}] }}"]
    for i in range(1, last):
        inside = ", ".join(str(p) for p in peaks[i - 1 : i + 2])
        lines.append(f"sets.{names[i]} = {{ triangle = [{inside}] }}")
    return [*lines, f"sets.{names[last]} = {{ right_shoulder = [{peaks[-2]}, {peaks[-1]}] }}"]


def _tracker(d: Design, worked: Tables) -> list[str]:
    moderate, high = float(f"{d.c_moderate:.3g}"), float(f"{d.c_high:.3g}")
    rights, lefts = [f"{t}Right" for t in TURNS], [f"{t}Left" for t in TURNS]
    mirrored = [*(-b for b in reversed(worked.bearings)), 0.0, *worked.bearings]
    lines = [
        "",
        "[tracker.inputs.C]                               # look-ahead curvature",
        "range = [0.0, 5.0]",
        *_sets(list(BENDS), [0.0, moderate, high, 5.0]),
        "",
        "[tracker.inputs.dR]                              # distance to N_i+1 [m]",
        "range = [0.0, 2.0]",
        *_sets(list(DISTANCES), worked.distances),
        "",
        "[tracker.inputs.dtheta]                          # bearing of N_i+1, left positive [rad]",
        "range = [-3.141593, 3.141593]",
        *_sets([*reversed(rights), "Ahead", *lefts], mirrored),
        "",
        "[tracker.inputs.Vc]                              # current speed [m/s]",
        "range = [0.0, 0.7]",
        "sets.Slow = { left_shoulder = [0.0, 0.7] }",
        "sets.Fast = { right_shoulder = [0.0, 0.7] }",
        "",
        "[tracker.outputs.V]                              # [m/s]",
        "[tracker.outputs.omega]                          # [rad/s]",
    ]
    if d.holding > 0.005:
        lines += [
            "",
            "# A driver does not jump from one speed to another: these hold the present speed.",
        ]
        for speed, value in (("Slow", 0.0), ("Fast", 0.7)):
            lines += [
                "[[tracker.rules]]",
                f'when = {{ Vc = "{speed}" }}',
                f"then = {{ V = {value} }}",
                f"weight = {d.holding:.2f}",
            ]
    remarks = (
        "# Waypoints far apart: fast; close together: slow. Bend ahead: slow, more the nearer.",
        "# Not quite on course: a little slower.",
        "# Off course: slower.",
        "# Well off course: turn hard, slowly.",
    )
    for i, remark in enumerate(remarks):
        when = '"Ahead"' if i == 0 else f'["{TURNS[i - 1]}Left", "{TURNS[i - 1]}Right"]'
        lines += [
            "",
            remark,
            "[[tracker.tables]]",
            f"when = {{ dtheta = {when} }}",
            'output = "V"',
            'rows = "dR"',
            'columns = "C"',
        ]
        for row, name in enumerate(DISTANCES):
            cells = ", ".join(
                f"{bend} = {worked.speeds[i, row, column]:.2f}" for column, bend in enumerate(BENDS)
            )
            lines.append(f"cells.{name + ' =':<10} {{ {cells} }}")
    lines += [
        "",
        "# Looking the other way: turn on the spot.",
        "[[tracker.rules]]",
        'when = { dtheta = ["FullLeft", "FullRight"] }',
        "then = { V = 0.0 }",
    ]
    remarks = (
        "# Standing: turn by the bearing alone.",
        "# Moving: steer on an arc through the waypoint, gently where it is all but reached.",
    )
    for i, (speed, remark) in enumerate(zip(("Slow", "Fast"), remarks, strict=True)):
        lines += [
            "",
            remark,
            "[[tracker.tables]]",
            f'when = {{ Vc = "{speed}" }}',
            'output = "omega"',
            'rows = "dR"',
            'columns = "dtheta"',
        ]
        for row, name in enumerate(DISTANCES):
            values = worked.turns[i, row]
            left = [f"{n} = {v:.3f}" for n, v in zip(lefts, values, strict=True)]
            right = [f"{n} = {-v:.3f}" for n, v in zip(rights, values, strict=True)]
            cells = ", ".join([*reversed(right), "Ahead = 0.0", *left])
            lines.append(f"cells.{name + ' =':<10} {{ {cells} }}")
    return lines
