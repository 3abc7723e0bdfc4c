import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import distance_transform_edt

import cairn

P3AT = (0.626, 0.505)
GRIDS = arrays(np.bool_, st.tuples(st.integers(1, 30), st.integers(1, 30)))


@settings(max_examples=60, deadline=None)
@given(GRIDS)
def test_distances_equal_scipys_exact_transform(occupied):
    ours = cairn.distance_to_occupied(occupied, 0.05)
    if not occupied.any():
        assert np.isinf(ours).all()
        return
    np.testing.assert_allclose(ours, distance_transform_edt(~occupied) * 0.05, rtol=1e-6)


@settings(max_examples=60, deadline=None)
@given(GRIDS, st.floats(-10, 10), st.floats(-10, 10), st.floats(-7, 7))
def test_the_centre_of_every_cell_lies_in_that_cell_whatever_the_origin(free, x, y, yaw):
    world = cairn.World(free, 0.05, (x, y, yaw))
    for cell in np.ndindex(free.shape):
        assert world.cell_of(world.point_of(cell)) == cell


def test_row_zero_has_the_lowest_y_and_the_origin_is_its_outer_corner():
    world = cairn.World(np.ones((4, 6), bool), 0.5, (10.0, 20.0, 0.0))
    np.testing.assert_allclose(world.point_of((0, 0)), (10.25, 20.25))
    np.testing.assert_allclose(world.point_of((3, 5)), (12.75, 21.75))
    assert world.extent == (10.0, 13.0, 20.0, 22.0)
    turned = cairn.World(np.ones((4, 6), bool), 0.5, (0.0, 0.0, np.pi / 2))
    np.testing.assert_allclose(turned.point_of((0, 5)), (-0.25, 2.75), atol=1e-12)


def test_a_door_of_one_metre_is_cheapest_in_its_middle_for_the_p3at():
    free = np.ones((60, 60), bool)
    free[28:31] = False
    free[28:31, 20:40] = True
    costs = cairn.costmap(cairn.World(free, 0.05), P3AT).costs
    row = costs[29, 20:40]
    assert np.isfinite(row).sum() == 10
    assert set(np.flatnonzero(row == row.min())) == {9, 10}


def test_layers_and_the_worlds_own_costs_are_priced_as_weighed():
    ground = np.array([[1.0, 2.0, 1.0]])
    world = cairn.World(np.ones((1, 3), bool), 1.0, costs=ground)
    noise = [[0.0, 1.0, 3.0]]
    costs = cairn.costmap(world, P3AT, distance_weight=2.0, layers={"noise": (0.5, noise)}).costs
    np.testing.assert_array_equal(costs, [[2.0, 4.5, 3.5]])


def test_ground_that_is_forbidden_is_kept_clear_of_like_a_wall():
    ground = np.ones((1, 40))
    ground[0, 20] = np.inf
    world = cairn.costmap(cairn.World(np.ones((1, 40), bool), 0.05, costs=ground), P3AT)
    wall = np.zeros((1, 40), np.uint8)
    wall[0, 20] = 1
    np.testing.assert_array_equal(world.costs, cairn.costmap(cairn.World(wall, 0.05), P3AT).costs)
    assert (world.occupancy == 0).all()


def test_unknown_is_free_blocked_or_priced():
    world = cairn.World(np.array([[0, 2]], np.uint8), 1.0)
    assert cairn.costmap(world, P3AT).costs.tolist() == [[1.0, 1.0]]
    blocked = cairn.costmap(world, P3AT, unknown="blocked", soft_margin_m=0.0).costs
    assert blocked.tolist() == [[1.0, np.inf]]
    priced = cairn.costmap(world, P3AT, unknown={"priced": {"factor": 4.0}}).costs
    assert priced.tolist() == [[1.0, 4.0]]


def test_bad_options_and_layers_are_refused_by_name():
    world = cairn.World(np.ones((2, 2), bool))
    with pytest.raises(cairn.errors.CostmapValueOutOfRange) as caught:
        cairn.costmap(world, P3AT, safety_weight=-1.0)
    assert (caught.value.key, caught.value.value) == ("safety_weight", -1.0)
    with pytest.raises(cairn.errors.SettingsInvalid, match="sofety_weight"):
        cairn.costmap(world, P3AT, sofety_weight=1.0)
    with pytest.raises(cairn.errors.LayerShapeMismatch):
        cairn.costmap(world, P3AT, layers={"noise": (1.0, [[1.0, 2.0]])})
    with pytest.raises(cairn.errors.LayerValueInvalid) as caught:
        cairn.costmap(world, P3AT, layers={"noise": (1.0, [[1.0, 2.0], [np.nan, 0.0]])})
    assert (caught.value.row, caught.value.col) == (1, 0)
    with pytest.raises(cairn.errors.WorldValueOutOfRange):
        cairn.costmap(world, (0.6, float("nan")))


