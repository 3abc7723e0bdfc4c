"""The any-angle finish against an oracle in exact fractions that shares no idea with it."""

import itertools
import json
from dataclasses import dataclass
from decimal import Decimal, getcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cairn

getcontext().prec = 60
INF = np.inf


@dataclass
class Place:
    """A world of cells of 1 m at the origin: world points are grid coordinates, unrounded."""

    costs: np.ndarray | None
    occupancy: np.ndarray
    resolution_m: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)


def inside(a, b, low, high):
    """Part (t0, t1) of the segment a..b in the closed box low..high; None if there is none."""
    t0, t1 = Fraction(0), Fraction(1)
    for start, end, least, most in zip(a, b, low, high, strict=True):
        step = end - start
        if step == 0:
            if not least <= start <= most:
                return None
            continue
        enters, leaves = sorted([(least - start) / step, (most - start) / step])
        t0, t1 = max(t0, enters), min(t1, leaves)
    return (t0, t1) if t0 <= t1 else None


def pieces(a, b, shape):
    """(row, col, part) of every closed cell that the segment a..b, points (u, v), touches."""
    (u0, u1), (v0, v1) = sorted([a[0], b[0]]), sorted([a[1], b[1]])
    for row in range(max(0, int(v0) - 1), min(shape[0], int(v1) + 2)):
        for col in range(max(0, int(u0) - 1), min(shape[1], int(u1) + 2)):
            part = inside(a, b, (col, row), (col + 1, row + 1))
            if part is not None:
                yield row, col, part


def passes(a, b, costs, corner_cutting):
    """Between its ends, the segment touches no blocked cell, or with corner cutting enters none."""
    for row, col, (t0, t1) in pieces(a, b, costs.shape):
        if np.isfinite(costs[row, col]):
            continue
        if corner_cutting:
            mid = [p + (q - p) * (t0 + t1) / 2 for p, q in zip(a, b, strict=True)]
            if t0 < t1 and col < mid[0] < col + 1 and row < mid[1] < row + 1:
                return False
        elif t0 < 1 and t1 > 0:
            return False
    return True


def price(a, b, costs):
    """The integral of the cost along the segment, to 60 digits; a border costs its dearer side."""
    parts = sorted((part, costs[row, col]) for row, col, part in pieces(a, b, costs.shape))
    total = Fraction(0)
    for part in {part for part, _ in parts if part[0] < part[1]}:
        dearest = max(float(cost) for its_part, cost in parts if its_part == part)
        if dearest == INF:
            return Decimal(INF)
        total += (part[1] - part[0]) * Fraction(dearest)
    square = sum(((q - p) ** 2 for p, q in zip(a, b, strict=True)), Fraction(0))
    length = (Decimal(square.numerator) / Decimal(square.denominator)).sqrt()
    return length * Decimal(total.numerator) / Decimal(total.denominator)


def centres(cells):
    return [(Fraction(2 * int(c) + 1, 2), Fraction(2 * int(r) + 1, 2)) for r, c in cells]


def cost_of(points, costs):
    return sum((price(a, b, costs) for a, b in itertools.pairwise(points)), Decimal(0))


def cheapest(points, costs, corner_cutting):
    """The least cost over all ways that keep some of the points, by every pair of them."""
    best = [Decimal(0)]
    for j in range(1, len(points)):
        best.append(
            min(
                best[i] + price(points[i], points[j], costs)
                for i in range(j)
                if i == j - 1 or passes(points[i], points[j], costs, corner_cutting)
            )
        )
    return best[-1]


@st.composite
def grids(draw):
    """Costs inf blocked, on free/blocked, few-valued and wide ranges; with a free goal."""
    rows, cols = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    kind = draw(st.sampled_from(["free", "few", "wide"]))
    seed = draw(st.integers(0, 2**32))
    rng = np.random.default_rng(seed)
    if kind == "free":
        costs = np.ones((rows, cols))
    elif kind == "few":
        costs = rng.integers(1, 4, (rows, cols)).astype(float)
    else:
        costs = 10.0 ** rng.uniform(-3, 3, (rows, cols))
    costs = costs.astype(np.float32).astype(float)
    costs[rng.random((rows, cols)) < draw(st.sampled_from([0.0, 0.1, 0.3]))] = INF
    goal = (int(rng.integers(rows)), int(rng.integers(cols)))
    costs[goal] = 1.0
    return costs, goal, kind == "free", rng


