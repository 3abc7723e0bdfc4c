from dataclasses import dataclass

import numpy as np
import pytest

import cairn


@dataclass
class Place:
    """The least that `plan` needs of a world."""

    occupancy: np.ndarray
    resolution_m: float = 0.5
    origin: tuple[float, float, float] = (10.0, -4.0, 0.0)
    costs: np.ndarray | None = None


def walled():
    """20 × 30 cells of 0.5 m, x 10..25 m, y -4..6 m, a wall at x 17..17.5 m open at the top."""
    occupancy = np.zeros((20, 30), np.uint8)
    occupancy[:16, 14] = 1
    return occupancy


def length(path):
    return np.hypot(*np.diff(path, axis=0).T).sum()


def test_cost_to_go_is_in_metres_and_the_path_runs_between_the_exact_points():
    field = cairn.plan(Place(np.zeros((20, 30), np.uint8)), (12.25, -1.75))
    assert field.cost_to_go[4, 4] == 0.0
    assert field.cost_to_go[4, 14] == 5.0
    path = field.path((17.3, -1.7))
    assert (path[0].tolist(), path[-1].tolist()) == ([17.3, -1.7], [12.25, -1.75])
    np.testing.assert_allclose(path[1:-1, 1], -1.75)
    assert (np.diff(path[:, 0]) < 0).all()


def test_the_path_goes_round_the_wall_and_is_as_long_as_the_field_says():
    field = cairn.plan(Place(walled()), (12.25, -3.75))
    start = (22.25, -3.75)
    path = field.path(start)
    assert path[:, 1].max() > 4.0
    assert length(path) == pytest.approx(field.cost_to_go[0, 24], rel=1e-6)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
def test_the_plan_turns_with_the_map(yaw):
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    flat = Place(walled(), origin=(0.0, 0.0, 0.0))
    turned = Place(walled(), origin=(3.0, 5.0, yaw))
    start, goal = np.array([12.3, 0.3]), np.array([1.1, 2.2])
    expected = cairn.plan(flat, goal).path(start)
    field = cairn.plan(turned, turn @ goal + (3.0, 5.0))
    found = field.path(turn @ start + (3.0, 5.0))
    np.testing.assert_allclose(found, expected @ turn.T + (3.0, 5.0), atol=1e-9)


def test_many_robots_share_one_field_and_a_shoved_one_needs_no_new_plan():
    field = cairn.plan(Place(walled()), (12.25, -3.75))
    rng = np.random.default_rng(1)
    for _ in range(50):
        row, col = rng.integers(0, 20), rng.integers(0, 30)
        start = (10.0 + (col + 0.5) * 0.5, -4.0 + (row + 0.5) * 0.5)
        path = field.path(start)
        if walled()[row, col]:
            assert path is None
        else:
            assert length(path) == pytest.approx(field.cost_to_go[row, col], rel=1e-6)


def test_costs_are_per_metre_and_lead_round_dear_ground():
    costs = np.ones((20, 30))
    costs[:16, 14] = 50.0
    costs[:, 29] = np.inf
    field = cairn.plan(Place(np.zeros((20, 30), np.uint8), costs=costs), (12.25, -3.75))
    assert field.native.dtype == np.float32
    assert field.cost_to_go[0, 5] == pytest.approx(0.5)
    assert field.path((22.25, -3.75))[:, 1].max() > 4.0
    assert field.path((24.75, 0.0)) is None


def test_what_stands_on_a_map_blocks_whatever_its_cells_cost():
    wall = np.array([[0, 1, 0], [0, 1, 0]], np.uint8)
    world = cairn.World(wall, 1.0, costs=np.ones(wall.shape, np.float32))
    field = cairn.plan(world, (0.5, 0.5))
    assert field.native.dtype == np.float32
    assert field.path((2.5, 0.5)) is None
    with pytest.raises(cairn.errors.GoalBlocked):
        cairn.plan(world, (1.5, 0.5))


def test_unknown_cells_are_blocked_unless_taken_as_free():
    occupancy = walled()
    occupancy[16:, 14] = 2
    blocked = cairn.plan(Place(occupancy), (12.25, -3.75))
    free = cairn.plan(Place(occupancy), (12.25, -3.75), unknown="free")
    assert blocked.path((22.25, -3.75)) is None
    assert free.path((22.25, -3.75)) is not None


def test_of_several_goals_the_path_ends_at_the_nearest():
    goals = [(12.25, -3.75), (24.1, 5.1, 0.0)]
    field = cairn.plan(Place(walled()), goals)
    assert field.goals == [(12.25, -3.75), (24.1, 5.1)]
    assert field.path((22.0, 4.0))[-1].tolist() == [24.1, 5.1]
    assert field.path((13.0, -3.0))[-1].tolist() == [12.25, -3.75]


def test_no_point_of_a_path_is_repeated_even_at_the_goal():
    field = cairn.plan(Place(walled()), (12.25, -3.75))
    assert field.path((12.25, -3.75)).tolist() == [[12.25, -3.75]]
    assert field.path((12.1, -3.9)).tolist() == [[12.1, -3.9], [12.25, -3.75]]
    path = field.path((22.25, -3.75))
    assert (np.abs(np.diff(path, axis=0)).sum(axis=1) > 0).all()


def test_a_world_of_cairn_is_planned_on():
    world = cairn.World(walled(), 0.5, (10.0, -4.0, 0.0))
    field = cairn.plan(world, (12.25, -3.75))
    same = cairn.plan(Place(walled()), (12.25, -3.75))
    np.testing.assert_array_equal(field.native, same.native)


def test_points_off_the_map_or_in_obstacles_are_refused_by_name():
    world = Place(walled())
    for goal in [(9.9, 0.0), (25.1, 0.0), (12.0, 6.1), (np.nan, 0.0)]:
        with pytest.raises(cairn.errors.GoalOutsideMap) as caught:
            cairn.plan(world, goal)
        assert caught.value.resolution_m == 0.5
    with pytest.raises(cairn.errors.GoalBlocked) as blocked:
        cairn.plan(world, (17.25, 0.0))
    assert (blocked.value.row, blocked.value.col) == (8, 14)
    with pytest.raises(cairn.errors.StartOutsideMap) as outside:
        cairn.plan(world, (12.0, 0.0)).path((30.0, 0.0))
    assert outside.value.x_m == 30.0
    for start in [None, (1.0,), "ab", 3.0]:
        with pytest.raises(cairn.errors.StartMalformed):
            cairn.plan(world, (12.0, 0.0)).path(start)
    with pytest.raises(cairn.errors.GoalMalformed):
        cairn.plan(world, 3.0)
    with pytest.raises(cairn.errors.NoGoal):
        cairn.plan(world, [])
    with pytest.raises(cairn.errors.UnknownPlanOption, match="maybe"):
        cairn.plan(world, (12.0, 0.0), unknown="maybe")
