import numpy as np
import pytest

import cairn
from plan_oracles import (
    MOVES,
    Case,
    a_star,
    check_pointers,
    grid_links,
    joined,
    lowest_codes,
    mean_price,
    scipy_cost_to_go,
    step_price,
    textbook_cost_to_go,
)

ENGINES = ["phased", "levelled", "in_place"]
CODES = np.array([[5, 6, 7], [4, -1, 0], [3, 2, 1]])  # by Δrow + 1, Δcol + 1


def random_grid(rng, number=None):
    """Cell costs, inf blocked, with walls, pockets and ties; and one to three goals."""
    rows, cols = rng.integers(1, 9, 2)
    if number is None:
        costs = np.ones((rows, cols))
    elif rng.random() < 0.5:
        costs = rng.integers(1, 4, (rows, cols)).astype(number)
    else:
        costs = (rng.random((rows, cols)) + 0.01).astype(number)
    costs[rng.random((rows, cols)) < rng.choice([0.0, 0.2, 0.45])] = np.inf
    free = np.argwhere(np.isfinite(costs))
    if not len(free):
        costs[0, 0], free = 1.0, np.array([[0, 0]])
    chosen = rng.choice(len(free), size=min(len(free), int(rng.integers(1, 4))), replace=False)
    return costs, [tuple(map(int, free[i])) for i in chosen]


def grid_case(costs, goals, corner_cutting, price):
    tails, heads, codes, prices = grid_links(costs, corner_cutting, price)
    flat = [row * costs.shape[1] + col for row, col in goals]
    return Case(costs.size, tails, heads, prices, flat), codes


def next_cells(next_node):
    """Codes turned into row-major cell numbers; -1 stays."""
    rows, cols = next_node.shape
    offsets = np.array([down * cols + right for down, right in MOVES] + [0])
    cells = np.arange(rows * cols).reshape(rows, cols) + offsets[next_node]
    return np.where(next_node >= 0, cells, -1).ravel()


ARITHMETICS = {
    "985/1393": (None, step_price(985, 1393), {}),
    "100/141": (None, step_price(100, 141), {"steps": "100/141"}),
    "f32": (np.float32, mean_price(np.float32), {}),
    "f64": (np.float64, mean_price(np.float64), {"precision": "f64"}),
}


@pytest.mark.parametrize("corner_cutting", [False, True])
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_the_field_and_every_engine_equal_dijkstra_to_the_bit(arithmetic, corner_cutting):
    number, price, options = ARITHMETICS[arithmetic]
    rng = np.random.default_rng(7)
    cases, codes, fields, graphs = [], [], [], []
    for _ in range(350 if arithmetic == "f32" else 1400):  # 9 100 grids in all
        costs, goals = random_grid(rng, number)
        given = costs if number else np.isfinite(costs)
        case, code = grid_case(costs, goals, corner_cutting, price)
        cases.append(case)
        codes.append(code)
        fields.append(cairn.plan_grid(given, goals, corner_cutting=corner_cutting, **options))
        graphs.append(cairn.grid_graph(given, corner_cutting=corner_cutting, **options))
    whole = joined(cases)
    if arithmetic == "f32":
        truth = np.concatenate([textbook_cost_to_go(case, np.float32) for case in cases])
    else:
        truth = scipy_cost_to_go(whole)
    ends = np.cumsum([case.nodes for case in cases])[:-1]
    for case, code, field, graph, values in zip(
        cases, codes, fields, graphs, np.split(truth, ends), strict=True
    ):
        native = field.native.astype(float).ravel()
        if not number:
            native[field.native.ravel() == np.iinfo(np.uint32).max] = np.inf
        np.testing.assert_array_equal(native, values)
        np.testing.assert_array_equal(field.cost_to_go.ravel(), values / field.unit)
        typed = values.astype(number or float)
        np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, code, typed))
        check_pointers(case, typed, next_cells(field.next_node))
        for given, built in zip(graph, case.csr, strict=True):
            np.testing.assert_array_equal(given, built)
    for case, graph, values in zip(cases[:300], graphs, np.split(truth, ends), strict=False):
        for engine in ENGINES:
            result = cairn.plan_layered(*graph, case.goals, engine=engine)
            np.testing.assert_array_equal(result.cost_to_go, values)
            check_pointers(case, values.astype(number or float), result.next_node)


def test_the_field_satisfies_bellman_at_every_reachable_cell_of_a_large_grid():
    rng = np.random.default_rng(8)
    costs = rng.integers(1, 50, (151, 203)).astype(np.float32)
    costs[rng.random(costs.shape) < 0.25] = np.inf
    costs[75, 100] = 1.0
    field = cairn.plan_grid(costs, (75, 100))
    case, codes = grid_case(costs, [(75, 100)], False, mean_price(np.float32))
    values = field.native.ravel()
    best = np.full(case.nodes, np.inf, np.float32)
    np.minimum.at(best, case.tails, values[case.heads] + case.costs)
    best[case.goals] = 0.0
    np.testing.assert_array_equal(best, values)
    np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, codes, values))
    check_pointers(case, values, next_cells(field.next_node))


