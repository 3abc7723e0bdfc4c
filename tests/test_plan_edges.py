"""Every row of docs/planner-edges.md; and shapes, maps and goals that solvers in tiles trip over.

Fields are held against scipy's Dijkstra where its float64 sums are exact, and always against a
certificate that leaves only one field possible: no link improves it, every pointer achieves it.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import cairn
from cairn import _brain
from plan_oracles import (
    Case,
    grid_links,
    lowest_codes,
    mean_price,
    scipy_cost_to_go,
    step_price,
    textbook_cost_to_go,
)

F32_MAX = float(np.finfo(np.float32).max)
F32_LEAST = float(np.finfo(np.float32).smallest_subnormal)
INF = np.inf

# Every way to have the same field worked out; a new option of `plan_grid` is one more line.
ENGINES = {
    "default": {},
    "one thread": {"threads": 1},
    "two threads": {"threads": 2},
    "three threads": {"threads": 3},
    "portable, two threads": {"simd": "portable", "threads": 2},
    **{level: {"simd": level} for level in _brain.simd_levels()},
}

ARITHMETICS = {
    "steps": (None, step_price(985, 1393), {}),
    "paper's steps": (None, step_price(100, 141), {"steps": "100/141"}),
    "f32": (np.float32, mean_price(np.float32), {}),
    "f64": (np.float64, mean_price(np.float64), {"precision": "f64"}),
}


# ---- the one field possible ---


def check_field(costs, goals, corner_cutting, arithmetic, engine="default", oracle=None):
    """Plan; hold the field to its certificate, and to `oracle(case, number)` if one is given."""
    number, price, options = ARITHMETICS[arithmetic]
    given = costs.astype(number) if number else np.isfinite(costs)
    field = cairn.plan_grid(
        given, goals, corner_cutting=corner_cutting, **options, **ENGINES[engine]
    )
    tails, heads, codes, prices = grid_links(
        costs.astype(number) if number else costs, corner_cutting, price
    )
    flat = [int(row) * costs.shape[1] + int(col) for row, col in goals]
    case = Case(costs.size, tails, heads, prices, flat)
    values = field.native.ravel().astype(number or float)
    if not number:
        values[field.native.ravel() == np.iinfo(field.native.dtype).max] = INF
    assert (values[flat] == 0).all()
    assert not np.isnan(values).any()
    with np.errstate(over="ignore", invalid="ignore"):
        through = (values[heads] + prices).astype(values.dtype)
    best = np.full(case.nodes, INF, values.dtype)
    np.minimum.at(best, tails, through)
    best[flat] = 0
    np.testing.assert_array_equal(values, best)
    np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, codes, values))
    used = field.next_node.ravel()[tails] == codes
    assert (values[heads[used]] < values[tails[used]]).all()  # so no pointers cycle
    if oracle is not None:
        np.testing.assert_array_equal(values, oracle(case, number or float).astype(values.dtype))
    return field


def scipy_oracle(case, _):
    return scipy_cost_to_go(case)


def random_costs(rng, shape, arithmetic):
    if ARITHMETICS[arithmetic][0] is None:
        return np.ones(shape)
    if rng.random() < 0.5:
        return rng.integers(1, 5, shape).astype(float)  # ties
    return (rng.random(shape) + 0.01).astype(np.float32).astype(float)


# ---- shapes and maps that tiles, lanes and words end in ---

SIZES = [1, 2, 3, 7, 15, 16, 17, 31, 33, 63, 64, 65, 66, 127, 128, 129]


def mesh(shape):
    return np.indices(shape)


def open_map(rng, shape):
    return np.ones(shape, bool)


def scattered(rng, shape):
    return rng.random(shape) > rng.choice([0.05, 0.2, 0.35, 0.5])


def checkerboard(rng, shape):
    """Diagonal moves only, and with corner cutting only."""
    return mesh(shape).sum(axis=0) % 2 == rng.integers(2)


def tiles_that_meet_at_corners(rng, shape):
    """Blocks of free cells that touch at their corners alone."""
    row, col = mesh(shape) // rng.choice([4, 16, 64])
    return (row + col) % 2 == rng.integers(2)


def corridors_along_borders(rng, shape):
    """Free rows and columns on one side of every border of a block, or on the other, or on both."""
    side = int(rng.choice([8, 16, 64]))
    wanted = rng.choice([0, 1, 2])
    kept = {0: [0], 1: [side - 1], 2: [side - 1, 0]}[int(wanted)]
    row, col = mesh(shape) % side
    return np.isin(row, kept) | np.isin(col, kept)


def walls_along_borders(rng, shape):
    """Walls on the borders of blocks with few holes, most of them beside a corner."""
    side = int(rng.choice([8, 16, 64]))
    row, col = mesh(shape)
    free = (row % side != side - 1) & (col % side != side - 1)
    near = np.isin(row % side, [0, side - 2, side - 1]) & np.isin(
        col % side, [0, side - 2, side - 1]
    )
    return free | (near & (rng.random(shape) < 0.5)) | (rng.random(shape) < 0.02)


def sealed_pockets(rng, shape):
    """Rings of wall around cells that nobody can reach, some larger than a tile."""
    free = np.ones(shape, bool)
    for _ in range(6):
        top, left = rng.integers(-4, shape[0]), rng.integers(-4, shape[1])
        height, width = rng.integers(2, 80, 2)
        row, col = mesh(shape)
        inside = (row >= top) & (row <= top + height) & (col >= left) & (col <= left + width)
        core = (row > top) & (row < top + height) & (col > left) & (col < left + width)
        free[inside & ~core] = False
    return free


def serpentine(rng, shape):
    """One corridor to and fro, along rows or columns."""
    turned = bool(rng.integers(2))
    rows, cols = shape[::-1] if turned else shape
    row, col = mesh((rows, cols))
    free = (row % 2 == 0) | (col == np.where(row % 4 == 1, cols - 1, 0))
    return free.T if turned else free


def staircase(rng, shape):
    """A diagonal of single cells, each a corner apart from the next, in a grid of wall."""
    row, col = mesh(shape)
    return (row + col * rng.choice([1, -1])) % rng.choice([5, 16, 63, 64]) == 0


def islands(rng, shape):
    """Nearly all wall: single cells, pairs and diagonal pairs."""
    return rng.random(shape) > 0.9


MAPS = [
    open_map,
    scattered,
    checkerboard,
    tiles_that_meet_at_corners,
    corridors_along_borders,
    walls_along_borders,
    sealed_pockets,
    serpentine,
    staircase,
    islands,
]


def goals_of(rng, free):
    """Free goals: anywhere, at the corners of tiles, many, or all."""
    cells = np.argwhere(free)
    kind = rng.integers(8)
    if kind == 0:
        return [tuple(cell) for cell in cells.tolist()]
    if kind <= 3:
        at_corner = np.isin(cells % 64, [0, 63]).all(axis=1)
        if at_corner.any():
            cells = cells[at_corner]
    count = 1 if kind <= 5 else int(rng.integers(1, 6))
    return [tuple(cell) for cell in cells[rng.integers(0, len(cells), count)].tolist()]


def check_random_map(seed, shape, engine, arithmetic, draw=None):
    rng = np.random.default_rng(seed)
    free = (draw or MAPS[rng.integers(len(MAPS))])(rng, shape)
    costs = np.where(free, random_costs(rng, shape, arithmetic), INF)
    if not free.any():
        costs[rng.integers(shape[0]), rng.integers(shape[1])] = 1.0
    oracle = None if arithmetic == "f32" or rng.random() < 0.5 else scipy_oracle
    corner_cutting = bool(rng.integers(2))
    goals = goals_of(rng, np.isfinite(costs))
    check_field(costs, goals, corner_cutting, arithmetic, engine, oracle)


@pytest.mark.parametrize("rows", SIZES)
def test_fields_of_every_shape_equal_dijkstra(rows):
    for cols in SIZES:
        for number, engine in enumerate(ENGINES):
            arithmetic = list(ARITHMETICS)[(number + rows + cols) % len(ARITHMETICS)]
            check_random_map(1000 * rows + cols, (rows, cols), engine, arithmetic)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("draw", MAPS, ids=lambda draw: draw.__name__)
def test_fields_of_every_kind_of_map_equal_dijkstra_by_every_engine(draw, engine):
    for seed in range(3):
        for arithmetic in ARITHMETICS:
            shape = tuple(
                np.random.default_rng(seed).choice([62, 64, 65, 97, 130, 193], 2).tolist()
            )
            check_random_map(seed, shape, engine, arithmetic, draw)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_field_for_one_start_is_the_whole_field_up_to_its_cost(engine):
    rng = np.random.default_rng(11)
    for number, draw in enumerate(MAPS):
        shape = tuple(rng.choice([1, 17, 64, 65, 130], 2).tolist())
        arithmetic = list(ARITHMETICS)[number % len(ARITHMETICS)]
        number_type, _, options = ARITHMETICS[arithmetic]
        free = draw(rng, shape)
        free[0, 0] = True
        costs = np.where(free, random_costs(rng, shape, arithmetic), INF)
        given = costs.astype(number_type) if number_type else free
        whole = cairn.plan_grid(given, (0, 0), **options)
        for start in np.argwhere(np.ones(shape))[rng.integers(0, free.size, 4)].tolist():
            field = cairn.plan_grid(given, (0, 0), start=start, **options, **ENGINES[engine])
            kept = whole.native <= whole.native[tuple(start)]
            left_out = np.inf if number_type else np.iinfo(whole.native.dtype).max
            np.testing.assert_array_equal(field.native, np.where(kept, whole.native, left_out))
            np.testing.assert_array_equal(field.next_node, np.where(kept, whole.next_node, -1))
            np.testing.assert_array_equal(field.path(start), whole.path(start))
            short = field.path(start, any_angle=True)
            if short is not None:
                assert short[0].tolist() == start
                assert short[-1].tolist() == [0, 0]


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_thousands_of_fields_of_odd_shapes_equal_dijkstra_by_every_engine(arithmetic, engine):
    rng = np.random.default_rng(17)
    for seed in range(1500):
        shape = tuple(int(rng.choice([*SIZES, rng.integers(1, 300)])) for _ in range(2))
        check_random_map(seed, shape, engine, arithmetic)


@pytest.mark.parametrize("engine", ENGINES)
def test_small_fields_equal_a_textbook_dijkstra_in_single_precision(engine):
    rng = np.random.default_rng(3)
    for _ in range(60):
        shape = tuple(rng.choice([1, 2, 5, 15, 17, 18], 2).tolist())
        costs = 10.0 ** rng.uniform(-2, 2, shape)
        costs[rng.random(shape) < 0.2] = INF
        costs.flat[rng.integers(costs.size)] = 1.0
        goals = goals_of(rng, np.isfinite(costs))
        check_field(costs, goals, bool(rng.integers(2)), "f32", engine, textbook_cost_to_go)


# ---- the table ---


def planned(costs, goal, **options):
    return lambda: cairn.plan_grid(costs, goal, **options)


ONE = np.ones((1, 1), bool)
BLOCKED = np.zeros((3, 4), bool)
FREE = np.ones((3, 4), bool)
COSTS = np.ones((3, 4))


def with_cost(value, row=1, col=2, like=COSTS):
    changed = like.copy()
    changed[row, col] = value
    return changed


def as_plain(*kinds):
    """Each array plans as its values in a plain float32 array do."""

    def check():
        for kind in kinds:
            plain = np.array(kind.tolist(), np.float32)
            expected = cairn.plan_grid(plain, (1, 2))
            found = cairn.plan_grid(kind, (1, 2))
            assert found.native.dtype == np.float32, kind.dtype
            np.testing.assert_array_equal(found.native, expected.native)
            np.testing.assert_array_equal(found.next_node, expected.next_node)

    return check


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def strided():
    whole = np.random.default_rng(4).integers(1, 9, (12, 15)).astype(np.float32)
    return [
        whole[::2, ::3],
        whole[::-1, ::-1],
        whole.T,
        np.asfortranarray(whole),
        read_only(whole),
        np.broadcast_to(whole[0], (6, 15)),
        whole.astype(">f4"),
        whole.astype(">f8"),
        whole.astype(">i2"),
        whole.astype(np.float32)[1:-1, 2:-2],
        np.asmatrix(whole),
    ]


def check_one_cell():
    for engine in ENGINES.values():
        field = cairn.plan_grid(ONE, (0, 0), **engine)
        assert (field.cost_to_go.tolist(), field.next_node.tolist()) == ([[0.0]], [[-1]])
        assert field.path((0, 0)).tolist() == [[0, 0]]


def check_same_goal_twice():
    once, twice = cairn.plan_grid(FREE, (1, 2)), cairn.plan_grid(FREE, [(1, 2), (1, 2)])
    np.testing.assert_array_equal(once.native, twice.native)
    np.testing.assert_array_equal(once.next_node, twice.next_node)
    assert twice.goals == [(1, 2), (1, 2)]


def check_every_cell_a_goal():
    for arithmetic in ARITHMETICS:
        for engine in ENGINES:
            costs = np.ones((70, 65))
            goals = [tuple(cell) for cell in np.argwhere(costs > 0).tolist()]
            field = check_field(costs, goals, False, arithmetic, engine)
            assert not field.native.any()
            assert (field.next_node == -1).all()


def check_start_without_a_way():
    free = FREE.copy()
    free[:, 2] = False
    field = cairn.plan_grid(free, (0, 0))
    for start in [(0, 2), (0, 3)]:
        assert field.path(start) is None
        assert field.path(start, any_angle=True) is None
        assert np.isinf(field.cost_to_go[start])
        assert field.next_node[start] == -1


def check_one_row_one_column():
    rng = np.random.default_rng(5)
    for length in [1, 2, 15, 16, 17, 63, 64, 65, 127, 1000]:
        for shape in [(1, length), (length, 1)]:
            for arithmetic in ARITHMETICS:
                costs = random_costs(rng, shape, arithmetic)
                costs[rng.random(shape) < 0.02] = INF
                costs.flat[length // 2] = 1.0
                goal = np.unravel_index(length // 2, shape)
                field = check_field(costs, [goal], bool(rng.integers(2)), arithmetic)
                assert (field.next_node[field.next_node >= 0] % 2 == 0).all()


def check_long_strips():
    for shape in [(1, 1_000_000), (1_000_000, 1)]:
        field = cairn.plan_grid(np.ones(shape, bool), (0, 0))
        np.testing.assert_array_equal(field.native.ravel(), 985 * np.arange(1_000_000))
        assert len(field.path((shape[0] - 1, shape[1] - 1))) == 1_000_000
        end = [shape[0] // 20, shape[1] // 20]
        assert field.path(end, any_angle=True).tolist() == [end, [0, 0]]
    for shape in [(2, 300_000), (300_000, 2)]:
        field = cairn.plan_grid(np.ones(shape, bool), (0, 0))
        rows, cols = mesh(shape)
        least, most = np.minimum(rows, cols), np.maximum(rows, cols)
        np.testing.assert_array_equal(field.native, 1393 * least + 985 * (most - least))


def check_corridor_mazes():
    rng = np.random.default_rng(6)
    for rows, cols in [(1, 33), (3, 65), (5, 64), (65, 3), (129, 67)]:
        free = np.zeros((rows, cols), bool)
        free[::2, ::2] = True  # rooms; then doors, most of them
        free[::2, 1::2] = rng.random(free[::2, 1::2].shape) < 0.8
        free[1::2, ::2] = rng.random(free[1::2, ::2].shape) < 0.6
        for corner_cutting in (False, True):
            costs = np.where(free, 1.0, INF)
            check_field(costs, [(0, 0)], corner_cutting, "steps", oracle=scipy_oracle)


def check_infinite_cost():
    field = cairn.plan_grid(with_cost(INF), (0, 0))
    assert np.isinf(field.native[1, 2])
    assert np.isinf(field.cost_to_go[1, 2])


def check_beyond_single_in_double():
    for value in (1e300, 1e-300):
        costs = np.full((3, 4), value)
        field = cairn.plan_grid(costs, (0, 0), precision="f64")
        np.testing.assert_array_equal(field.native[0], value * np.arange(4))


def check_subnormals():
    rng = np.random.default_rng(7)
    for arithmetic, least in [("f32", F32_LEAST), ("f64", 5e-324)]:
        for shape in [(1, 40), (40, 1), (17, 66), (65, 65)]:
            for engine in ENGINES:
                costs = least * rng.integers(1, 9, shape)
                costs[rng.random(shape) < 0.1] = INF
                costs[0, 0] = least
                field = check_field(costs, [(0, 0)], False, arithmetic, engine)
                assert (field.native.ravel()[1:] > 0).all()


def check_largest_alone():
    for precision, most in [("f32", F32_MAX), ("f64", float(np.finfo(float).max))]:
        costs = np.full((3, 3), INF)
        costs[1, 1] = most
        assert cairn.plan_grid(costs, (1, 1), precision=precision).native[1, 1] == 0
        half = np.full((1, 2), most / 2)
        assert cairn.plan_grid(half, (0, 0), precision=precision).native[0, 1] == most / 2


def check_huge_beside_tiny_precise_enough():
    costs = np.array([[1e9, 1e9, 1.0, 1.0]])
    field = cairn.plan_grid(costs, (0, 0), precision="f64")
    assert np.diff(field.native[0])[-1] == 1.0
    near = cairn.plan_grid(costs, (0, 3))  # the small ones are added first
    np.testing.assert_array_equal(near.native, np.float32([[1.5e9, 5e8, 1.0, 0.0]]))


def check_wide_steps():
    # 985 · 4 360 372 is the last that fits below the mark of no way.
    for length in (4_360_373, 4_360_374):
        field = cairn.plan_grid(np.ones((1, length), bool), (0, 0))
        steps = 985 * np.arange(length, dtype=np.uint64)
        np.testing.assert_array_equal(field.native.ravel(), steps)
        assert np.isfinite(field.cost_to_go).all()
    assert field.native.dtype == np.uint64
    # A serpentine of 4.5 million cells; each turn is two cells more.
    rows = cols = 3001
    row, col = mesh((rows, cols))
    free = (row % 2 == 0) | (col == np.where(row % 4 == 1, cols - 1, 0))
    field = cairn.plan_grid(free, (0, 0))
    along = np.where(row // 2 % 2 == 0, col, cols - 1 - col)
    index = row // 2 * (cols + 1) + np.where(row % 2 == 0, along, cols)
    expected = np.where(free, 985 * index.astype(np.uint64), np.iinfo(np.uint64).max)
    np.testing.assert_array_equal(field.native, expected)
    assert np.isinf(field.cost_to_go[~free]).all()


def check_bools():
    free = np.random.default_rng(8).random((20, 30)) > 0.3
    free[0, 0] = True
    plain = cairn.plan_grid(free, (0, 0))
    whole = np.zeros((40, 90), bool)
    whole[::2, ::3] = free
    for same in [whole[::2, ::3], np.asfortranarray(free), read_only(free), free.tolist()]:
        np.testing.assert_array_equal(cairn.plan_grid(same, (0, 0)).native, plain.native)
    assert plain.native.dtype == np.uint32


def check_integers():
    rng = np.random.default_rng(9)
    kinds = ["u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8"]
    as_plain(*(rng.integers(1, 100, (5, 7)).astype(kind) for kind in kinds))()
    rounded = cairn.plan_grid(np.full((1, 2), 2**25 + 1), (0, 0))
    assert rounded.native[0, 1] == 2.0**25


def check_floats():
    rng = np.random.default_rng(10)
    as_plain(*((rng.random((5, 7)) + 0.5).astype(kind) for kind in ("f2", "f4", "f8", "g")))()
    half = cairn.plan_grid(np.full((1, 2), 65504, "f2"), (0, 0))
    assert half.native[0, 1] == 65504.0


def check_nothing_masked():
    np.testing.assert_array_equal(
        cairn.plan_grid(np.ma.masked_array(COSTS), (0, 0)).native,
        cairn.plan_grid(COSTS, (0, 0)).native,
    )


def check_points_between_cells():
    world = cairn.World(np.zeros((4, 6), np.uint8), 0.5)
    assert cairn.plan(world, (1.0, 0.5)).cost_to_go[1, 2] == 0.0
    assert cairn.plan(world, (0.0, 0.0)).cost_to_go[0, 0] == 0.0
    for outside in [(3.0, 1.0), (1.0, 2.0)]:
        with pytest.raises(cairn.errors.GoalOutsideMap):
            cairn.plan(world, outside)


def check_graph_of_one_node():
    field = cairn.plan_graph([0, 0], [], np.empty(0), 0)
    assert (field.cost_to_go.tolist(), field.next_node.tolist()) == ([0.0], [-1])


def check_links_that_lead_nowhere():
    with_them = cairn.plan_graph([0, 4, 5], [0, 1, 1, 1, 1], [0.0, 5.0, INF, 7.0, 0.0], 1)
    assert with_them.cost_to_go.tolist() == [5.0, 0.0]
    assert with_them.next_node.tolist() == [1, -1]


def check_links_that_cost_nothing():
    ring = [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2), (0, 3)]
    graph = cairn.graph_from_edges(5, ring, np.zeros(len(ring)))
    field = cairn.plan_graph(*graph, 3)
    assert field.cost_to_go.tolist() == [0.0] * 4 + [INF]
    assert [len(field.path(node)) for node in range(4)] == [2, 3, 3, 1] or all(
        field.path(node)[-1] == 3 for node in range(4)
    )


def graph(costs):
    return lambda: cairn.plan_graph([0, 1, 2], [1, 0], costs, 0)


OFFICE = cairn.World(np.zeros((4, 6), np.uint8), 0.5)

ROWS = {
    "0 × 0 cells": [
        planned(np.ones(shape, kind), goal)
        for shape in [(0, 0), (0, 3), (3, 0)]
        for kind in (bool, float)
        for goal in ((0, 0), [], (7, -7))
    ],
    "1 × 1, free": check_one_cell,
    "1 × 1, blocked": [planned(~ONE, (0, 0)), planned([[INF]], (0, 0))],
    "all blocked": [planned(BLOCKED, (1, 2)), planned(np.full((65, 64), INF), (64, 63))],
    "goal blocked": [planned(with_cost(INF), (1, 2)), planned(with_cost(False, like=FREE), (1, 2))],
    "one of several goals blocked": [planned(with_cost(INF), [(0, 0), (1, 2), (2, 2)])],
    "goal outside": [
        planned(grid, goal)
        for grid in (FREE, COSTS)
        for goal in [(3, 0), (0, 4), (-1, 0), (0, -1), (2**40, 0), [(0, 0), (0, 4)]]
    ],
    "no goal": [planned(FREE, []), planned(COSTS, ()), planned(COSTS, np.empty((0, 2), int))],
    "the same goal twice": check_same_goal_twice,
    "every cell a goal": check_every_cell_a_goal,
    "start outside": [
        lambda start=start: cairn.plan_grid(FREE, (0, 0)).path(start)
        for start in [(3, 0), (0, 4), (-1, 0), (0, -1)]
    ],
    "start blocked or cut off": check_start_without_a_way,
    "one row, one column": check_one_row_one_column,
    "1 × 1 000 000": check_long_strips,
    "a maze of 1 × n corridors": check_corridor_mazes,
    "NaN cost": [
        planned(with_cost(np.nan), (0, 0)),
        planned(with_cost(np.nan), (0, 0), precision="f64"),
        planned(with_cost(np.nan, like=np.where(FREE, INF, 1)), (0, 0)),
    ],
    "negative cost": [planned(with_cost(value), (0, 0)) for value in (-1.0, -1e-40, -INF)],
    "zero cost": [planned(with_cost(value), (0, 0)) for value in (0.0, -0.0)]
    + [planned(with_cost(0).astype("u1"), (0, 0)), planned(with_cost(0).astype("i8"), (0, 0))],
    "infinite cost": check_infinite_cost,
    "a finite cost beyond single precision": [
        planned(with_cost(value), (0, 0)) for value in (1e300, 3.5e38, 1e-60, 1e-46)
    ],
    'the same with `precision="f64"`': check_beyond_single_in_double,
    "a finite cost beyond double precision": [
        planned(with_cost(np.longdouble(value), like=COSTS.astype("g")), (0, 0), precision="f64")
        for value in ("1e400", "1e-400")
        if np.finfo("g").max > np.finfo("d").max
    ],
    "subnormal costs": check_subnormals,
    "the largest cost, alone": check_largest_alone,
    "the largest cost beside another": [
        planned([[F32_MAX, F32_MAX]], (0, 0), **options) for options in ENGINES.values()
    ]
    + [planned(np.full((2, 2), np.finfo(float).max), (0, 0), precision="f64")],
    "sums beyond the precision": [
        planned(np.full(shape, 1e38), (0, 0), **options)
        for shape in [(1, 9), (9, 1), (66, 70)]
        for options in ENGINES.values()
    ],
    "huge beside tiny costs": [
        planned(costs, (0, 0), **options)
        for costs in (
            [[1e9, 1e9, 1.0, 1.0]],
            [[1e9], [1e9], [1.0], [1.0]],
            [[1.0, 1.0, *[F32_LEAST] * 2]],
        )
        for options in ENGINES.values()
    ],
    "the same, precise enough": check_huge_beside_tiny_precise_enough,
    "steps beyond 2³²": check_wide_steps,
    "a bool array": check_bools,
    "integers": check_integers,
    "float16, float32, float64, long double": check_floats,
    "big-endian, Fortran order, strided, read-only, broadcast": as_plain(*strided()),
    "a masked array with nothing masked": check_nothing_masked,
    "a masked array with masked cells": [planned(np.ma.masked_greater(COSTS, 0.0), (0, 0))],
    "objects, words, complex numbers": [
        planned(COSTS.astype(kind), (0, 0)) for kind in (object, str, complex)
    ],
    "rows of different lengths": [planned([[1.0, 1.0], [1.0]], (0, 0))],
    "one or three axes": [planned(np.ones(3), (0, 0)), planned(np.ones((2, 2, 2)), (0, 0))],
    "a fraction for a row": [planned(COSTS, (0.5, 0)), planned(COSTS, (0, np.nan))],
    "zero threads": [planned(FREE, (0, 0), threads=0), planned(COSTS, (0, 0), threads=0)],
    "half a thread": [planned(FREE, (0, 0), threads=0.5)],
    "a goal point beyond the map": [
        lambda goal=goal: cairn.plan(OFFICE, goal)
        for goal in [(-0.1, 1.0), (3.1, 1.0), (1.0, np.nan), (np.inf, 0.0)]
    ],
    "a point between two cells": check_points_between_cells,
    "a graph without nodes": [lambda: cairn.plan_graph([0], [], np.empty(0), 0)],
    "a graph of one node": check_graph_of_one_node,
    "a link to its own node, or of infinite cost": check_links_that_lead_nowhere,
    "links that cost nothing": check_links_that_cost_nothing,
    "a negative link": [graph([1.0, -1.0]), graph([1, -1]), graph([-INF, 1.0])],
    "a NaN link": [graph([1.0, np.nan])],
    "integer links whose sum may pass 2⁶⁴": [graph(np.full(2, 2**63, np.uint64))],
}


def table():
    text = (Path(__file__).parent.parent / "docs/planner-edges.md").read_text()
    rows = [re.split(r"(?<!\\)\|", line)[1:4] for line in text.splitlines() if line.startswith("|")]
    return {given.strip(): outcome.strip() for given, outcome, _ in rows[2:]}


def test_the_table_and_these_tests_have_the_same_rows():
    assert list(table()) == list(ROWS)


@pytest.mark.parametrize(("given", "outcome"), table().items())
def test_what_is_given_at_the_edges_has_the_outcome_of_the_table(given, outcome):
    row = ROWS[given]
    if outcome == "planned":
        row()
        return
    for call in row:
        with pytest.raises(getattr(cairn.errors, outcome.strip("`"))) as caught:
            call()
        assert caught.type.__name__ == outcome.strip("`")


def test_a_cost_that_is_none_is_named_with_the_first_place_in_reading_order():
    costs = np.ones((70, 70))
    costs[64, 3], costs[3, 64], costs[66, 66] = -1.0, np.nan, 0.0
    with pytest.raises(cairn.errors.CellCostNan) as caught:
        cairn.plan_grid(costs, (0, 0))
    assert (caught.value.row, caught.value.col) == (3, 64)
    costs[3, 64] = 1.0
    with pytest.raises(cairn.errors.CellCostNegative) as caught:
        cairn.plan_grid(costs, (0, 0))
    assert (caught.value.row, caught.value.col, caught.value.value) == (64, 3, -1.0)
