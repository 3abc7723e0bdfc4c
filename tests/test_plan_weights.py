import math

import numpy as np
import pytest

import cairn
from plan_oracles import (
    MOVES,
    Case,
    check_pointers,
    grid_links,
    joined,
    lowest_codes,
    mean_price,
    scipy_cost_to_go,
    textbook_cost_to_go,
)

NONE = np.iinfo(np.uint32).max


def weight_links(weights, goals):
    """Every move that stays on the grid and is not shut, as a graph."""
    _, rows, cols = weights.shape
    shut = NONE if weights.dtype == np.uint32 else np.inf
    found = []
    for code, (down, right) in enumerate(MOVES):
        for row, col in np.ndindex(rows, cols):
            to = (row + down, col + right)
            weight = weights[code, row, col]
            if 0 <= to[0] < rows and 0 <= to[1] < cols and weight != shut:
                found.append((row * cols + col, to[0] * cols + to[1], code, weight))
    found.sort(key=lambda link: (link[0], link[2]))
    parts = [np.array([link[i] for link in found]) for i in range(4)]
    tails, heads, codes = (part.astype(int) for part in parts[:3])
    flat = [row * cols + col for row, col in goals]
    return Case(rows * cols, tails, heads, parts[3].astype(weights.dtype), flat), codes


def random_weights(rng, number):
    rows, cols = (int(n) for n in rng.integers(1, 9, 2))
    if number == np.uint32:
        weights = rng.integers(1, rng.choice([4, 1000, 10**8]), (8, rows, cols)).astype(number)
    elif rng.random() < 0.4:
        weights = rng.integers(1, 4, (8, rows, cols)).astype(number)
    else:
        weights = (rng.random((8, rows, cols)) * 10.0 ** rng.integers(-3, 4)).astype(number)
        weights += np.float32(1e-3)
    weights[rng.random(weights.shape) < rng.choice([0.0, 0.3, 0.7])] = (
        NONE if number == np.uint32 else np.inf
    )
    goals = [
        tuple(int(rng.integers(0, n)) for n in (rows, cols)) for _ in range(rng.integers(1, 4))
    ]
    return weights, goals


def next_cells(next_node):
    offsets = np.array([down * next_node.shape[1] + right for down, right in MOVES] + [0])
    cells = np.arange(next_node.size).reshape(next_node.shape) + offsets[next_node]
    return np.where(next_node >= 0, cells, -1).ravel()


@pytest.mark.parametrize("number", [np.float32, np.uint32])
def test_field_and_policy_equal_an_independent_dijkstra_to_the_bit(number):
    rng = np.random.default_rng(21)
    cases, codes, fields = [], [], []
    for _ in range(400):
        weights, goals = random_weights(rng, number)
        case, code = weight_links(weights, goals)
        cases.append(case)
        codes.append(code)
        fields.append(cairn.plan_weights(weights, goals))
    if number == np.float32:
        truth = textbook_cost_to_go(joined(cases), np.float32).astype(np.float32)
    else:
        truth = scipy_cost_to_go(joined(cases))
    ends = np.cumsum([case.nodes for case in cases])[:-1]
    for case, code, field, values in zip(cases, codes, fields, np.split(truth, ends), strict=True):
        assert field.native.dtype == number
        assert field.unit == 1.0
        np.testing.assert_array_equal(field.cost_to_go.ravel(), values)
        assert (
            field.native.ravel()[np.isinf(values)] == (np.inf if number == np.float32 else NONE)
        ).all()
        np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, code, values))
        check_pointers(case, values, next_cells(field.next_node))


def test_weights_of_a_cost_grid_give_the_plan_of_that_grid():
    rng = np.random.default_rng(22)
    costs = rng.integers(1, 30, (40, 53)).astype(np.float32)
    costs[rng.random(costs.shape) < 0.2] = np.inf
    costs[20, 30] = 1.0
    weights = np.full((8, *costs.shape), np.inf, np.float32)
    tails, _, codes, prices = grid_links(costs, False, mean_price(np.float32))
    weights.reshape(8, -1)[codes, tails] = prices
    a = cairn.plan_weights(weights, (20, 30))
    b = cairn.plan_grid(costs, (20, 30))
    np.testing.assert_array_equal(a.native, b.native)
    np.testing.assert_array_equal(a.next_node, b.next_node)