@pytest.mark.parametrize("precision", [None, "f32", "f64"])
def test_the_field_is_the_same_for_any_number_of_threads(precision):
    free = np.random.default_rng(9).random((60, 80)) > 0.3
    free[30, 40] = True
    one, two, auto = (
        cairn.plan_grid(free, (30, 40), precision=precision, threads=threads)
        for threads in (1, 2, None)
    )
    for other in (two, auto):
        np.testing.assert_array_equal(one.native, other.native)
        np.testing.assert_array_equal(one.next_node, other.next_node)


def test_next_node_codes_are_the_documented_moves():
    field = cairn.plan_grid(np.ones((3, 3), bool), (1, 1))
    np.testing.assert_array_equal(field.next_node, np.flip(CODES))


def test_a_diagonal_needs_both_side_cells_free_unless_corners_may_be_cut():
    one_side = np.array([[True, False], [True, True]])
    no_side = np.array([[True, False], [False, True]])
    for free in (one_side, no_side):
        assert cairn.plan_grid(free, (1, 1), corner_cutting=True).native[0, 0] == 1393
    assert cairn.plan_grid(one_side, (1, 1)).native[0, 0] == 2 * 985
    assert cairn.plan_grid(no_side, (1, 1)).path((0, 0)) is None


def test_a_path_runs_from_the_start_to_the_goal_with_both_ends():
    field = cairn.plan_grid(np.ones((5, 7), bool), (2, 3))
    assert field.path((0, 0)).tolist() == [[0, 0], [0, 1], [1, 2], [2, 3]]
    assert field.path((2, 3)).tolist() == [[2, 3]]


def test_arrays_are_shared_read_only_and_outlive_the_field():
    field = cairn.plan_grid(np.ones((5, 7)), (2, 3))
    native, next_node, cost_to_go = field.native, field.next_node, field.cost_to_go
    assert field.cost_to_go is cost_to_go
    for array in (native, next_node, cost_to_go):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 0
        with pytest.raises(ValueError, match="cannot set WRITEABLE"):
            native.flags.writeable = True
    assert (native.dtype, next_node.dtype, cost_to_go.dtype) == (np.float32, np.int8, np.float64)
    del field
    assert native[2, 3] == 0.0
    assert next_node[2, 3] == -1


def test_one_cell_is_a_world():
    field = cairn.plan_grid([[True]], (0, 0))
    assert (field.cost_to_go.tolist(), field.next_node.tolist()) == ([[0.0]], [[-1]])


# ---- the kinds of case of [Maalouf06 Fig. 12] ---


def open_obstacles():
    free = np.ones((30, 40), bool)
    for row, col, height, width in [(4, 6, 6, 5), (15, 3, 4, 12), (9, 20, 12, 4), (22, 26, 5, 9)]:
        free[row : row + height, col : col + width] = False
    return free, (28, 37), (1, 1)


def harder_obstacles():
    free = np.ones((32, 40), bool)
    free[5, 8:30] = free[26, 8:30] = free[5:27, 29] = False  # a trap open to the left
    free[10:22, 14] = free[10, 14:24] = free[21, 14:24] = False  # another inside it, open right
    free[0:24, 34] = False
    return free, (15, 20), (2, 38)


def labyrinth():
    rng = np.random.default_rng(12)
    rows, cols = 15, 21
    free = np.zeros((2 * rows + 1, 2 * cols + 1), bool)
    stack = [(0, 0)]
    free[1, 1] = True
    while stack:
        row, col = stack[-1]
        unseen = [
            (row + down, col + right)
            for down, right in ((0, 1), (1, 0), (0, -1), (-1, 0))
            if 0 <= row + down < rows
            and 0 <= col + right < cols
            and not free[2 * (row + down) + 1, 2 * (col + right) + 1]
        ]
        if not unseen:
            stack.pop()
            continue
        there = unseen[rng.integers(len(unseen))]
        free[2 * there[0] + 1, 2 * there[1] + 1] = True
        free[row + there[0] + 1, col + there[1] + 1] = True
        stack.append(there)
    return free, (1, 1), (2 * rows - 1, 2 * cols - 1)


