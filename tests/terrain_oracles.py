"""Terrain anew from the formulas in the docstrings, in numpy float32. Nothing here uses Cairn."""

import math

import numpy as np

from plan_oracles import MOVES, ROOT2, Case

F = np.float32
LOG2E = 1.4426950408889634

P3AT = {
    "mass_kg": 12.0,
    "payload_kg": 0.0,
    "gravity_mps2": 9.80665,
    "rolling_resistance": 0.08,
    "roughness_resistance": 1.0,
    "max_speed_mps": 0.7,
    "roughness_slowdown": 5.0,
    "drive_power_w": 20.0,
    "drive_efficiency": 0.5,
    "hotel_power_w": 30.0,
    "max_climb_rad": math.atan(0.35),
    "max_descent_rad": math.atan(0.35),
    "max_roll_rad": math.atan(0.35),
    "max_roughness": math.inf,
}
TOBLER = {
    "off_path": False,
    "max_climb_rad": math.pi / 4,
    "max_descent_rad": math.pi / 4,
    "max_roll_rad": math.pi / 2,
    "max_roughness": math.inf,
}


def p3at_time(p, run, z, rough):
    weight = (p["mass_kg"] + p["payload_kg"]) * p["gravity_mps2"]
    drag = F(weight * p["rolling_resistance"] * run)
    rough_drag = F(0.5 * weight * p["roughness_resistance"] * run)
    pace = F(1.0 / p["max_speed_mps"])
    rough_pace = F(0.5 * p["roughness_slowdown"] / p["max_speed_mps"])
    work = F(weight) * z + (drag + rough_drag * rough)
    length = np.sqrt(F(run * run) + z * z)
    time = np.maximum(length * (pace + rough_pace * rough), work * F(1.0 / p["drive_power_w"]))
    return work, time


def p3at_energy(p, run, z, rough):
    work, time = p3at_time(p, run, z, rough)
    effort = F(1.0 / p["drive_efficiency"])
    return F(p["hotel_power_w"]) * time + effort * np.maximum(work, F(0))


def exp2(x):
    """The polynomial on [-1/2, 1/2] and a power of two, every step rounded to float32."""
    x = np.minimum(x, F(126))
    n = np.rint(x)
    f = x - n
    value = np.full_like(f, F(0.001326473))
    for c in (0.009671513, 0.055507336, 0.24022242, 0.693147, 1.0):
        value = value * f + F(c)
    return np.ldexp(value, n.astype(int))


def tobler(p, run, z, rough):
    factor = 0.6 if p["off_path"] else 1.0
    slope = z * F(3.5 * LOG2E / run) + F(3.5 * LOG2E * 0.05)
    return F(0.6 * run / factor) * exp2(np.abs(slope))


PRICES = {
    "p3at_energy": p3at_energy,
    "p3at_time": lambda *given: p3at_time(*given)[1],
    "tobler": tobler,
}


def shifted(grid, down, right, border=2):
    """`grid[row + down, col + right]` for every cell, NaN beyond the edge."""
    rows, cols = grid.shape
    padded = np.pad(grid, border, constant_values=np.nan)
    return padded[border + down : border + down + rows, border + right : border + right + cols]


def roughness(heights, size):
    total, pairs = np.zeros(heights.shape, F), np.zeros(heights.shape, F)
    for down, right in [(0, 1), (1, 1), (1, 0), (1, -1)]:
        e = heights - (shifted(heights, -down, -right) + shifted(heights, down, right)) * F(0.5)
        known = ~np.isnan(e)
        total = total + np.where(known, e * e, F(0))
        pairs = pairs + known.astype(F)
    rough = np.sqrt(total / np.maximum(pairs, F(1))) * F(1.0 / size)
    return np.where(np.isnan(heights), F(np.nan), rough).astype(F)


def bound(angle, run):
    return F(np.finfo(F).max) if angle >= math.pi / 2 else F(math.tan(angle) * run)


def across(code, h, n, m):
    """Slope across a move, as a difference of heights two (√2 if diagonal) cells apart."""
    down, right = MOVES[code]
    if code % 2:
        left, other = shifted(h, down, 0), shifted(h, 0, right)
    else:
        left = (shifted(h, right, -down) + shifted(h, down + right, right - down)) * F(0.5)
        other = (shifted(h, -right, down) + shifted(h, down - right, right + down)) * F(0.5)
    middle = (n + m) * F(0.5)
    one_side = np.where(np.isnan(left), middle - other, left - middle)
    one_side = np.where(np.isnan(one_side), F(0), F(2) * one_side)
    both = ~np.isnan(left) & ~np.isnan(other)
    return np.abs(np.where(both, left - other, one_side))


def terrain_links(elevation, size, kind, p, goals, rough=None, corner_cutting=False):
    """(case with the float32 cost of every allowed move, their codes, masks)."""
    heights = np.asarray(elevation).astype(F)
    rough = roughness(heights, size) if rough is None else np.asarray(rough).astype(F)
    with np.errstate(invalid="ignore"):
        usable = ~np.isnan(heights) & (rough <= F(p["max_roughness"]))
    h = np.where(usable, heights, F(np.nan)).astype(F)
    rows, cols = h.shape
    cells = np.arange(h.size).reshape(rows, cols)
    masks, found = np.zeros(h.shape, np.uint8), []
    for code, (down, right) in enumerate(MOVES):
        run = size * ROOT2 if code % 2 else size
        m = shifted(h, down, right)
        rise = m - h
        with np.errstate(invalid="ignore"):
            allowed = (rise <= bound(p["max_climb_rad"], run)) & (
                -rise <= bound(p["max_descent_rad"], run)
            )
            width = run if code % 2 else 2.0 * run
            allowed &= across(code, h, h, m) <= bound(p["max_roll_rad"], width)
        if code % 2 and not corner_cutting:
            allowed &= ~np.isnan(shifted(h, down, 0)) & ~np.isnan(shifted(h, 0, right))
        masks |= allowed.astype(np.uint8) << code
        tails = cells[allowed]
        both = (rough + shifted(rough, down, right)).astype(F)[allowed]
        prices = PRICES[kind](p, run, rise[allowed].astype(F), both)
        assert prices.dtype == F
        found.append((tails, tails + down * cols + right, np.full(len(tails), code), prices))
    tails, heads, codes, prices = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.lexsort((codes, tails))
    flat = [row * cols + col for row, col in goals]
    return (
        Case(h.size, tails[order], heads[order], prices[order], flat),
        codes[order],
        masks,
    )


def relaxed(case, number):
    """Rounds of Bellman's equation until nothing changes, in `number`: for large grids."""
    values = np.full(case.nodes, np.inf, number)
    values[case.goals] = 0
    while True:
        after = values.copy()
        np.minimum.at(after, case.tails, values[case.heads] + case.costs)
        if np.array_equal(after, values):
            return values
        values = after
