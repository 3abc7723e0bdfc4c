"""Paths to judge a tracker by [Maalouf06 §7, Figs. 14–16], and others, by seed, to tune it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

OFFICE_TRIPS = (("reception", "lab"), ("canteen", "lounge"), ("office 3", "server room"))


@dataclass(frozen=True)
class Reference:
    """A continuous path to follow, and where the robot stands at first.

    Attributes:
        name: as the command calls it.
        path: (n, 2) world frame [m], dense enough to be the curve itself.
        start: pose (x, y, heading) at rest.
        joins: the robot starts off the path, or turned away from it: the first metres are joining.
    """

    name: str
    path: Floats
    start: tuple[float, float, float]
    joins: bool = False

    @property
    def length_m(self) -> float:
        """Of the path."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())


def sine(amplitude_m: float = 1.0, period_m: float = 2 * math.pi, periods: float = 2) -> Reference:
    """Fig. 14: a sine wave from the origin, the robot looking along x."""
    x = np.linspace(0, periods * period_m, 400 * math.ceil(periods) + 1)
    path = np.column_stack([x, amplitude_m * np.sin(2 * math.pi * x / period_m)])
    return Reference("sine", path, (0.0, 0.0, 0.0))


def step(length_m: float = 10.0) -> Reference:
    """Fig. 15: y = 1 m from x = 0 on, the robot at the origin looking along x."""
    return Reference("step", np.array([(0.0, 1.0), (length_m, 1.0)]), (0.0, 0.0, 0.0), True)


def ramp(length_m: float = 8.0) -> Reference:
    """Fig. 16: a straight line at 135°, the robot at the origin looking along x."""
    end = length_m * math.cos(math.radians(135)), length_m * math.sin(math.radians(135))
    return Reference("ramp", np.array([(0.0, 0.0), end]), (0.0, 0.0, 0.0), True)


def squares(side_m: float = 4.0, sides: int = 8) -> Reference:
    """Round a square, first to the left, then (half-way) to the right: only right angles."""
    corners, heading = [np.zeros(2)], 0.0
    for number in range(sides):
        ahead = np.array([math.cos(heading), math.sin(heading)])
        corners.append(corners[-1] + side_m * ahead)
        heading += math.pi / 2 if number < sides // 2 else -math.pi / 2
    return Reference("squares", np.round(np.array(corners), 12), (0.0, 0.0, 0.0))


def stairs(step_m: float = 1.0, steps: int = 6) -> Reference:
    """Right angles to the left and right by turns, one step apart."""
    points = [((i + 1) // 2 * step_m, i // 2 * step_m) for i in range(steps + 1)]
    return Reference("stairs", np.array(points, float), (0.0, 0.0, 0.0))


def eights(radius_m: float = 1.5) -> Reference:
    """A figure of eight out of two circles that touch, driven twice: left, right, left, right."""
    a = np.linspace(0, 2 * math.pi, 400)
    left = np.column_stack([radius_m * np.sin(a), radius_m * (1 - np.cos(a))])
    right = left * (1, -1)
    path = np.vstack([left, right[1:], left[1:], right[1:]])
    return Reference("eights", path, (0.0, 0.0, 0.0))


def office(number: int = 0) -> Reference:
    """One of `OFFICE_TRIPS` through the shipped office, as planned for a P3-AT, any angle."""
    import cairn

    first, last = OFFICE_TRIPS[number]
    world = cairn.maps.load("office")
    places = world.goals
    priced = cairn.costmap(world, cairn.Profile.load("p3at"))
    field = cairn.plan(priced, goal=(places[last][0], places[last][1]))
    path = field.path((places[first][0], places[first][1]), any_angle=True)
    assert path is not None  # the shipped office is in one piece
    dx, dy = path[1] - path[0]
    name = "office" if number == 0 else f"office {number + 1}"
    x, y = map(float, path[0])
    return Reference(name, path, (x, y, math.atan2(dy, dx)))


PATHS = {
    "sine": sine,
    "step": step,
    "ramp": ramp,
    "squares": squares,
    "stairs": stairs,
    "eights": eights,
    "office": office,
}


def winding(seed: int, length_m: float = 12.0, sharpest_per_m: float = 1.2) -> Reference:
    """A smooth path whose curvature wanders between ± `sharpest_per_m`, by seed."""
    random = np.random.default_rng([seed, 11])
    knots = random.uniform(-1, 1, math.ceil(length_m / 1.2) + 1)
    knots[0] = 0.0
    along = np.linspace(0, length_m, round(length_m / 0.02) + 1)
    between = along / length_m * (len(knots) - 1)
    left = np.minimum(between.astype(int), len(knots) - 2)
    blend = (1 - np.cos(math.pi * (between - left))) / 2
    curvature = sharpest_per_m * (knots[left] * (1 - blend) + knots[left + 1] * blend)
    heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * 0.02)])
    half = (heading[1:] + heading[:-1]) / 2
    steps = np.column_stack([np.cos(half), np.sin(half)]) * np.diff(along)[:, None]
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    return Reference(f"winding {seed}", path, (0.0, 0.0, 0.0))


def arcs(seed: int, pieces: int = 5) -> Reference:
    """Circular arcs one after the other, to the left and right by turns, by seed."""
    random = np.random.default_rng([seed, 15])
    curvature: list[float] = []
    for number in range(pieces):
        radius_m = random.uniform(0.8, 3.0)
        curvature += [(-1) ** number / radius_m] * round(random.uniform(1.5, 4.0) / 0.02)
    heading = np.concatenate([[0.0], 0.02 * np.cumsum(curvature)])
    half = (heading[1:] + heading[:-1]) / 2
    steps = 0.02 * np.column_stack([np.cos(half), np.sin(half)])
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    return Reference(f"arcs {seed}", path, (0.0, 0.0, 0.0))


def zigzag(
    seed: int,
    legs: int = 5,
    leg_m: tuple[float, float] = (1.2, 4.0),
    turn_deg: tuple[float, float] = (25.0, 140.0),
) -> Reference:
    """Straight legs with sharp bends of random size between them, by seed."""
    random = np.random.default_rng([seed, 12])
    points, heading = [np.zeros(2)], 0.0
    for _ in range(legs):
        ahead = np.array([math.cos(heading), math.sin(heading)])
        points.append(points[-1] + random.uniform(*leg_m) * ahead)
        heading += math.radians(random.uniform(*turn_deg)) * random.choice([-1, 1])
    return Reference(f"zigzag {seed}", np.array(points), (0.0, 0.0, 0.0))


def displaced(
    seed: int,
    length_m: float = 9.0,
    aside_m: tuple[float, float] = (0.2, 1.6),
    heading_rad: float = 1.2,
) -> Reference:
    """A straight line beside which the robot stands, turned at random; by seed."""
    random = np.random.default_rng([seed, 13])
    aside = random.uniform(*aside_m) * random.choice([-1, 1])
    heading = random.uniform(-heading_rad, heading_rad)
    path = np.array([(0.0, 0.0), (length_m, 0.0)])
    return Reference(f"displaced {seed}", path, (0.0, aside, heading), True)


def turned(seed: int, length_m: float = 6.0) -> Reference:
    """A straight line from where the robot stands, in any direction; by seed."""
    random = np.random.default_rng([seed, 14])
    heading = random.uniform(0.7, math.pi) * random.choice([-1, 1])
    path = np.array([(0.0, 0.0), (length_m, 0.0)])
    return Reference(f"turned {seed}", path, (0.0, 0.0, heading), True)