def planned(costs, goal, is_free, corner_cutting, rng):
    if is_free and rng.random() < 0.7:
        return cairn.plan_grid(np.isfinite(costs), goal, corner_cutting=corner_cutting)
    precision = rng.choice(["f32", "f64"])
    return cairn.plan_grid(costs, goal, corner_cutting=corner_cutting, precision=precision)


@settings(deadline=None)
@given(grids(), st.booleans())
def test_cells_kept_are_cheapest_and_every_segment_passes(made, corner_cutting):
    costs, goal, is_free, rng = made
    field = planned(costs, goal, is_free, corner_cutting, rng)
    reached = np.argwhere(np.isfinite(field.cost_to_go))
    for start in reached[rng.integers(0, len(reached), 4)]:
        path, short = field.path(start), field.path(start, any_angle=True)
        assert short.dtype == path.dtype
        np.testing.assert_array_equal(short[[0, -1]], path[[0, -1]])
        where = [path.tolist().index(cell) for cell in short.tolist()]
        assert where == sorted(set(where))
        points, kept = centres(path), centres(short)
        for a, b in itertools.pairwise(kept):
            assert passes(a, b, costs, corner_cutting)
        slack = 1 + Decimal("1e-11")
        assert cost_of(kept, costs) <= cost_of(points, costs) * slack
        if len(points) <= 17:  # every link back is tried
            assert cost_of(kept, costs) <= cheapest(points, costs, corner_cutting) * slack


@settings(deadline=None)
@given(grids(), st.booleans(), st.integers(0, 3))
def test_points_kept_are_no_dearer_and_every_segment_passes(made, corner_cutting, fine):
    costs, goal, is_free, rng = made
    occupancy = (~np.isfinite(costs)).astype(np.uint8)
    world = Place(None if is_free else costs, occupancy)

    def point(cell):
        """Anywhere in a cell, often on its borders and corners."""
        row, col = cell
        return (col + rng.integers(0, 2**fine) / 2**fine, row + rng.integers(0, 2**fine) / 2**fine)

    target = point(goal)
    field = cairn.plan(world, target, corner_cutting=corner_cutting, precision="f64")
    reached = np.argwhere(np.isfinite(field.cost_to_go))
    for cell in reached[rng.integers(0, len(reached), 4)]:
        start = point(cell)
        path, short = field.path(start), field.path(start, any_angle=True)
        assert short[0].tolist() == list(start)
        assert short[-1].tolist() == list(target)
        assert (np.abs(np.diff(short, axis=0)).sum(axis=1) > 0).all()
        points, kept = ([tuple(map(Fraction, p)) for p in way.tolist()] for way in (path, short))
        links = list(itertools.pairwise(points))
        clipped = not all(passes(a, b, costs, corner_cutting) for a, b in links)
        if len(np.unique(np.floor(path), axis=0)) > 1:
            for a, b in itertools.pairwise(kept):
                assert passes(a, b, costs, corner_cutting)
        if not clipped:
            slack = 1 + Decimal("1e-11")
            assert cost_of(kept, costs) <= cost_of(points, costs) * slack


@settings(deadline=None)
@given(st.integers(1, 300), st.integers(1, 300), st.integers(0, 2**32), st.booleans())
def test_nothing_in_the_way_leaves_one_segment(rows, cols, seed, corner_cutting):
    rng = np.random.default_rng(seed)
    (a, b), (c, d) = rng.integers(0, [rows, cols], (2, 2)).tolist()
    field = cairn.plan_grid(np.ones((rows, cols), bool), (a, b), corner_cutting=corner_cutting)
    short = field.path((c, d), any_angle=True).tolist()
    assert short == ([[a, b]] if (a, b) == (c, d) else [[c, d], [a, b]])
    world = Place(np.full((rows, cols), 3.5, np.float32), np.zeros((rows, cols), np.uint8))
    world.resolution_m, world.origin = 0.05, tuple(rng.uniform(-9, 9, 3))
    place = cairn.World(world.occupancy, world.resolution_m, world.origin)
    start, goal = (place.world_from_grid(rng.random(2) * (cols, rows) * 0.05) for _ in range(2))
    if place.contains(start) and place.contains(goal):
        for with_costs in (world, place):
            path = cairn.plan(with_costs, goal).path(start, any_angle=True)
            np.testing.assert_array_equal(path, [start, goal])


