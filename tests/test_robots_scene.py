import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import cairn
from cairn.robots import Box, KinematicRobot, Scene
from cairn.robots import rectangles as rect
from cairn.robots.robot import Pose
from robot_contract import EXACT, NOWHERE, P3AT, room

LENGTHS = st.floats(0.05, 3.0)
PLACES = st.floats(-3.0, 3.0)
ANGLES = st.floats(-math.pi, math.pi)
RECTANGLES = st.builds(rect.rectangle, PLACES, PLACES, LENGTHS, LENGTHS, ANGLES)


def outline(rectangle, per_side=400):
    """Many points on the border of a rectangle, (n, 2)."""
    c = rect.corners(rectangle[None])[0]
    t = np.linspace(0, 1, per_side)[:, None]
    return np.vstack([c[i] + t * (c[(i + 1) % 4] - c[i]) for i in range(4)])


def inside(points, rectangle):
    x, y, hl, hw, c, s = rectangle
    dx, dy = points[:, 0] - x, points[:, 1] - y
    return (np.abs(c * dx + s * dy) <= hl) & (np.abs(c * dy - s * dx) <= hw)


@given(arrays(np.bool_, st.tuples(st.integers(1, 14), st.integers(1, 14))))
def test_rectangles_cover_exactly_the_occupied_cells(cells):
    covered = np.zeros_like(cells)
    for r0, c0, r1, c1 in rect.covering(cells):
        assert r0 < r1
        assert c0 < c1
        covered[r0:r1, c0:c1] = True
    assert (covered == cells).all()


def test_a_walled_room_needs_four_rectangles_and_a_cross_two():
    cells = np.ones((30, 40), dtype=bool)
    cells[2:-2, 2:-2] = False
    assert len(rect.covering(cells)) == 4
    cross = np.zeros((21, 21), dtype=bool)
    cross[9:12, :] = cross[:, 9:12] = True
    assert len(rect.covering(cross)) == 2


@settings(max_examples=150, deadline=None)
@given(RECTANGLES, RECTANGLES)
def test_distance_between_rectangles_is_the_least_between_their_points(one, other):
    a, b = outline(one), outline(other)
    distance = rect.distances(one, other[None])[0]
    overlap = inside(a, other).any() or inside(b, one).any()
    if overlap:
        assert distance <= 1e-9
        return
    brute = min(np.sqrt(((p - b) ** 2).sum(axis=1).min()) for p in a[::8])
    assert distance <= brute + 1e-9
    # Points lie at most 3 m / 399 apart, those of `a` eight times that.
    assert distance >= brute - 0.04
    assert distance == pytest.approx(rect.distances(other, one[None])[0], abs=1e-9)


@settings(deadline=None)
@given(RECTANGLES, PLACES, PLACES, ANGLES)
def test_a_ray_enters_a_rectangle_where_it_meets_it_and_not_before(box, x, y, angle):
    origin, direction = np.array([[x, y]]), np.array([[math.cos(angle), math.sin(angle)]])
    (distance,), (cosine,) = rect.cast(origin, direction, box[None])
    assert 0 <= cosine <= 1
    steps = np.linspace(0, 12, 2401)
    along = inside(origin + steps[:, None] * direction, box)
    if along.any():
        assert distance == pytest.approx(steps[along.argmax()], abs=0.0051)
    elif math.isfinite(distance):
        assert not inside(origin + (distance - 1e-6) * direction, box)[0] or distance == 0


def test_walls_stand_where_a_turned_map_says():
    occupancy = np.zeros((4, 6), dtype=np.uint8)
    occupancy[1, 3:5] = 1
    occupancy[3, 0] = 2
    world = SimpleNamespace(occupancy=occupancy, resolution_m=0.5, origin=(10.0, 20.0, math.pi / 2))
    (wall,) = Scene.from_world(world).walls
    # Cells 3..5 along x at 1.5..2.5 m, row 1 at 0.5..1 m; turned left about the corner.
    assert wall[:2] == pytest.approx((10.0 - 0.75, 20.0 + 2.0))
    assert wall[2:] == pytest.approx((0.5, 0.25, 0.0, 1.0))


def test_a_scene_of_a_world_is_where_the_world_is():
    occupancy = np.zeros((8, 8), dtype=np.uint8)
    occupancy[2, 5] = 1
    world = cairn.World(occupancy, 0.25, (1.0, -2.0, 0.4))
    (wall,) = Scene.from_world(world).walls
    assert wall[:2] == pytest.approx(world.point_of((2, 5)))


@pytest.mark.parametrize(("angle", "heard"), [(35.0, True), (45.0, False)])
def test_a_smooth_wall_met_too_flat_is_not_heard(angle, heard):
    """Axis of sonar 3 at 10 deg; a long wall ahead whose normal is `angle` off the axis."""
    turn = math.radians(10 + angle)
    wall = Box(3 * math.cos(turn), 3 * math.sin(turn), 0.2, 60.0, turn)
    robot = KinematicRobot(P3AT, Scene(boxes=(wall,)), (0.0, 0.0, 0.0), noise=EXACT)
    # The cone reaches 15 deg towards the normal, faces echo to 25 deg: heard up to 40 deg.
    assert math.isfinite(robot.sense().ranges_m[3]) == heard


