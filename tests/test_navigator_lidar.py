"""Driving by lidar where no map is given: in worlds of the benchmark's own generator."""

import math

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.experiments.nav import trial
from cairn.experiments.nav.generator import generated

JACKAL = cairn.Profile.load("jackal")


def still(navigator, ranges):
    return navigator.step(ranges, (0.0, 0.0), None, 0.05)


def open_place():
    return np.full(JACKAL.range_count, math.inf)


@pytest.mark.parametrize("number", [2, 7, 11])
def test_worlds_never_seen_are_crossed_without_a_touch_at_a_metre_a_second(number):
    run = trial.drive("cairn", generated(number), 0, 1)
    assert run.outcome == "success", run.to_dict()
    assert run.score > 0.45


def test_a_goal_is_driven_to_at_once_and_the_field_says_how_long_it_takes():
    navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    navigator.set_goal((6.0, 0.0))
    for _ in range(6):
        decision = still(navigator, open_place())
    record = decision.to_dict()
    assert decision.mode == "obstacle_avoidance"
    assert decision.twist[0] > 0
    assert record["avoidance"]["why"]["kind"] == "best_arc"
    assert 6.0 / 2.0 < record["avoidance"]["guided"]["to_go_s"] < 6.0


def test_a_wall_ahead_with_a_gap_to_the_left_is_left_of_in_the_direction_of_the_field():
    lidar = JACKAL.lidar
    angles = lidar.first_rad + lidar.step_rad * np.arange(lidar.beams)
    ranges = np.full(lidar.beams, math.inf)
    ahead = np.abs(angles) < 1.2
    ranges[ahead] = 2.0 / np.cos(angles[ahead])
    y = ranges * np.sin(angles)
    ranges[ahead & (y > 1.0)] = math.inf
    navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    navigator.set_goal((6.0, 0.0))
    for _ in range(3):
        decision = still(navigator, ranges)
    record = decision.to_dict()["avoidance"]
    assert record["goal_bearing_rad"] > 0.2
    assert len(navigator.lidar_points) > 20


def test_two_navigators_of_the_same_inputs_decide_the_same_bits():
    def decisions():
        navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
        navigator.set_goal((6.0, 1.0))
        ranges = open_place()
        ranges[300:330] = 1.5
        return [still(navigator, ranges).to_json() for _ in range(5)]

    assert decisions() == decisions()


def test_an_unknown_setting_of_the_lidar_is_refused_by_name():
    with pytest.raises(errors.SettingsInvalid, match="fiield"):
        cairn.Navigator(JACKAL, config={"lidar": {"fiield": {}}})


def test_a_setting_of_the_guided_method_out_of_range_is_refused():
    with pytest.raises(errors.AvoidanceValueOutOfRange, match="horizon_m"):
        cairn.Navigator(JACKAL, config={"lidar": {"avoidance": {"horizon_m": -1.0}}})


SPOKES = JACKAL.lidar.first_rad + JACKAL.lidar.step_rad * np.arange(JACKAL.lidar.beams)


def scan(pose, discs):
    """Exact ranges of the Jackal's lidar at `pose` among discs (x, y, radius)."""
    x, y, heading = pose
    ahead_m = JACKAL.lidar.pose.x
    x, y = x + ahead_m * math.cos(heading), y + ahead_m * math.sin(heading)
    ranges = np.full(JACKAL.lidar.beams, math.inf)
    for disc_x, disc_y, radius in discs:
        angle, away = math.atan2(disc_y - y, disc_x - x), math.hypot(disc_x - x, disc_y - y)
        off = SPOKES + heading - angle
        along, half2 = away * np.cos(off), radius**2 - (away * np.sin(off)) ** 2
        hit = (half2 >= 0) & (along > 0)
        ranges[hit] = np.minimum(ranges[hit], along[hit] - np.sqrt(half2[hit]))
    return ranges


