import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cairn
from cairn.mapping import OccupancyMap, raycast, sonar_ranges

P3AT = cairn.Profile.load("p3at")
SILENCE = np.full(16, np.inf)


def corridor(width_m: float = 2.0) -> cairn.World:
    """8 m long, walls one cell thick, 0.05 m cells, x from -2, centred on y = 0."""
    rows = round(width_m / 0.05) + 2
    cells = np.zeros((rows, 160), np.uint8)
    cells[[0, -1], :] = 1
    cells[:, [0, -1]] = 1
    return cairn.World(cells, 0.05, (-2.0, -width_m / 2 - 0.05, 0.0))


def heard(world: cairn.World, pose: tuple[float, float, float]) -> np.ndarray:
    """What the P3-AT's sonars are expected to hear at a pose in a world."""
    x, y, a = pose
    poses = []
    for sonar in P3AT.to_dict()["sonars"]:
        p = sonar["pose"]
        poses.append(
            (
                x + np.cos(a) * p["x"] - np.sin(a) * p["y"],
                y + np.sin(a) * p["x"] + np.cos(a) * p["y"],
                a + p["heading"],
            )
        )
    return sonar_ranges(
        world.occupancy == 1, world.resolution_m, world.origin, poses, np.radians(30), 5.0
    )


def test_rays_in_a_box_measure_to_its_faces_whatever_the_yaw_of_the_grid():
    cells = np.zeros((40, 60), bool)
    cells[[0, -1], :] = True
    cells[:, [0, -1]] = True
    for yaw in (0.0, 0.7, -2.0):
        c, s = np.cos(yaw), np.sin(yaw)
        start = (1.0 + c * 1.5 - s * 1.0, -2.0 + s * 1.5 + c * 1.0)
        directions = yaw + np.array([0.0, np.pi / 2, np.pi, -np.pi / 2])
        ranges = raycast(cells, 0.05, (1.0, -2.0, yaw), [start] * 4, directions, 10.0)
        np.testing.assert_allclose(ranges, [1.45, 0.95, 1.45, 0.95], atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    direction=st.floats(-3.2, 3.2),
    x=st.floats(0.0, 2.0),
    y=st.floats(0.0, 1.5),
)
def test_before_the_range_a_ray_is_free_and_just_behind_it_is_not(seed, direction, x, y):
    cells = np.random.default_rng(seed).random((30, 40)) < 0.05
    (r,) = raycast(cells, 0.05, (0.0, 0.0), [(x, y)], [direction], 3.0)
    unit = np.array([np.cos(direction), np.sin(direction)])

    def occupied(at: np.ndarray) -> np.ndarray:
        col, row = np.floor(at.T / 0.05).astype(int)
        inside = (row >= 0) & (col >= 0) & (row < 30) & (col < 40)
        return inside & cells[np.clip(row, 0, 29), np.clip(col, 0, 39)]

    reach = min(r, 3.0)
    samples = np.arange(0.0, reach - 1e-3, 1e-3)
    # Samples nearer than 1e-6 to a cell border may round to either side.
    points = np.array([x, y]) + samples[:, None] * unit
    clear_of_borders = (np.abs((points / 0.05 + 0.5) % 1.0 - 0.5) > 1e-4).all(axis=1)
    assert not occupied(points[clear_of_borders]).any()
    if np.isfinite(r):
        around = np.array([x, y]) + (r + 1e-7) * unit
        corners = [around + np.array([dx, dy]) for dx in (-1e-6, 1e-6) for dy in (-1e-6, 1e-6)]
        assert occupied(np.array(corners)).any()


def test_a_sonar_hears_the_wall_ahead_but_not_the_wall_it_hits_obliquely():
    ranges = heard(corridor(), (0.0, 0.0, 0.0))
    assert ranges[0] == pytest.approx(1.0 - 0.136, abs=0.03)  # 90 deg
    assert ranges[7] == pytest.approx(1.0 - 0.136, abs=0.03)
    assert np.isinf(ranges[[2, 5]]).all()  # 30 deg: 60 deg of incidence


def test_a_map_made_by_standing_still_shows_the_side_walls_and_is_free_where_the_robot_stands():
    built = OccupancyMap(0.05)
    ranges = heard(corridor(), (0.0, 0.0, 0.0))
    for _ in range(20):
        built.integrate(P3AT, (0.0, 0.0, 0.0), ranges)
    built.clear_disc((0.0, 0.0), 0.25)
    assert len(built.occupied_near((0.15, 1.0), 0.1)) > 0
    assert len(built.occupied_near((0.0, 0.0), 0.7)) == 0
    world = built.world()
    assert world.occupancy.shape == built.shape == built.probabilities().shape
    assert world.resolution_m == 0.05
    np.testing.assert_allclose(np.array(world.origin[:2]) / 0.05 % 1.0 % 1.0, 0.0, atol=1e-6)