@pytest.mark.parametrize("corner_cutting", [False, True])
@pytest.mark.parametrize("kind", [open_obstacles, harder_obstacles, labyrinth])
def test_field_path_and_engines_equal_a_star_to_the_unit_on_the_papers_kinds(kind, corner_cutting):
    free, start, goal = kind()
    field = cairn.plan_grid(free, goal, corner_cutting=corner_cutting, steps="100/141")
    cells = np.argwhere(free)
    for cell in [start, *map(tuple, cells[:: max(1, len(cells) // 40)].tolist())]:
        cost, _ = a_star(free, cell, goal, 100, 141, corner_cutting)
        if cost is None:
            assert field.path(cell) is None
            continue
        assert field.native[cell] == cost
        moves = np.abs(np.diff(field.path(cell), axis=0)).sum(axis=1)
        assert (moves == 1).sum() * 100 + (moves == 2).sum() * 141 == cost
    graph = cairn.grid_graph(free, corner_cutting=corner_cutting, steps="100/141")
    for engine in ENGINES:
        result = cairn.plan_layered(*graph, goal[0] * free.shape[1] + goal[1], engine=engine)
        values = result.cost_to_go.reshape(free.shape) / 100
        np.testing.assert_array_equal(values, field.cost_to_go)


def test_classical_dynamic_programming_is_not_optimal_on_the_harder_obstacles():
    free, _, goal = harder_obstacles()
    graph = cairn.grid_graph(free, steps="100/141")
    flat = goal[0] * free.shape[1] + goal[1]
    classical = cairn.plan_layered(*graph, flat, engine="classical")
    best = cairn.plan_layered(*graph, flat)
    assert not classical.converged
    assert (classical.native >= best.native).all()
    assert (classical.native > best.native).any()


# ---- bad input ---


@pytest.mark.parametrize(
    ("costs", "goal", "error", "fields"),
    [
        (np.ones((0, 3), bool), (0, 0), "EmptyGrid", {"rows": 0, "cols": 3}),
        (np.ones((3, 0)), (0, 0), "EmptyGrid", {"rows": 3, "cols": 0}),
        (np.ones(3), (0, 0), "GridNotPlannable", {"shape": (3,)}),
        (np.ones((2, 2), complex), (0, 0), "GridNotPlannable", {"dtype": "complex128"}),
        (np.ones((2, 2), bool), [], "NoGoal", {}),
        (np.ones((2, 2), bool), (-1, 0), "GoalOutsideGrid", {"row": -1, "col": 0, "rows": 2}),
        (np.ones((2, 2)), [(0, 0), (0, 2)], "GoalOutsideGrid", {"row": 0, "col": 2}),
        (np.ones((2, 2)), (0.5, 0), "CellNotWhole", {"value": 0.5}),
        (np.ones((2, 2)), (np.nan, 0), "CellNotWhole", {}),
        (np.ones((2, 2)), (0, 1e30), "CellNotWhole", {"value": 1e30}),
        (np.ones((2, 2)), (0, 0, 0), "GoalMalformed", {"value": (0, 0, 0)}),
        (np.ones((2, 2)), 3, "GoalMalformed", {"value": 3}),
        (np.ones((2, 2)), "ab", "GoalMalformed", {"value": "ab"}),
        (np.array([[True, False]]), (0, 1), "GoalBlocked", {"row": 0, "col": 1}),
        (np.array([[1.0, np.inf]]), (0, 1), "GoalBlocked", {"row": 0, "col": 1}),
        (np.array([[1.0, np.nan]]), (0, 0), "CellCostNan", {"row": 0, "col": 1}),
        (np.array([[1.0], [-2.0]]), (0, 0), "CellCostNegative", {"row": 1, "value": -2.0}),
        (np.array([[1.0, -np.inf]]), (0, 0), "CellCostNegative", {"col": 1, "value": -np.inf}),
        (np.array([[1, 0]]), (0, 0), "CellCostZero", {"row": 0, "col": 1, "value": 0.0}),
        (np.array([[1.0, -0.0]]), (0, 0), "CellCostZero", {"row": 0, "col": 1}),
        (np.array([[1.0, 1e300]]), (0, 0), "CellCostBeyondPrecision", {"col": 1, "value": 1e300}),
        (np.array([[1.0, 1e-60]]), (0, 0), "CellCostBeyondPrecision", {"value": 1e-60}),
        (np.array([[1e9, 1e9, 1, 1]]), (0, 0), "LinkCostAbsorbed", {"col": 3, "precision": "f32"}),
        (np.array([[3e38, 1, 3e38, 1]]), (0, 0), "CostToGoOverflow", {"col": 3}),
    ],
)
def test_a_bad_grid_or_goal_is_refused_by_name_with_its_place_and_value(costs, goal, error, fields):
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        cairn.plan_grid(costs, goal)
    assert {name: getattr(caught.value, name) for name in fields} == fields


def test_bad_options_and_starts_are_refused_by_name():
    free = np.ones((2, 3), bool)
    with pytest.raises(cairn.errors.NoThreads):
        cairn.plan_grid(free, (0, 0), threads=0)
    with pytest.raises(cairn.errors.UnknownPlanOption, match="'f16'"):
        cairn.plan_grid(free, (0, 0), precision="f16")
    with pytest.raises(cairn.errors.UnknownPlanOption, match="'1/1'"):
        cairn.plan_grid(free, (0, 0), steps="1/1")
    for start in [(2, 0), (0, 3), (-1, 0)]:
        with pytest.raises(cairn.errors.StartOutsideGrid):
            cairn.plan_grid(free, (0, 0)).path(start)
    for start in [None, (1,), (1, 2, 3), 7]:
        with pytest.raises(cairn.errors.StartMalformed):
            cairn.plan_grid(free, (0, 0)).path(start)