class Rover:
    """A robot without noise that turns `slip` times what it is told, its lidar among discs."""

    def __init__(self, goal, slip=1.0, gyro=False, profile=JACKAL, **options):
        self.nav = cairn.Navigator(profile, start=(0.0, 0.0, 0.0), **options)
        self.nav.set_goal(goal)
        self.pose, self.twist, self.told = (0.0, 0.0, 0.0), (0.0, 0.0), (0.0, 0.0)
        self.slip, self.gyro, self.time_s, self.profile = slip, gyro, 0.0, profile

    def tick(self, discs=(), dt_s=0.05):
        """What wheels and gyroscope told since the last tick in; the next command out."""
        (v, w), limits = self.told, self.profile.limits
        at = [
            min(max(want, now - most * dt_s), now + most * dt_s)
            for want, now, most in zip(
                (v, w * self.slip),
                self.twist,
                (limits.linear_mps2, limits.angular_radps2),
                strict=True,
            )
        ]
        x, y, heading = self.pose
        middle = heading + at[1] * dt_s / 2
        self.pose = (
            x + at[0] * dt_s * math.cos(middle),
            y + at[0] * dt_s * math.sin(middle),
            heading + at[1] * dt_s,
        )
        self.twist = tuple(at)
        half = at[1] / self.slip * self.profile.drive.effective_track_m / 2
        wheels = ((at[0] - half) * dt_s, (at[0] + half) * dt_s)
        decision = self.nav.step(scan(self.pose, discs), wheels, at[1] if self.gyro else None, dt_s)
        self.told = decision.twist
        self.time_s += dt_s
        return decision


def slow_turner(slip, tmp_path, most_radps):
    """Decisions of a Jackal with a gyroscope that zigzags, turning `slip` times what it is told."""
    text = JACKAL.text.replace("angular_radps = 4.0", f"angular_radps = {most_radps}")
    (tmp_path / "rover.toml").write_text(text)
    rover = Rover((2.0, 2.0), slip, gyro=True, profile=cairn.Profile.load(tmp_path / "rover.toml"))
    decisions = []
    for leg in range(24):
        x, y, heading = rover.pose
        aside = heading + (1.3 if leg % 2 else -1.3)
        rover.nav.set_goal((x + 4 * math.cos(aside), y + 4 * math.sin(aside)))
        decisions += [rover.tick() for _ in range(40)]
    return decisions


def test_the_command_makes_the_chosen_motion_once_a_gyroscope_has_told_how_wheels_slip(tmp_path):
    slip, compared = 0.8, 0
    for decision in slow_turner(slip, tmp_path, 4.0)[-400:]:
        chosen = decision.to_dict()["avoidance"] or {}
        if chosen.get("chosen") is None:
            continue
        real = chosen["candidates"][chosen["chosen"]]["twist"]["angular_radps"]
        if abs(real) > 0.2:
            assert slip * decision.twist[1] == pytest.approx(real, rel=0.06)
            compared += 1
    assert compared > 20


def test_no_command_of_a_robot_that_turns_less_than_told_is_beyond_the_limits(tmp_path):
    rates = [abs(decision.twist[1]) for decision in slow_turner(0.75, tmp_path, 1.0)]
    assert 0.9 < max(rates) <= 1.0


def test_it_backs_no_faster_than_it_backs_out_from_what_comes_at_it_where_its_lidar_is_blind():
    slowest = 0.0
    for aside in (0.0, 0.2, -0.3):
        rover = Rover((12.0, 0.0))
        walls = [(x, y, 0.1) for x in np.arange(-2, 14, 0.19) for y in (-1.1, 1.1)]
        for k in range(110):
            slowest = min(
                slowest, rover.tick([*walls, (7.0 - 1.5 * 0.05 * k, aside, 0.5)]).twist[0]
            )
    backing = cairn.Navigator.default_config()["lidar"]["avoidance"]["backing_speed_mps"]
    assert -backing - 1e-9 <= slowest < -0.1


def test_the_covariance_of_a_pose_that_scans_correct_is_not_the_starts():
    rover = Rover((6.0, 0.0))
    posts = [(x, y, 0.1) for x in range(-2, 9) for y in (-2.0, 2.0)]
    decisions = [rover.tick(posts) for _ in range(60)]
    xx, yy = (decisions[-1].to_dict()["covariance"][i][i] for i in (0, 1))
    assert xx > 1e-6
    assert yy > 1e-6
    given = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    decision = given.step(scan((0.5, 0, 0), posts), (0.5, 0.5), None, 0.05, (0.5, 0.0, 0.0))
    assert not np.any(decision.to_dict()["covariance"])


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ({"map": {"persistence": 0}}, "lidar.map.persistence"),
        ({"map": {"resolution_m": 0.0}}, "lidar.map.resolution_m"),
        ({"map": {"reach_m": math.inf}}, "lidar.map.reach_m"),
        ({"field": {"comfort_m": math.inf}}, "lidar.field.comfort_m"),
        ({"field": {"near_mps": 0.0}}, "lidar.field.near_mps"),
        ({"motion": {"gap_m": math.nan}}, "lidar.motion.gap_m"),
        ({"motion": {"follow": 2.0}}, "lidar.motion.follow"),
        ({"matching": {"robust_m": 0.0}}, "lidar.matching.robust_m"),
        ({"matching": {"returns": 0}}, "lidar.matching.returns"),
        ({"patience_s": math.nan}, "lidar.patience_s"),
    ],
)
def test_a_setting_of_the_lidar_out_of_range_is_refused_before_the_drive(setting, key):
    with pytest.raises(errors.NavigatorValueOutOfRange) as caught:
        cairn.Navigator(JACKAL, config={"lidar": setting})
    assert caught.value.key == key