def test_a_move_may_be_one_way():
    weights = np.full((8, 1, 3), np.inf)
    weights[0] = 2.0  # only to the right
    assert cairn.plan_weights(weights, (0, 2)).cost_to_go.tolist() == [[4.0, 2.0, 0.0]]
    assert cairn.plan_weights(weights, (0, 0)).cost_to_go.tolist() == [[0.0, math.inf, math.inf]]


def test_whole_numbers_too_long_for_32_bits_are_summed_in_64():
    weights = np.full((8, 1, 9), 10**9)
    field = cairn.plan_weights(weights, (0, 8))
    assert field.native.dtype == np.uint64
    assert field.cost_to_go[0, 0] == 8e9
    weights[:, 0, 0] = NONE
    field = cairn.plan_weights(weights, (0, 8))
    assert np.isinf(field.cost_to_go[0, 0])
    assert field.cost_to_go[0, 1] == 7e9


def with_weight(value, number=float):
    weights = np.ones((8, 3, 4), number)
    weights[5, 1, 2] = value
    return weights


@pytest.mark.parametrize(
    ("weights", "error", "fields"),
    [
        (with_weight(np.nan), "WeightNan", {"row": 1, "col": 2, "code": 5}),
        (with_weight(-1.0), "WeightNegative", {"row": 1, "col": 2, "code": 5, "value": -1.0}),
        (with_weight(-np.inf), "WeightNegative", {"value": -np.inf}),
        (with_weight(0.0), "WeightZero", {"row": 1, "col": 2, "code": 5, "value": 0.0}),
        (with_weight(-0.0), "WeightZero", {"code": 5}),
        (with_weight(0, int), "WeightZero", {"row": 1, "col": 2, "code": 5}),
        (with_weight(-7, int), "WeightNegative", {"row": 1, "col": 2, "code": 5, "value": -7}),
        (with_weight(2**32, int), "WeightBeyondPrecision", {"row": 1, "code": 5, "value": 2**32}),
        (with_weight(1e300), "WeightBeyondPrecision", {"row": 1, "code": 5, "value": 1e300}),
        (with_weight(1e-300), "WeightBeyondPrecision", {"col": 2, "value": 1e-300}),
        (np.ones((3, 4, 8)), "WeightsNotPlannable", {"shape": (3, 4, 8)}),
        (np.ones((8, 3)), "WeightsNotPlannable", {"shape": (8, 3)}),
        (np.ones((8, 3, 4), bool), "WeightsNotPlannable", {"dtype": "bool"}),
        (np.ones((8, 3, 4), complex), "WeightsNotPlannable", {"dtype": "complex128"}),
        (np.ma.masked_equal(with_weight(7.0), 7.0), "WeightsNotPlannable", {}),
        (None, "WeightsNotPlannable", {"shape": ()}),
        ([[1.0], [1.0, 2.0]], "WeightsNotPlannable", {}),
        (np.ones((8, 0, 4)), "EmptyGrid", {"rows": 0, "cols": 4}),
    ],
)
def test_what_is_no_weight_is_refused_by_name(weights, error, fields):
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        cairn.plan_weights(weights, (0, 0))
    assert isinstance(caught.value, ValueError)
    assert {name: getattr(caught.value, name) for name in fields} == fields


@pytest.mark.parametrize(
    ("goal", "threads", "error"),
    [
        ((3, 0), None, "GoalOutsideGrid"),
        ((0.5, 0), None, "CellNotWhole"),
        ([], None, "NoGoal"),
        ("ab", None, "GoalMalformed"),
        ((0, 0), 0, "NoThreads"),
        ((0, 0), 1.5, "UnknownPlanOption"),
    ],
)
def test_goals_and_options_that_cannot_be_are_refused_by_name(goal, threads, error):
    with pytest.raises(getattr(cairn.errors, error)):
        cairn.plan_weights(np.ones((8, 3, 4)), goal, threads=threads)


def test_weights_that_differ_too_much_in_size_are_refused():
    weights = np.ones((8, 1, 5))
    weights[:, 0, 1] = 1e9
    with pytest.raises(cairn.errors.LinkCostAbsorbed):
        cairn.plan_weights(weights, (0, 4))
    with pytest.raises(cairn.errors.CostToGoOverflow):
        cairn.plan_weights(np.full((8, 1, 4), 3e38), (0, 3))
