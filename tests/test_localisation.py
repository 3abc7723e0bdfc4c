import math
from pathlib import Path

import numpy as np
import pytest

import cairn
from cairn.experiments.bench_localise import twin_corridor
from cairn.experiments.streams import lidar_robot, off, record, sonar_robot
from cairn.localisation import Localiser, MonteCarlo
from cairn.missions.reading import parse

P3AT = sonar_robot()
ROOM = cairn.maps.load("room")


@pytest.fixture(scope="module")
def drive():
    return record(ROOM, P3AT, seed=3, seconds=40)


@pytest.fixture(scope="module")
def elsewhere():
    return record(ROOM, P3AT, seed=8, seconds=40)


def play(localiser, stream):
    """[(is found, off [m], off [rad], report)] tick by tick."""
    rows = []
    for k in range(len(stream)):
        report = localiser.step(
            stream.ranges_m[k], stream.wheels_m[k], float(stream.gyro_radps[k]), 0.1
        )
        rows.append((report.is_found, *off(localiser.pose, stream.truth[k]), report))
    return rows


def test_a_robot_that_may_be_anywhere_finds_itself_and_is_right_from_then_on(drive):
    rows = play(Localiser(ROOM, P3AT), drive)
    first = next(k for k, row in enumerate(rows) if row[0])
    assert 0 < first < 200
    assert rows[0][3].searched > 10_000
    assert all(row[0] for row in rows[first:])
    assert max(row[1] for row in rows[first:]) < 0.15
    assert max(row[2] for row in rows[first:]) < 0.1
    assert rows[first][3].jump is not None


def test_one_seed_gives_the_same_bits_and_another_others(drive):
    def poses(seed):
        localiser = Localiser(ROOM, P3AT, seed=seed)
        play(localiser, drive.part(0, 60))
        return np.column_stack(localiser.particles).tobytes()

    assert poses(1) == poses(1)
    assert poses(1) != poses(2)


def test_a_kidnapped_robot_notices_and_finds_itself_again(drive, elsewhere):
    start = drive.truth[0]
    rows = play(Localiser(ROOM, P3AT, start=start), drive.part(0, 80).then(elsewhere))
    assert all(row[0] for row in rows[:80])
    assert not all(row[0] for row in rows[80:180])  # 10 s
    assert all(row[0] and row[1] < 0.2 for row in rows[-50:])


def test_a_pose_kept_till_now_is_not_left_for_one_that_unmapped_boxes_make_likelier():
    stream = record(ROOM, P3AT, seed=21003, seconds=60, boxes=6)
    rows = play(Localiser(ROOM, P3AT, start=stream.truth[0]), stream)
    assert all(row[0] and row[1] < 0.1 for row in rows)


@pytest.mark.parametrize("aside", range(0, 360, 90))
def test_a_start_told_wrong_by_a_quarter_metre_and_five_degrees_is_put_right(drive, aside):
    x, y, heading = drive.truth[0]
    dx, dy = 0.25 * math.cos(math.radians(aside)), 0.25 * math.sin(math.radians(aside))
    told = (x + dx, y + dy, heading + math.copysign(math.radians(5), aside - 100))
    rows = play(Localiser(ROOM, P3AT, start=told), drive.part(0, 150))
    assert max(row[1] for row in rows[100:]) < 0.1
    assert max(row[2] for row in rows[100:]) < 0.04


@pytest.mark.parametrize("world", [cairn.maps.load("hall"), twin_corridor()], ids=lambda w: w.name)
def test_where_places_look_alike_no_pose_is_vouched_for(world):
    stream = record(world, P3AT, seed=2, seconds=40)
    rows = play(Localiser(world, P3AT), stream)
    assert not any(row[0] for row in rows)


def test_a_drive_through_another_world_is_not_believed(drive):
    rows = play(Localiser(cairn.maps.load("dead_end"), P3AT), drive)
    assert not any(row[0] for row in rows)


@pytest.mark.parametrize("drawn", ["office", "warehouse"])
def test_a_lidar_in_another_world_is_never_told_that_it_is_on_this_map(drawn):
    robot = lidar_robot()
    stream = record(cairn.maps.load("labyrinth"), robot, seed=3, seconds=25)
    rows = play(Localiser(cairn.maps.load(drawn), robot), stream)
    assert not any(row[0] for row in rows)


def test_a_kidnapped_robot_finds_itself_in_a_labyrinth_where_many_places_look_alike():
    world = cairn.maps.load("labyrinth")
    before, after = (record(world, P3AT, seed=seed, seconds=40, boxes=6) for seed in (4, 504))
    rows = play(Localiser(world, P3AT, start=before.truth[0]), before.part(0, 100).then(after))
    assert all(row[0] and row[1] < 0.2 for row in rows[-30:])
    vouched_again = [
        row for k, row in enumerate(rows) if k > 100 and row[0] and lost_before(rows, k)
    ]
    assert all(row[1] < 0.3 for row in vouched_again)


def lost_before(rows, k):
    """Whether the pose was given up after the kidnapping at tick 100 and before tick k."""
    return not all(row[0] for row in rows[100:k])


def test_a_lidar_finds_itself_too():
    robot = lidar_robot()
    stream = record(ROOM, robot, seed=4, seconds=20)
    rows = play(Localiser(ROOM, robot), stream)
    assert rows[-1][0]
    assert rows[-1][1] < 0.05