def test_a_corner_is_heard_at_its_distance_though_its_faces_mirror_the_sound_away():
    # A square standing on its edge: faces at 45 deg, the corner straight ahead of sonar 3's cone.
    box = Box(2.0 + math.sqrt(0.5), 0.0, 1.0, 1.0, math.pi / 4)
    robot = KinematicRobot(P3AT, Scene(boxes=(box,)), (0.0, 0.0, 0.0), noise=EXACT)
    expected = math.hypot(2.0 - 0.245, 0.027)
    assert robot.sense().ranges_m[3] == pytest.approx(expected, abs=1e-9)


def test_a_hidden_corner_is_not_heard():
    screen = Box(1.0, 0.0, 0.02, 3.0, 0.0)
    box = Box(3.0, 0.0, 1.0, 1.0, math.pi / 4)
    robot = KinematicRobot(P3AT, Scene(boxes=(screen, box)), (0.0, 0.0, 0.0), noise=EXACT)
    assert robot.sense().ranges_m[3] == pytest.approx(0.99 - 0.245, abs=2e-3)


def test_a_straight_wall_of_several_rectangles_has_no_corners_between_them():
    cells = np.ones((3, 12), dtype=bool)
    cells[2, 4:] = False
    corners = {tuple(c) for c in rect.lattice_corners(cells)}
    assert corners == {(0, 0), (0, 12), (2, 12), (2, 4), (3, 4), (3, 0)}


def test_clearance_of_a_pose_is_to_the_nearest_of_walls_and_boxes():
    scene = room(boxes=[Box(2.0, 0.0, 1.0, 1.0, from_s=99.0)])
    assert scene.clearance_m((0.0, 0.0, 0.0), P3AT.footprint) == pytest.approx(1.5 - 0.313)
    assert NOWHERE.clearance_m((0.0, 0.0, 0.0), P3AT.footprint) == math.inf


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("length_m", 0.0),
        ("width_m", math.nan),
        ("x", math.inf),
        ("until_s", -1.0),
        ("appears_within_m", 0.0),
        ("colour", 1),
    ],
)
def test_an_impossible_box_is_refused_with_its_key(key, value):
    box = {"x": 0.0, "y": 0.0, "length_m": 1.0, "width_m": 1.0} | {key: value}
    with pytest.raises(cairn.errors.BoxOutOfRange) as caught:
        room(boxes=[box])
    assert caught.value.key == key


def test_a_lidar_reads_every_beam_to_the_walls():
    text = P3AT.text.replace(
        "# For a physics engine only",
        "[lidar]\npose = { x = 0.0, y = 0.0, heading = 0.0 }\nbeams = 4\nfirst_rad = 0.0\n"
        "step_rad = 1.5707963267948966\nmin_range_m = 0.1\nmax_range_m = 4.5\n\n"
        "# For a physics engine only",
    )
    profile = cairn.Profile(text)
    ranges = KinematicRobot(profile, room(), (0.0, 0.0, 0.0), noise=EXACT).sense().ranges_m
    assert ranges.shape == (20,)
    assert ranges[16:] == pytest.approx([math.inf, 4.0, math.inf, 4.0])


def pushed(*x, start_s=1.0):
    """A thing of 0.4 m moved along x, a step a second, and taken away."""
    return [
        Box(at, 0.0, 0.4, 0.4, name="trolley", from_s=i and start_s + i, until_s=start_s + i + 1.0)
        for i, at in enumerate(x)
    ]


def stage_of(boxes):
    return Scene.from_world(cairn.World(np.zeros((100, 200), np.uint8)), boxes).stage()


def standing(stage):
    return [stage.scene.boxes[i].x for i in np.flatnonzero(stage.standing)]


def test_a_thing_that_is_moved_stands_in_one_place_at_every_time_and_goes_in_the_end():
    stage = stage_of(pushed(2.0, 2.5, 3.0))
    seen = []
    for tick in range(60):
        stage.update(tick * 0.1, ())
        seen.append(standing(stage))
    assert seen[0] == seen[19] == [2.0]
    assert seen[20] == [2.5]
    assert seen[39] == [3.0]
    assert seen[40:] == [[]] * 20


def test_a_thing_that_is_moved_waits_for_a_robot_and_is_late_by_that():
    stage = stage_of(pushed(2.0, 2.5, 3.0))
    footprint = P3AT.footprint
    in_the_way, away = Pose(2.9, 0.0, 0.0), Pose(9.0, 0.0, 0.0)
    for tick in range(60):
        stage.update(tick * 0.1, [(in_the_way, footprint)])
        assert standing(stage) == [2.0]
    stage.update(6.0, [(away, footprint)])
    assert standing(stage) == [2.5]
    stage.update(6.9, [(away, footprint)])
    assert standing(stage) == [2.5]
    stage.update(7.0, [(away, footprint)])
    assert standing(stage) == [3.0]
