"""How far an arc is free before it touches, after Fig. 10 [Maalouf06 §5 (7)] [Simmons96]."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import cairn

OBSTACLES = ((1.9, 0.75), (1.35, -0.95), (2.6, -0.15))  # in the robot frame [m]
TWIST = (0.45, 0.0)
GOAL_BEARING_RAD = 0.55
MARCH_STEP_M = 0.0005


def measure() -> dict[str, Any]:
    """Let the curvature velocity method choose beside three obstacles, as the paper's round robot.

    Returns:
        `intervals` {curvature_lo, curvature_hi, distance_m}, `candidates`, `twist`, `obstacles`,
        the `radius_m` that centres must keep, and for every interval `marched_m`: how far the
        shortest of 21 arcs in it is free when they are followed in steps of half a millimetre.
    """
    profile = cairn.Profile.load("p3at")
    method = cairn.Cvm(profile, shape="disc")
    config = method.config
    told = method.choose(TWIST, GOAL_BEARING_RAD, math.inf, OBSTACLES).to_dict()
    box = profile.footprint
    radius = math.hypot(box.length_m, box.width_m) / 2 + config["obstacle_radius_m"]
    radius += config["margin_m"]
    horizon = config["horizon_m"]
    intervals = told["intervals"]
    ends = [(one["curvature_lo"], one["curvature_hi"]) for one in intervals]
    marched = [
        min(march(c, radius, horizon) for c in np.linspace(low, high, 21)) for low, high in ends
    ]
    short = [free - one["distance_m"] for free, one in zip(marched, intervals, strict=True)]
    tangents = [tangent_estimate(x, y, radius) for x, y in OBSTACLES]
    return {
        "summary": {
            "intervals": len(intervals),
            "radius_m": radius,
            "horizon_m": horizon,
            "never_too_long": bool(min(short) >= -2 * MARCH_STEP_M),
            "most_too_short_m": max(short),
            "twist": told["twist"],
            "tangent_estimate_too_long_m": max(
                estimate - _first_contact(x, y, radius)
                for (x, y), (_, _, estimate) in zip(OBSTACLES, tangents, strict=True)
            ),
        },
        "intervals": intervals,
        "candidates": told["candidates"],
        "twist": told["twist"],
        "obstacles": [list(one) for one in OBSTACLES],
        "radius_m": radius,
        "horizon_m": horizon,
        "goal_bearing_rad": GOAL_BEARING_RAD,
        "outline_m": [box.length_m, box.width_m],
        "marched_m": marched,
        "tangents": [list(one) for one in tangents],
    }


def march(curvature: float, radius: float, horizon: float) -> float:
    """Follow an arc in small steps until its centre is nearer than `radius` to an obstacle [m]."""
    way = np.arange(0.0, horizon + MARCH_STEP_M, MARCH_STEP_M)
    points = along(curvature, way)
    touches = np.zeros(len(way), bool)
    for x, y in OBSTACLES:
        touches |= np.hypot(points[:, 0] - x, points[:, 1] - y) <= radius
    return float(way[touches][0]) if touches.any() else horizon


def along(curvature: float, way: Any) -> np.ndarray:
    """Points (n, 2) of an arc that starts ahead from the origin, after so much way [m]."""
    way = np.asarray(way, float)
    if abs(curvature) < 1e-9:
        return np.stack([way, np.zeros_like(way)], axis=-1)
    angle = curvature * way
    return np.stack([np.sin(angle), 1 - np.cos(angle)], axis=-1) / curvature


def tangent_estimate(x: float, y: float, radius: float) -> tuple[float, float, float]:
    """(c_min, c_max, distance) of one obstacle as published: the nearer of its tangent points.

    The arcs that hit it are exactly those between the tangent curvatures; the distance is
    optimistic for those between them [Simmons96].
    """
    room = x * x + y * y - radius * radius
    tangents = (2 * (y - radius) / room, 2 * (y + radius) / room)
    lengths = []
    for curvature in tangents:
        towards = np.array([x, y - 1 / curvature])  # from the arc's centre to the obstacle
        point = np.array([0, 1 / curvature]) + towards / np.hypot(*towards) * abs(1 / curvature)
        turn = math.atan2(point[0] * abs(curvature), 1 - point[1] * curvature)
        lengths.append((turn % math.tau) / abs(curvature))
    return (*tangents, min(lengths))


def _first_contact(x: float, y: float, radius: float) -> float:
    """Least free length of all arcs that hit one obstacle [m]."""
    low, high, _ = tangent_estimate(x, y, radius)
    way = np.arange(0.0, math.hypot(x, y) * 1.3, MARCH_STEP_M)
    least = math.inf
    for curvature in np.linspace(low, high, 201)[1:-1]:
        near = np.hypot(*(along(curvature, way) - (x, y)).T) <= radius
        if near.any():
            least = min(least, float(way[near][0]))
    return least
