"""Whatever a planner is given, it answers with a plan or with an error of cairn.errors."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import cairn

GRID = np.ones((3, 4))


@dataclass
class Place:
    occupancy: Any = field(default_factory=lambda: np.zeros((3, 4), np.uint8))
    resolution_m: Any = 1.0
    origin: Any = (0.0, 0.0, 0.0)
    costs: Any = None


class NoArray:
    def __array__(self, *_, **__):
        raise TypeError("not to be had as an array")


GRIDS = {
    "none": (None, {"shape": (), "dtype": "object"}),
    "a number": (1.0, {"shape": ()}),
    "a word": ("abc", {"shape": ()}),
    "ragged rows": ([[1.0, 2.0], [3.0]], {"shape": (2,), "dtype": "object"}),
    "ragged bools": ([[True], [True, False], []], {"shape": (3,)}),
    "objects": (GRID.astype(object), {"shape": (3, 4), "dtype": "object"}),
    "words": (np.full((2, 2), "1"), {"dtype": "<U1"}),
    "dates": (np.zeros((2, 2), "M8[s]"), {"dtype": "datetime64[s]"}),
    "complex": (GRID + 0j, {"dtype": "complex128"}),
    "records": (np.zeros((2, 2), [("cost", float)]), {"shape": (2, 2)}),
    "one axis": (np.ones(5), {"shape": (5,)}),
    "three axes": (np.ones((2, 2, 2)), {"shape": (2, 2, 2)}),
    "masked cells": (np.ma.masked_greater(GRID, 0.5), {"shape": (3, 4), "dtype": "float64"}),
    "no array": (NoArray(), {"dtype": "object"}),
}


@pytest.mark.parametrize("kind", GRIDS)
def test_what_is_no_grid_is_refused_by_name_with_shape_and_type(kind):
    given, fields = GRIDS[kind]
    for plan in (cairn.plan_grid, lambda grid, _: cairn.grid_graph(grid)):
        with pytest.raises(cairn.errors.GridNotPlannable) as caught:
            plan(given, (0, 0))
        assert {name: getattr(caught.value, name) for name in fields} == fields
    for place in (Place(occupancy=given), Place(costs=given)):
        if place.occupancy is given or given is not None:
            with pytest.raises(cairn.errors.GridNotPlannable):
                cairn.plan(place, (0.5, 0.5))


@pytest.mark.parametrize("threads", ["x", "2", 1.5, 2.0, -1, True, [1], np.nan, None.__class__])
def test_threads_are_a_whole_number_of_them_or_none(threads):
    with pytest.raises(cairn.errors.UnknownPlanOption) as caught:
        cairn.plan_grid(GRID, (0, 0), threads=threads)
    assert caught.value.option == "threads"
    with pytest.raises(cairn.errors.UnknownPlanOption):
        cairn.plan(Place(), (0.5, 0.5), threads=threads)


@pytest.mark.parametrize("threads", [None, 1, np.int8(2), np.uint64(3), 2**31, 2**100])
def test_any_whole_number_of_threads_gives_the_same_field(threads):
    field = cairn.plan_grid(GRID, (1, 2), threads=threads)
    np.testing.assert_array_equal(field.native, cairn.plan_grid(GRID, (1, 2)).native)


@pytest.mark.parametrize("flag", [0, 1, "no", "True", None, 1.0, np.array([True, False]), []])
def test_corner_cutting_is_yes_or_no(flag):
    for plan in (
        lambda: cairn.plan_grid(GRID, (0, 0), corner_cutting=flag),
        lambda: cairn.plan(Place(), (0.5, 0.5), corner_cutting=flag),
        lambda: cairn.grid_graph(GRID, corner_cutting=flag),
    ):
        with pytest.raises(cairn.errors.UnknownPlanOption) as caught:
            plan()
        assert caught.value.option == "corner_cutting"
    cairn.plan_grid(GRID, (0, 0), corner_cutting=np.True_)


@pytest.mark.parametrize("value", ["f16", "F32", 32, np.float32, np.array(["f32", "f64"]), [], {}])
def test_precision_steps_and_unknown_are_one_of_their_choices(value):
    for option, plan in {
        "precision": lambda: cairn.plan_grid(GRID, (0, 0), precision=value),
        "steps": lambda: cairn.plan_grid(GRID > 0, (0, 0), steps=value),
        "unknown": lambda: cairn.plan(Place(), (0.5, 0.5), unknown=value),
    }.items():
        with pytest.raises(cairn.errors.UnknownPlanOption) as caught:
            plan()
        assert caught.value.option == option
        assert caught.value.value is value


@pytest.mark.parametrize("world", [None, 1, "office", GRID, {"occupancy": GRID}])
def test_what_is_no_world_is_refused_by_name_with_what_it_lacks(world):
    with pytest.raises(cairn.errors.WorldNotPlannable, match=r"cairn\.World") as caught:
        cairn.plan(world, (0.5, 0.5))
    assert caught.value.attribute == "occupancy"
    assert caught.value.kind == type(world).__name__


@pytest.mark.parametrize("resolution_m", [0.0, -1.0, np.nan, np.inf, "fine", None, [1.0]])
def test_a_resolution_is_metres_above_zero(resolution_m):
    with pytest.raises(cairn.errors.WorldValueOutOfRange) as caught:
        cairn.plan(Place(resolution_m=resolution_m), (0.5, 0.5))
    assert caught.value.key == "resolution_m"


@pytest.mark.parametrize("origin", [None, 0.0, (0.0, 0.0), (0.0, 0.0, np.nan), "abc", (1, 2, 3, 4)])
def test_an_origin_is_three_finite_numbers(origin):
    with pytest.raises(cairn.errors.WorldValueOutOfRange) as caught:
        cairn.plan(Place(origin=origin), (0.5, 0.5))
    assert caught.value.key == "origin"


def test_costs_of_another_shape_than_the_occupancy_are_refused_by_name():
    with pytest.raises(cairn.errors.WorldShapeInvalid) as caught:
        cairn.plan(Place(costs=np.ones((4, 3))), (0.5, 0.5))
    assert (caught.value.what, caught.value.shape) == ("costs", (4, 3))


@pytest.mark.parametrize("goal", [None, 3, "ab", b"ab", (0,), [[0, 0], [1]], (0, 0, 0), object()])
def test_a_goal_that_is_no_cell_is_refused_by_name(goal):
    with pytest.raises(cairn.errors.GoalMalformed):
        cairn.plan_grid(GRID, goal)


@pytest.mark.parametrize("goal", [("a", "b"), (0.5, 0), (np.nan, 0), (0, np.inf), (0, 2**63)])
def test_a_goal_that_is_no_whole_cell_is_refused_by_name(goal):
    with pytest.raises(cairn.errors.CellNotWhole):
        cairn.plan_grid(GRID, goal)


@pytest.mark.parametrize("goal", [None, "a", (0.5,), [[0]], object()])
def test_a_goal_that_is_no_node_is_refused_by_name(goal):
    with pytest.raises(cairn.errors.CellNotWhole):
        cairn.plan_graph([0, 1], [0], [1.0], goal)


@pytest.mark.parametrize("goal", [0, [0], (0,), np.array(0), np.array([0]), np.int8(0), 0.0])
def test_a_node_is_given_as_any_whole_number_or_a_sequence_of_them(goal):
    assert cairn.plan_graph([0, 1], [0], [1.0], goal).cost_to_go.tolist() == [0.0]


@pytest.mark.parametrize("which", ["indptr", "indices", "costs"])
@pytest.mark.parametrize("given", [None, [[0], [1, 2]], "ab", [[0, 1]], [None], NoArray()])
def test_what_is_no_array_of_a_graph_is_refused_by_name(which, given):
    arrays = {"indptr": [0, 1], "indices": [0], "costs": [1.0], which: given}
    with pytest.raises(cairn.errors.GraphNotPlannable) as caught:
        cairn.plan_graph(*arrays.values(), 0)
    assert caught.value.array == which


def test_costs_that_double_precision_cannot_hold_are_refused_not_rounded_to_a_wall():
    huge, tiny = np.longdouble("1e400"), np.longdouble("1e-400")
    for value in {huge, tiny}:
        if value in (0, np.inf):
            continue  # long double is double here
        costs = np.array([[1, value]], np.longdouble)
        for precision in ("f32", "f64"):
            with pytest.raises(cairn.errors.CellCostBeyondPrecision) as caught:
                cairn.plan_grid(costs, (0, 0), precision=precision)
            assert (caught.value.row, caught.value.col) == (0, 1)