@pytest.mark.parametrize(
    "setting",
    [
        {"guided": {"window_s": math.nan}},
        {"guided": {"braking_share": 0.0}},
        {"moving": {"foresight_s": math.inf}},
        {"moving": {"speeds_mps": [0.5, math.inf]}},
        {"moving": {"bends_s": []}},
    ],
)
def test_a_setting_of_the_ways_to_choose_out_of_range_is_refused_by_its_key(setting):
    ((part, values),) = setting.items()
    with pytest.raises(errors.AvoidanceValueOutOfRange) as caught:
        cairn.Navigator(JACKAL, config={"lidar": {"avoidance": setting}})
    assert f"{part}.{next(iter(values))}" in caught.value.key


def test_a_persistence_as_great_as_can_be_is_driven_with():
    nav = cairn.Navigator(
        JACKAL, start=(0.0, 0.0, 0.0), config={"lidar": {"map": {"persistence": 255}}}
    )
    nav.set_goal((6.0, 0.0))
    for _ in range(300):
        still(nav, scan((0, 0, 0), [(2.0, 1.0, 0.2)]))
    assert len(nav.lidar_points) > 0


@pytest.mark.parametrize("far", [(5.1e5, 5.4e6), (1e300, -1e300)])
def test_a_goal_at_the_end_of_the_world_is_headed_for_by_lidar_and_does_no_harm(far):
    rover = Rover(far, config={"lidar": {"patience_s": 1.0}})
    posts = [(1.5 * math.cos(k / 12), 1.5 * math.sin(k / 12), 0.1) for k in range(76)]
    decisions = [rover.tick(posts) for _ in range(120)]
    assert all(np.isfinite(decision.twist).all() for decision in decisions)
    assert decisions[-1].to_dict()["status"] == {
        "code": "refused",
        "refusal": {"code": "goal_outside_map"},
    }


def test_a_lidar_robot_held_by_what_it_does_not_see_feels_it_before_itself_not_beside():
    walls = [(x, y, 0.1) for x in np.arange(-2, 4, 0.19) for y in (-1.5, 1.5)]
    walls += [(x, y, 0.1) for x in (-2, 4) for y in np.arange(-1.5, 1.5, 0.19)]
    nav = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    nav.explore()
    ranges, (v, w) = scan((0.0, 0.0, 0.0), walls), (0.0, 0.0)
    for _ in range(400):
        half = w * JACKAL.drive.effective_track_m / 2
        decision = nav.step(ranges, ((v - half) * 0.05, (v + half) * 0.05), None, 0.05)
        v, w = decision.twist
        if decision.recovery and decision.recovery["cause"]["code"] == "wheels_spin":
            break
    else:
        raise AssertionError("never held")
    # Scans have told meanwhile that it stands, whatever the wheels said.
    x, y, heading = nav.step(ranges, (0.0, 0.0), None, 0.05).pose
    assert math.hypot(x, y) < 0.1
    seen = nav.map()
    rows, cols = np.nonzero(seen.occupancy == 1)
    points = np.array([seen.point_of((r, c)) for r, c in zip(rows, cols, strict=True)]) - (x, y)
    ahead = points @ (math.cos(heading), math.sin(heading))
    aside = points @ (-math.sin(heading), math.cos(heading))
    assert not ((np.abs(ahead) < 0.2) & (np.abs(aside) < 0.4)).any()
    assert ((ahead > 0.2) & (ahead < 0.4) & (np.abs(aside) < 0.2)).sum() > 4