@pytest.mark.parametrize(
    ("error", "fields"),
    [
        ("WorldShapeInvalid", {"occupancy": np.zeros(3, np.uint8)}),
        ("WorldShapeInvalid", {"occupancy": np.zeros((0, 5), np.uint8)}),
        ("WorldShapeInvalid", {"costs": np.ones((1, 2))}),
        ("WorldCellInvalid", {"occupancy": np.full((2, 2), 3)}),
        ("WorldCellInvalid", {"costs": np.array([[1.0, 1.0], [1.0, np.nan]])}),
        ("WorldCellInvalid", {"costs": np.array([[1.0, 1.0], [1.0, 0.0]])}),
        ("WorldCellInvalid", {"costs": np.array([[1.0, 1.0], [1.0, -2.0]])}),
        ("WorldValueOutOfRange", {"resolution_m": 0.0}),
        ("WorldValueOutOfRange", {"resolution_m": float("nan")}),
        ("WorldValueOutOfRange", {"origin": (0.0, float("inf"), 0.0)}),
        ("WorldValueOutOfRange", {"origin": (0.0, 0.0)}),
        ("WorldGoalInvalid", {"goals": {"desk": (1.0,)}}),
        ("WorldGoalInvalid", {"goals": {"desk": (1.0, float("nan"))}}),
    ],
)
def test_a_world_that_cannot_be_is_refused_by_name(error, fields):
    with pytest.raises(getattr(cairn.errors, error)):
        cairn.World(**{"occupancy": np.zeros((2, 2), np.uint8), **fields})


def test_a_one_cell_world_is_a_world():
    world = cairn.World(np.ones((1, 1), bool))
    assert world.free().all()
    assert world.cell_of((0.5, 0.5)) == (0, 0)


def test_a_world_cannot_be_changed_in_place_nor_through_the_arrays_given():
    cells = np.zeros((2, 2), np.uint8)
    world = cairn.World(cells)
    cells[0, 0] = 1
    assert world.occupancy[0, 0] == 0
    for same in (world, pickle.loads(pickle.dumps(world))):
        with pytest.raises(ValueError, match="read-only"):
            same.occupancy[0, 0] = 1


def test_points_outside_are_refused_with_the_point_and_the_extent():
    world = cairn.World(np.ones((2, 2), bool))
    assert not world.contains((2.0, 1.0))
    assert not world.contains((float("nan"), 1.0))
    with pytest.raises(cairn.errors.PointOutsideWorld) as caught:
        world.cell_of((2.5, 1.0))
    assert (caught.value.x, caught.value.extent) == (2.5, (0.0, 2.0, 0.0, 2.0))


@settings(max_examples=100, deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 3), st.floats(0, 3), st.floats(-4, 4))
def test_a_box_occupies_every_cell_that_holds_a_point_of_it_and_none_far_from_it(x, y, l, w, h):  # noqa: E741
    world = cairn.World(np.ones((30, 30), bool), 0.2, (-2.0, -3.0, 0.3)).with_boxes([x, y, l, w, h])
    along, across = np.meshgrid(np.linspace(-l / 2, l / 2, 9), np.linspace(-w / 2, w / 2, 9))
    c, s = np.cos(h), np.sin(h)
    points = np.stack([x + c * along - s * across, y + s * along + c * across], axis=-1)
    for point in points.reshape(-1, 2):
        assert not world.contains(point) or world.occupancy[world.cell_of(point)] == 1
    centres = world.point_of(np.argwhere(world.occupancy == 1)) - (x, y)
    along, across = centres @ (c, s), centres @ (-s, c)
    gap = np.hypot(np.maximum(abs(along) - l / 2, 0), np.maximum(abs(across) - w / 2, 0))
    assert (gap <= 0.2 * np.sqrt(0.5) + 1e-9).all()
