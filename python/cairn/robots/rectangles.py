"""Rectangles on the ground: covering a grid's cells with few of them, distances, rays.

A set of n rectangles is an array (n, 6): centre x, y, half length, half width, cos and sin of the
heading; metres, one frame for all.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def rectangle(x: float, y: float, length_m: float, width_m: float, heading: float) -> Floats:
    """One rectangle, (6,)."""
    return np.array([x, y, length_m / 2, width_m / 2, math.cos(heading), math.sin(heading)])


def covering(cells: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Few rectangles of cells that together are exactly the true ones; they may overlap.

    Greedy: from each cell not yet covered, in row order, the larger of the two rectangles that
    grow first along the row or first along the column; then those are dropped that the others
    cover already.

    Returns:
        (n, 4): first row, first column, row after the last, column after the last.
    """
    rows, cols = cells.shape
    covers = np.zeros((rows, cols), dtype=np.int32)
    found: list[tuple[int, int, int, int]] = []
    for row, col in np.argwhere(cells):
        if covers[row, col]:
            continue
        along = _grown(cells, int(row), int(col))
        c0, r0, c1, r1 = _grown(cells.T, int(col), int(row))
        across = (r0, c0, r1, c1)
        best = max(along, across, key=lambda r: int((covers[r[0] : r[2], r[1] : r[3]] == 0).sum()))
        covers[best[0] : best[2], best[1] : best[3]] += 1
        found.append(best)
    kept = []
    for r0, c0, r1, c1 in sorted(found, key=lambda r: (r[2] - r[0]) * (r[3] - r[1])):
        if (covers[r0:r1, c0:c1] > 1).all():
            covers[r0:r1, c0:c1] -= 1
        else:
            kept.append((r0, c0, r1, c1))
    return np.array(sorted(kept), dtype=np.int64).reshape(-1, 4)


def _grown(cells: NDArray[np.bool_], row: int, col: int) -> tuple[int, int, int, int]:
    """The rectangle about a cell that is as wide as its row allows, then as high as that allows."""
    line = cells[row]
    left = np.flatnonzero(~line[:col])
    right = np.flatnonzero(~line[col:])
    c0 = int(left[-1]) + 1 if left.size else 0
    c1 = col + int(right[0]) if right.size else cells.shape[1]
    full = np.all(cells[:, c0:c1], axis=1)
    below = np.flatnonzero(~full[:row])
    above = np.flatnonzero(~full[row:])
    r0 = int(below[-1]) + 1 if below.size else 0
    r1 = row + int(above[0]) if above.size else cells.shape[0]
    return r0, c0, r1, c1


def lattice_corners(cells: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lattice points (row, col) where the outline of the true cells bends, (n, 2)."""
    padded = np.pad(cells, 1).astype(np.int8)
    a, b, c, d = padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]
    count = a + b + c + d
    return np.argwhere((count % 2 == 1) | ((count == 2) & (a == d)))


def corners(rectangles: Floats) -> Floats:
    """The four corners of each, (n, 4, 2), counter-clockwise from front left."""
    x, y, hl, hw, c, s = rectangles.T
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]], dtype=np.float64)
    along, aside = hl[:, None] * signs[:, 0], hw[:, None] * signs[:, 1]
    return np.stack(
        [
            x[:, None] + c[:, None] * along - s[:, None] * aside,
            y[:, None] + s[:, None] * along + c[:, None] * aside,
        ],
        axis=-1,
    )


def distances(one: Floats, others: Floats) -> Floats:
    """Exact distance between a rectangle (6,) and each of others (n, 6); 0 where they overlap."""
    x, y, hl, hw, c, s = others.T
    dx, dy = one[0] - x, one[1] - y
    # The one in each other's frame, and each other in the one's.
    u, v = c * dx + s * dy, c * dy - s * dx
    rc, rs = c * one[4] + s * one[5], c * one[5] - s * one[4]
    u2, v2 = -(one[4] * dx + one[5] * dy), -(one[4] * dy - one[5] * dx)
    al, aw, cc, ss = one[2], one[3], np.abs(rc), np.abs(rs)
    apart = (
        (np.abs(u) >= hl + al * cc + aw * ss)
        | (np.abs(v) >= hw + al * ss + aw * cc)
        | (np.abs(u2) >= al + hl * cc + hw * ss)
        | (np.abs(v2) >= aw + hl * ss + hw * cc)
    )
    best = np.full(len(others), np.inf)
    for p, q in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        # A corner of the one against each other, then a corner of each other against the one.
        ex = np.maximum(np.abs(u + rc * (p * al) - rs * (q * aw)) - hl, 0)
        ey = np.maximum(np.abs(v + rs * (p * al) + rc * (q * aw)) - hw, 0)
        fx = np.maximum(np.abs(u2 + rc * (p * hl) + rs * (q * hw)) - al, 0)
        fy = np.maximum(np.abs(v2 - rs * (p * hl) + rc * (q * hw)) - aw, 0)
        best = np.minimum(best, np.minimum(ex * ex + ey * ey, fx * fx + fy * fy))
    return np.where(apart, np.sqrt(best), 0.0)


def cast(origins: Floats, directions: Floats, rectangles: Floats) -> tuple[Floats, Floats]:
    """Where rays meet rectangles first.

    Args:
        origins: (m, 2) [m].
        directions: unit vectors, (m, 2).
        rectangles: (n, 6).

    Returns:
        Distance (m,) [m], inf where nothing is met and 0 from within; and the cosine of the angle
        between ray and the face's normal, (m,), 1 where nothing is met.
    """
    if not len(rectangles):
        return np.full(len(origins), np.inf), np.ones(len(origins))
    x, y, hl, hw, c, s = rectangles.T
    ox, oy = origins[:, :1] - x, origins[:, 1:] - y
    px, py = c * ox + s * oy, c * oy - s * ox
    dx = directions[:, :1] * c + directions[:, 1:] * s
    dy = directions[:, 1:] * c - directions[:, :1] * s
    dx = np.where(np.abs(dx) < 1e-12, 1e-12, dx)
    dy = np.where(np.abs(dy) < 1e-12, 1e-12, dy)
    ax, ay = -px / dx, -py / dy
    wx, wy = np.abs(hl / dx), np.abs(hw / dy)
    enter_x, enter_y = ax - wx, ay - wy
    enter = np.maximum(enter_x, enter_y)
    leave = np.minimum(ax + wx, ay + wy)
    entry = np.where((leave >= enter) & (leave >= 0), np.maximum(enter, 0.0), np.inf)
    nearest = entry.argmin(axis=1)
    rows = np.arange(len(origins))
    distance = entry[rows, nearest]
    cosine = np.where(
        enter_x[rows, nearest] >= enter_y[rows, nearest],
        np.abs(dx[rows, nearest]),
        np.abs(dy[rows, nearest]),
    )
    return distance, np.where(np.isfinite(distance), np.minimum(cosine, 1.0), 1.0)