def test_a_prior_map_keeps_its_shape_and_tells_what_it_did_not_show():
    known = corridor()
    built = OccupancyMap(prior=known)
    assert (built.world().occupancy == known.occupancy).all()
    boxed = known.occupancy.copy()
    boxed[15:25, 80:88] = 1
    ranges = heard(cairn.World(boxed, 0.05, known.origin), (0.5, 0.0, 0.0))
    for _ in range(20):
        built.integrate(P3AT, (0.5, 0.0, 0.0), ranges)
    assert built.shape == known.shape
    found = built.unmapped_near((0.5, 0.0), 3.0)
    assert len(found) >= 3
    assert (np.abs(found[:, 0] - 2.0) < 0.15).all()
    assert built.unmapped().sum() >= len(found)
    assert built.revision > 0


def test_readings_that_cannot_be_are_refused_by_name_with_their_values():
    built = OccupancyMap()
    with pytest.raises(cairn.errors.MappingRangeCount) as caught:
        built.integrate(P3AT, (0, 0, 0), SILENCE[:5])
    assert (caught.value.given, caught.value.expected) == (5, 16)
    with pytest.raises(cairn.errors.MappingPoseNotFinite):
        built.integrate(P3AT, (0, np.nan, 0), SILENCE)
    with pytest.raises(cairn.errors.MappingPoseNotFinite):
        built.integrate(P3AT, (0, 0, np.inf), SILENCE)
    bad = SILENCE.copy()
    bad[7] = -1.0
    with pytest.raises(cairn.errors.MappingRangeNegative) as negative:
        built.integrate(P3AT, (0, 0, 0), bad)
    assert (negative.value.index, negative.value.range_m) == (7, -1.0)
    built.integrate(P3AT, (0, 0, 0), SILENCE)
    with pytest.raises(cairn.errors.MappingTooLarge):
        built.integrate(P3AT, (1e6, 1e6, 0), SILENCE)
    with pytest.raises(cairn.errors.MappingValueOutOfRange) as setting:
        OccupancyMap(config={"sonar_free": -1.0})
    assert setting.value.key == "sonar_free"
    with pytest.raises(cairn.errors.SettingsInvalid, match="unknown field"):
        OccupancyMap(config={"sonar_fre": 1.0})
    with pytest.raises(cairn.errors.RaysShapeMismatch):
        raycast(np.zeros((3, 3), bool), 1.0, (0, 0), [(0, 0, 0)], [0.0])
    with pytest.raises(cairn.errors.RaysShapeMismatch):
        sonar_ranges(np.zeros(3, bool), 1.0, (0, 0), [(0, 0, 0)], 0.5, 5.0)


def wall_with_door() -> cairn.World:
    """4 m x 6 m, a wall 0.15 m thick across at y = 0 with a door 1 m wide at x = 0."""
    cells = np.zeros((120, 80), np.uint8)
    cells[[0, -1], :] = 1
    cells[:, [0, -1]] = 1
    cells[59:62, :30] = 1
    cells[59:62, 50:] = 1
    return cairn.World(cells, 0.05, (-2.0, -3.0, 0.0))


@pytest.mark.parametrize("off_rad", np.radians([-2.0, -1.0, 0.0, 1.0, 2.0]))
@pytest.mark.parametrize("away_m", [1.2, 1.4, 1.6, 2.0])
def test_door_posts_heard_at_the_edge_of_the_cones_leave_the_door_open(away_m, off_rad):
    world = wall_with_door()
    built = OccupancyMap(prior=world)
    believed = (0.0, away_m, -np.pi / 2)
    for _ in range(10):
        built.integrate(P3AT, believed, heard(world, (0.0, away_m, -np.pi / 2 + off_rad)))
        built.integrate(P3AT, believed, heard(world, (off_rad, away_m, -np.pi / 2)))
    assert len(built.unmapped_near((0.0, 0.0), 0.45)) == 0


@pytest.mark.parametrize("away_m", [1.2, 1.5, 1.8])
def test_a_box_in_the_door_is_seen_at_once_from_more_than_a_metre(away_m):
    world = wall_with_door()
    cells = world.occupancy.copy()
    cells[56:65, 34:46] = 1
    blocked = cairn.World(cells, 0.05, (-2.0, -3.0, 0.0))
    built = OccupancyMap(prior=world)
    for tick in range(4):
        pose = (0.0, away_m + 0.225 - 0.04 * tick, -np.pi / 2)
        built.integrate(P3AT, pose, heard(blocked, pose))
    assert len(built.unmapped_near((0.0, 0.2), 0.3)) >= 3


def test_a_crate_beside_a_wall_does_not_close_the_corridor():
    world = corridor(2.0)
    cells = world.occupancy.copy()
    cells[1:10, 80:90] = 1  # x 2.0 to 2.5, y -1.0 to -0.55
    crated = cairn.World(cells, 0.05, (-2.0, -1.05, 0.0))
    built = OccupancyMap(prior=world)
    for x in np.arange(0.0, 1.3, 0.04):
        pose = (float(x), 0.2, 0.0)
        built.integrate(P3AT, pose, heard(crated, pose))
    found = built.unmapped_near((2.1, -0.7), 2.0)
    assert len(found) > 0
    assert found[:, 1].max() < -0.1, "0.45 m to the side of the crate is free"