def test_a_path_round_a_corner_turns_at_the_corner():
    free = np.ones((40, 60), bool)
    free[:30, 30] = False
    field = cairn.plan_grid(free, (2, 55))
    short = field.path((1, 4), any_angle=True)
    assert short.tolist() == [[1, 4], [30, 29], [30, 31], [2, 55]]
    assert field.path((3, 30), any_angle=True) is None


def test_dear_ground_is_crossed_no_further_than_it_pays():
    costs = np.ones((31, 61))
    costs[:, 30] = 8.0
    costs[25, 30] = 1.0  # a gate
    field = cairn.plan_grid(costs, (15, 60), precision="f64")
    near, far = (field.path(start, any_angle=True) for start in [(15, 29), (25, 0)])
    assert near.tolist() == [[15, 29], [15, 60]]  # 7 more through the strip, 20 more by the gate
    assert any(cell == [25, 30] for cell in far.tolist()) or len(far) == 3
    assert cost_of(centres(far), costs) < Decimal(field.cost_to_go[25, 0])


def test_the_finish_is_for_fields_of_every_arithmetic():
    free = np.random.default_rng(5).random((60, 70)) > 0.2
    free[30, 30] = True
    found = [
        cairn.plan_grid(free, (30, 30), **options)
        for options in ({}, {"steps": "100/141"}, {"precision": "f32"}, {"precision": "f64"})
    ]
    start = tuple(np.argwhere(np.isfinite(found[0].cost_to_go))[0])
    for field in found:
        path, short = field.path(start), field.path(start, any_angle=True)
        lengths = [np.hypot(*np.diff(way, axis=0).T).sum() for way in (path, short)]
        assert lengths[1] < lengths[0]
    float_grid = cairn.plan_grid(np.where(free, 1.0, np.inf), (30, 30), precision="f32")
    same = found[2].path(start, any_angle=True)
    np.testing.assert_array_equal(float_grid.path(start, any_angle=True), same)


def test_a_grid_changed_after_the_plan_does_not_change_its_paths():
    costs = np.ones((20, 20))
    free = np.ones((20, 20), bool)
    fields = [
        cairn.plan_grid(costs, (0, 0)),
        cairn.plan_grid(costs, (0, 0), precision="f64"),
        cairn.plan_grid(free, (0, 0)),
    ]
    costs[5:15, 5:15], free[5:15, 5:15] = np.inf, False
    for field in fields:
        assert field.path((19, 18), any_angle=True).tolist() == [[19, 18], [0, 0]]


@pytest.mark.parametrize("flag", [1, 0, "yes", None])
def test_any_angle_is_yes_or_no(flag):
    field = cairn.plan_grid(np.ones((3, 3), bool), (0, 0))
    with pytest.raises(cairn.errors.UnknownPlanOption, match="any_angle"):
        field.path((2, 2), any_angle=flag)


def test_a_field_of_costs_per_move_has_no_price_at_any_angle_and_says_so():
    model = cairn.terrain.Tobler()
    field = cairn.plan_terrain(np.zeros((4, 5)), 1.0, (0, 0), model)
    assert len(field.path((3, 4))) == 5
    with pytest.raises(cairn.errors.AnyAngleNotPriced):
        field.path((3, 4), any_angle=True)


def test_the_plan_command_shortens_the_path_when_asked(command):
    world = cairn.maps.load("office")
    asked = ("plan", "office", "--goal", next(iter(world.goals)), "--start", "1.4,16.8", "--json")
    straight = json.loads(command(*asked, "--any-angle")[1])
    stepped = json.loads(command(*asked)[1])
    assert straight["path_m"][0] == stepped["path_m"][0]
    assert straight["path_m"][-1] == stepped["path_m"][-1]
    assert len(straight["path_m"]) < len(stepped["path_m"]) / 10
    assert straight["summary"]["path_length_m"] < stepped["summary"]["path_length_m"]
