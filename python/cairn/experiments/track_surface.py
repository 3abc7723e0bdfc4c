"""The surfaces of the tracker over distance and bearing [Maalouf06 Fig. 9]."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import cairn

DISTANCES_M = np.linspace(0.0, 1.5, 61)
BEARINGS_RAD = np.linspace(-math.pi, math.pi, 121)


def measure(controller: str = "p3at") -> dict[str, Any]:
    """V and ω at C = 0, standing (Vc = 0, as in the figure) and at cruising speed (0.5 m/s).

    `summary` holds the range of each surface and its steepest slopes, per metre and per radian.
    """
    control = cairn.Tracker(controller, cairn.Profile.load("p3at")).control
    surfaces, summary = {}, {}
    for name, speed in (("standing", 0.0), ("cruising", 0.5)):
        told = control.evaluate(C=0.0, Vc=speed, dR=DISTANCES_M[:, None], dtheta=BEARINGS_RAD)
        surfaces[name] = told
        for output, values in told.items():
            summary[f"{output}_{name}"] = {
                "least": float(values.min()),
                "greatest": float(values.max()),
                "steepest_per_m": _slope(values, DISTANCES_M, 0),
                "steepest_per_rad": _slope(values, BEARINGS_RAD, 1),
            }
    return {
        "summary": summary,
        "distances_m": DISTANCES_M,
        "bearings_rad": BEARINGS_RAD,
        "surfaces": surfaces,
    }


def _slope(values: np.ndarray[Any, Any], along: np.ndarray[Any, Any], axis: int) -> float:
    return float((np.abs(np.diff(values, axis=axis)) / (along[1] - along[0])).max())