def test_turning_the_map_in_the_world_turns_the_estimate(drive):
    turn, shift = 0.7, np.array([3.0, -2.0])
    c, s = math.cos(turn), math.sin(turn)
    x, y, yaw = ROOM.origin
    origin = (c * x - s * y + shift[0], s * x + c * y + shift[1], yaw + turn)
    turned = cairn.World(ROOM.occupancy, ROOM.resolution_m, origin)
    plain, other = MonteCarlo(ROOM, P3AT, seed=5), MonteCarlo(turned, P3AT, seed=5)
    for poses in (plain, other):
        poses.search(drive.ranges_m[50])
        for k in range(50, 60):
            poses.predict((0.05, 0.0, 0.02))
            poses.update(drive.ranges_m[k])
    expected, found = plain.estimate, other.estimate
    assert expected is not None
    assert found is not None
    x, y, heading = expected.pose
    np.testing.assert_allclose(
        found.pose[:2], (c * x - s * y + shift[0], s * x + c * y + shift[1]), atol=1e-5
    )
    assert math.remainder(found.pose[2] - heading - turn, math.tau) == pytest.approx(0, abs=1e-6)
    assert found.share == pytest.approx(expected.share)


def test_there_are_as_many_poses_as_the_spread_needs_and_their_weights_sum_to_one(drive):
    settings = MonteCarlo.default_config()
    poses = MonteCarlo(ROOM, P3AT)
    assert poses.estimate is None
    poses.search(drive.ranges_m[0])
    many = len(poses.particles[1])
    assert many == settings["most_particles"]
    poses.spread(drive.truth[0], 0.05, 0.02)
    poses.predict((0.1, 0.0, 0.0))
    assert poses.is_due
    assert poses.update(drive.ranges_m[0]) > 4
    assert not poses.is_due
    where, weights = poses.particles
    assert settings["least_particles"] <= len(weights) < many
    assert where.shape == (len(weights), 3)
    assert weights.sum() == pytest.approx(1.0)


def test_a_pose_is_likelier_where_the_ranges_were_taken_than_aside_or_behind_a_wall(drive):
    poses = MonteCarlo(ROOM, P3AT)
    better = 0
    for k in range(0, 300, 10):
        x, y, heading = drive.truth[k]
        here = poses.likelihood((x, y, heading), drive.ranges_m[k])
        asides = [(x + 0.4, y, heading), (x, y - 0.4, heading), (x, y, heading + 0.6)]
        better += all(here > poses.likelihood(aside, drive.ranges_m[k]) for aside in asides)
    assert better >= 27
    assert poses.likelihood((3.25, 0.5, 0.0), drive.ranges_m[0]) == -math.inf


def test_what_cannot_be_used_is_refused_by_name():
    with pytest.raises(cairn.errors.LocaliseMapEmpty):
        Localiser(cairn.World(np.zeros((9, 9), np.uint8), 0.1), P3AT)
    with pytest.raises(cairn.errors.LocaliseValueOutOfRange) as caught:
        MonteCarlo(ROOM, P3AT, config={"stray": 2.0})
    assert (caught.value.key, caught.value.value) == ("stray", 2.0)
    with pytest.raises(cairn.errors.LocaliseValueOutOfRange):
        Localiser(ROOM, P3AT, config={"found_share": -1.0})
    with pytest.raises(cairn.errors.SettingsInvalid):
        Localiser(ROOM, P3AT, config={"particles": 7})
    poses = MonteCarlo(ROOM, P3AT)
    with pytest.raises(cairn.errors.LocaliseRangeCount):
        poses.search([1.0, 2.0])
    with pytest.raises(cairn.errors.LocaliseInputNotFinite):
        poses.spread((0.0, math.nan, 0.0))
    with pytest.raises(cairn.errors.LocaliseInputNotFinite):
        poses.predict((math.inf, 0.0, 0.0))
    full = cairn.World(np.ones((40, 40), np.uint8), 0.05)
    with pytest.raises(cairn.errors.LocaliseNoRoom):
        MonteCarlo(full, P3AT).search(np.full(16, 1.0))
    text = P3AT.text
    blind = text[: text.index("[[sonars]]")] + text[text.index("[physics]") :]
    with pytest.raises(cairn.errors.LocaliseNoSensor):
        Localiser(ROOM, cairn.Profile(blind))


def test_a_robot_hemmed_in_by_things_no_map_shows_keeps_its_pose(drive):
    localiser = Localiser(ROOM, P3AT, start=drive.truth[0])
    play(localiser, drive.part(0, 30))
    for _ in range(150):
        report = localiser.step(np.full(16, 0.35), (0.0, 0.0), 0.0, 0.1)
        assert report.is_found
        assert report.jump is None
    assert report.fit < 0.2


LOST = """
name = "lost"
map = "room"
robot = "kinematic"
timeout_s = 200.0
start = { place = "start", known = false }
goals = [{ place = "goal" }]
"""
CARRIED = """
name = "carried"
map = "room"
robot = "kinematic"
timeout_s = 200.0
start = { place = "start" }
goals = [{ place = "goal" }]
events = [{ do = "shove", at_distance_m = 1.0, dx_m = 1.84, dy_m = -1.7, dheading_rad = 0.8 }]
"""


@pytest.mark.parametrize("text", [LOST, CARRIED], ids=["lost", "carried"])
def test_a_mission_goes_on_once_the_robot_knows_where_it_is(text):
    result = cairn.missions.run(parse(text, Path("mission.toml")), seed=2)
    assert result.scenario.pose == "localised"
    assert result.reached, result.sentence
    assert result.contacts == 0
    assert result.robots[0].drift_end_m < 0.1
    if "known = false" in text:
        assert result.robots[0].drift_max_m > 0.3  # its own frame, at first
