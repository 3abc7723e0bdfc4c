"""Worlds like BARN's, drawn from a seed by cellular automata, as many as wanted [Perille20].

A field of 30 × 30 posts of 0.15 m lies behind a pen with three walls in which the robot starts.
Cells are filled at random and smoothed a few times: more than four filled neighbours fill a cell,
fewer than two empty it. What a disc of 0.375 m can cross is kept, anything else drawn again. As in
BARN, the length that the score uses is that of the shortest way between two places drawn from the
field's first and last row, and straight from the start to the one and from the other to the goal.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import cairn
from cairn.experiments.nav.worlds import NavWorld
from cairn.robots.robot import Pose

CELLS, CELL_M = 30, 0.15
X0, Y0 = -4.425, 5.175
"""Middle of the first cell of the field."""
PEN_ROWS = 34
START, GOAL = Pose(-2.25, 3.0, math.pi / 2), (-2.25, 13.0)
FILLS = (0.15, 0.20, 0.25, 0.30)
SMOOTHINGS = (2, 3, 4)
CLEARANCE_M = 0.375
FINE_M = 0.075

Cells = NDArray[np.bool_]


def generated(number: int, seed: int = 1) -> NavWorld:
    """World `number` of the series of `seed`; the same for ever.

    Args:
        number: any, from 0.
        seed: of the series.
    """
    random = np.random.default_rng([seed, number, 7])
    # Drawn once, so that dense worlds, which fail more often, do not become rare.
    fill, smoothings = random.choice(FILLS), int(random.choice(SMOOTHINGS))
    while True:
        filled = random.random((CELLS, CELLS)) < fill
        filled[:, 0] = filled[:, -1] = True
        field = smoothed(filled, smoothings)
        way = _drawn_way(field, random)
        if way is not None:
            break
    circles = posts(field)
    steps = np.diff(np.vstack([START[:2], way, GOAL]), axis=0)
    return NavWorld(
        name=f"generated_{number}",
        circles=circles,
        boxes=np.zeros((0, 5)),
        start=START,
        goal=GOAL,
        path_length_m=float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        reference_path=np.vstack([START[:2], way, GOAL]),
    )


def smoothed(filled: Cells, times: int) -> Cells:
    """Let a cellular automaton run; beyond the left and right edge all is filled, else empty."""
    for _ in range(times):
        padded = np.pad(filled.astype(int), 1)
        padded[:, 0] = padded[:, -1] = 1
        around = sum(
            padded[1 + dr : CELLS + 1 + dr, 1 + dc : CELLS + 1 + dc]
            for dr in (-1, 0, 1)
            for dc in (-1, 0, 1)
            if dr or dc
        )
        filled = (filled | (around > 4)) & (around >= 2)
    return filled


def posts(field: Cells) -> NDArray[np.float64]:
    """Posts (n, 3) of a field, its two side walls, and the pen before it."""
    field = field.copy()
    field[:, 0] = field[:, -1] = True
    rows, cols = np.nonzero(field)
    x = X0 + CELL_M * np.arange(CELLS)
    pen_y = Y0 - CELL_M * np.arange(1, PEN_ROWS + 1)
    xy = np.vstack(
        [
            np.column_stack([x[cols], Y0 + CELL_M * rows]),
            np.column_stack([np.full(PEN_ROWS, x[0]), pen_y]),
            np.column_stack([np.full(PEN_ROWS, x[-1]), pen_y]),
            np.column_stack([x[1:-1], np.full(CELLS - 2, pen_y[-1])]),
        ]
    )
    return np.column_stack([xy, np.full(len(xy), CELL_M / 2)])


def _drawn_way(field: Cells, random: np.random.Generator) -> NDArray[np.float64] | None:
    """Shortest way (n, 2) from cell to cell between two ends drawn; None where none joins them."""
    walled = field.copy()
    walled[:, 0] = walled[:, -1] = True
    reach = math.ceil((CLEARANCE_M + CELL_M / 2) / CELL_M - 1e-9)
    padded = np.pad(walled, reach)
    free = np.ones((CELLS, CELLS), bool)
    for dr in range(-reach, reach + 1):
        for dc in range(-reach, reach + 1):
            if CELL_M * math.hypot(dr, dc) < CLEARANCE_M + CELL_M / 2 - 1e-9:
                rows, cols = reach + dr, reach + dc
                free &= ~padded[rows : rows + CELLS, cols : cols + CELLS]
    # The pen's side walls go on below the first row, as the sides of the field do.
    goals = np.flatnonzero(free[-1])
    if not len(goals):
        return None
    way = cairn.plan_grid(free, goal=(CELLS - 1, int(random.choice(goals))), threads=1)
    starts = np.flatnonzero(np.isfinite(way.cost_to_go[0]))
    if not len(starts):
        return None
    cells = way.path((0, int(random.choice(starts))))
    assert cells is not None  # the cost-to-go is finite there
    return np.array([X0, Y0]) + CELL_M * cells[:, ::-1]


def shortest_way(circles: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Shortest way (n, 2) of a disc through the field, from its first row to its last; or None.

    Args:
        circles: (n, 3) posts of the world.
    """
    x = np.arange(X0, X0 + CELL_M * (CELLS - 1) + FINE_M / 2, FINE_M)
    inside = round(CELL_M * (CELLS - 1) / FINE_M) + 1
    y = Y0 + FINE_M * np.arange(inside)
    free = np.ones((len(y), len(x)), bool)
    for cx, cy, radius in circles:
        reach = CLEARANCE_M + radius
        rows = slice(*np.searchsorted(y, (cy - reach, cy + reach)))
        cols = slice(*np.searchsorted(x, (cx - reach, cx + reach)))
        away = np.hypot(x[cols] - cx, (y[rows] - cy)[:, None])
        free[rows, cols] &= away >= reach - 1e-9
    goals = [(inside - 1, int(col)) for col in np.flatnonzero(free[-1])]
    if not goals:
        return None
    field = cairn.plan_grid(free, goal=goals)
    ahead = FINE_M * field.cost_to_go[0] + np.hypot(x - START.x, y[0] - START.y)
    if not np.isfinite(ahead).any():
        return None
    col = int(ahead.argmin())
    cells = field.path((0, col))
    assert cells is not None  # the cost-to-go is finite there
    return np.column_stack([x[cells[:, 1]], y[cells[:, 0]]])
