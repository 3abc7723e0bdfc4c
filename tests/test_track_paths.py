"""`cairn track`: the shipped controller beside pure pursuit, on the kinematic P3-AT."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import cairn
from cairn import errors
from cairn.cli import app
from cairn.experiments import track, track_paths, track_tuning
from cairn.experiments.track_design import Design, controller_text, tables
from cairn.experiments.track_drive import Conditions, Drive, measures
from cairn.experiments.track_pursuit import PurePursuit, Regulation
from cairn.robots import Twist
from cairn.tracking import deviations

PROFILE = cairn.Profile.load("p3at")
LINE = track_paths.Reference("line", np.array([(0.0, 0.0), (6.0, 0.0)]), (0.0, 0.0, 0.0))


def circle(radius_m):
    a = np.linspace(0, 2 * math.pi, 2000)
    return np.column_stack([radius_m * np.sin(a), radius_m * (1 - np.cos(a))])


def driven(reference, poses, tick_s=0.1, twists=None):
    poses = np.asarray(poses, float)
    twists = np.zeros((len(poses), 2)) if twists is None else np.asarray(twists, float)
    times_s = np.asarray(np.arange(len(poses)) * tick_s, np.float64)
    return Drive(reference, times_s, poses, twists, twists)


@pytest.fixture(scope="module")
def compared():
    setting = track.Setting()
    return {
        name: track.compare(track_paths.PATHS[name](), setting)["summary"]
        for name in ("sine", "step", "ramp", "squares")
    }


# ---- the aims, at 0.5 m/s with a perfect pose, a loop and a latency of 100 ms -------------------


def test_fig_14_the_sine_is_followed_within_a_centimetre_rms(compared):
    assert compared["sine"]["ours"]["rms_m"] <= 0.010
    assert compared["sine"]["ours"]["rms_in_time_m"] <= 0.010


def test_fig_15_the_step_is_overshot_by_at_most_three_centimetres(compared):
    assert compared["step"]["ours"]["overshoot_m"] <= 0.03


def test_fig_16_the_ramp_is_followed_within_seven_millimetres_rms_after_the_turn(compared):
    assert compared["ramp"]["ours"]["after_turn_rms_m"] <= 0.007


def test_square_corners_are_passed_within_four_centimetres(compared):
    assert compared["squares"]["ours"]["max_m"] <= 0.04


@pytest.mark.parametrize("name", ["sine", "step", "ramp", "squares"])
def test_the_fuzzy_tracker_beats_the_best_pursuit_in_at_most_1_15_of_its_time(compared, name):
    told = compared[name]
    assert told["ours"]["rms_m"] < told["best_baseline"]["rms_m"]
    assert told["ours"]["time_s"] <= 1.15 * told["best_baseline"]["time_s"]
    assert told["ahead"]


def test_round_squares_it_has_a_third_of_the_best_pursuits_error_in_1_2_of_its_time(compared):
    assert compared["squares"]["rms_ratio"] < 1 / 3
    assert compared["squares"]["time_ratio"] <= 1.2


def test_nothing_is_driven_backwards_and_only_the_ramp_needs_a_turn_on_the_spot(compared):
    for name, told in compared.items():
        assert told["ours"]["least_v_mps"] >= 0
        share = told["ours"]["spinning_s"] / told["ours"]["time_s"]
        assert (share > 0.05) == (name == "ramp"), name


# ---- what the paper claims ----------------------------------------------------------------------


def test_waypoints_close_together_are_precise_and_slow_far_apart_fast():
    told = track.sweep(track_paths.zigzag(901), track.Setting())["summary"]
    for by_spacing in told["by_speed"].values():
        times, rms = by_spacing["time_s"], by_spacing["rms_m"]
        assert all(later <= sooner + 0.05 for sooner, later in itertools.pairwise(times))
        assert times[-1] < 0.9 * times[0]
        assert rms[-1] > 1.5 * min(rms[:3])


def test_paths_exchanged_while_driving_are_taken_up_without_a_jump():
    told = track.swap(track.Setting())["summary"]
    assert told["within_limits"]
    assert told["least_v_mps"] >= 0
    assert told["arrival_error_m"] <= 0.03
    assert [piece["max_after_1_5_m"] <= 0.02 for piece in told["pieces"]] == [True] * 3


@pytest.mark.parametrize(
    ("under", "most_m"), [("slip", 0.10), ("carpet", 0.08), ("latency", 0.08), ("late", 0.08)]
)
def test_the_path_is_kept_to_on_slippery_floors_on_carpet_and_when_late(under, most_m):
    for name in ("sine", "squares"):
        run = track.drive_ours(track_paths.PATHS[name](), track.Setting(under=under))
        told = measures(run)
        assert told["reached"]
        assert told["arrival_error_m"] <= 0.06
        assert told["max_m"] <= most_m, name


def test_noise_on_the_pose_is_not_made_worse_than_it_is():
    run = track.drive_ours(track_paths.sine(), track.Setting(under="noise", seed=3))
    told = measures(run)
    assert told["reached"]
    assert told["rms_late_m"] <= 0.02


def test_a_drive_follows_from_its_seed():
    one, same, other = (
        track.drive_ours(LINE, track.Setting(under="noise", seed=seed)).poses for seed in (1, 1, 2)
    )
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_rehearsal_is_what_the_kinematic_robot_then_does():
    reference = track_paths.zigzag(7)
    tracker = cairn.Tracker("p3at", PROFILE, cruise_mps=0.5)
    tracker.follow(reference.path, spacing_m=0.2)
    rehearsed = tracker.rehearse(reference.start)
    run = track.drive_ours(reference)
    n = min(len(run.poses), len(rehearsed.poses))
    assert n > 100
    assert np.allclose(run.poses[:n, :2], rehearsed.poses[:n, :2], atol=1e-6)
    assert np.allclose(run.commands[: n - 1], rehearsed.commands[: n - 1], atol=1e-6)
    assert tracker.index == 0  # the tracker itself has not moved


def test_a_cruising_speed_is_kept_to_and_said():
    tracker = cairn.Tracker("p3at", PROFILE, cruise_mps=0.25)
    tracker.follow(LINE.path)
    assert tracker.rehearse(LINE.start).commands[:, 0].max() == pytest.approx(0.25)
    assert "cruise_speed" in tracker.step((0, 0, 0), (0.25, 0.0), 0.1)["caps"]
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(errors.TrackValueOutOfRange, match="cruise_mps"):
            cairn.Tracker("p3at", PROFILE, cruise_mps=bad)


def test_a_command_that_something_changed_on_its_way_is_predicted_as_it_was_sent():
    ahead = []
    for changed in (False, True):
        tracker = cairn.Tracker("p3at", PROFILE)
        tracker.follow(LINE.path)
        tracker.step((0, 0, 0), (0.4, 0.0), 0.1)
        if changed:
            tracker.overridden((0.4, 1.5))
        ahead.append(tracker.step((0.04, 0, 0), (0.4, 0.0), 0.1)["world_from_robot_ahead"])
    assert abs(ahead[0]["heading"]) < 1e-9
    assert ahead[1]["heading"] > 0.01


# ---- the baselines and the measures -------------------------------------------------------------


@pytest.mark.parametrize("radius_m", [0.8, 1.5, 4.0])
@pytest.mark.parametrize("lookahead_m", [0.3, 0.6, 1.0])
def test_pure_pursuit_on_a_circle_steers_its_curvature(radius_m, lookahead_m):
    follower = PurePursuit(circle(radius_m), lookahead_m, 0.5, PROFILE.limits)
    twist = follower.step((0.0, 0.0, 0.0), Twist(0.5, 0.0), 0.1)
    assert twist.linear_mps == 0.5
    assert twist.angular_radps == pytest.approx(0.5 / radius_m, rel=1e-3)


def test_regulated_pure_pursuit_slows_with_the_radius_down_to_its_least_speed():
    for radius_m, speed in ((2.0, 0.5), (0.72, 0.5 * 0.72 / 0.9), (0.35, 0.25)):
        follower = PurePursuit(circle(radius_m), 0.3, 0.5, PROFILE.limits, regulation=Regulation())
        twist = follower.step((0.0, 0.0, 0.0), Twist(0.5, 0.0), 0.1)
        assert twist.linear_mps == pytest.approx(speed, rel=1e-3)


def test_both_pursuits_turn_on_the_spot_towards_what_is_behind():
    for regulation in (None, Regulation()):
        follower = PurePursuit(LINE.path, 0.5, 0.5, PROFILE.limits, regulation=regulation)
        assert follower.step((0.0, 0.0, 2.5), Twist(0, 0), 0.1) == Twist(0.0, -1.8)


points = st.lists(
    st.tuples(st.floats(-3, 3), st.floats(-3, 3)), min_size=2, max_size=8, unique=True
)


@settings(max_examples=60, deadline=None)
@given(points, st.tuples(st.floats(-4, 4), st.floats(-4, 4)))
def test_with_a_long_reach_deviation_is_the_least_distance_to_the_polyline(path, place):
    path, place = np.array(path), np.array(place)
    ts = np.linspace(0, 1, 400)[:, None]
    dense = np.vstack([a + ts * (b - a) for a, b in itertools.pairwise(path)])
    left_m, along_m = deviations(path, [place], reach_m=1000.0)
    assert abs(left_m[0]) <= np.hypot(*(dense - place).T).min() + 1e-9
    assert abs(left_m[0]) == pytest.approx(np.hypot(*(dense - place).T).min(), abs=0.02)
    assert 0 <= along_m[0] <= np.hypot(*np.diff(path, axis=0).T).sum() + 1e-9


def test_measures_of_a_drive_beside_its_path_are_those_worked_out_by_hand():
    xs = np.arange(0, 6.01, 0.05)
    beside = [(x, 0.03, 0.0) for x in xs]
    told = measures(driven(LINE, beside, twists=[(0.5, 0.0)] * len(xs)))
    assert told["rms_m"] == pytest.approx(0.03)
    assert told["rms_in_time_m"] == pytest.approx(0.03)
    assert told["max_m"] == told["max_late_m"] == pytest.approx(0.03)
    assert told["reached"]
    assert told["time_s"] == pytest.approx(0.1 * np.argmax(np.hypot(xs - 6, 0.03) < 0.1))
    assert told["effort_v_mps"] == 0
    assert told["overshoot_m"] is None


def test_overshoot_is_on_the_other_side_and_settling_is_for_good():
    ys = [1.0, 0.5, 0.1, -0.08, -0.02, 0.06, *[0.0] * 60]
    poses = [(0.1 * i, y, 0.0) for i, y in enumerate(ys)]
    told = measures(driven(LINE, poses))
    assert told["overshoot_m"] == pytest.approx(0.08)
    assert told["settled_s"] == pytest.approx(0.6)


def test_every_metre_counts_the_same_however_slowly_it_was_driven():
    fast = [(x, 0.02, 0.0) for x in np.arange(0, 3, 0.1)]
    slow = [(x, 0.00, 0.0) for x in np.arange(3, 6.001, 0.01)]
    told = measures(driven(LINE, fast + slow))
    assert told["rms_m"] == pytest.approx(0.02 / math.sqrt(2), rel=0.05)
    assert told["rms_in_time_m"] < 0.008


# ---- the design and its tuning ------------------------------------------------------------------


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**31))
def test_every_design_a_tuner_may_try_is_a_drivers(seed):
    unit = np.random.default_rng(seed).uniform(size=len(Design.bounds()))
    design = Design.from_unit(unit).rounded()
    assert np.allclose(design.to_unit(), unit, atol=0.06)
    control = cairn.Tracker(controller_text(design), PROFILE).control
    headings = np.linspace(0, math.pi, 120)
    for speed in (0.0, 0.5):
        for distance in (0.05, 0.2, 0.8):
            left = control.evaluate(C=1.0, Vc=speed, dR=distance, dtheta=headings)
            right = control.evaluate(C=1.0, Vc=speed, dR=distance, dtheta=-headings)
            assert np.allclose(left["omega"], -right["omega"])
            assert (np.diff(left["omega"]) >= -1e-9).all()
            assert (np.diff(left["V"]) <= 1e-9).all()
            assert left["V"].min() >= 0
        bends = control.evaluate(C=np.linspace(0, 5, 40), Vc=speed, dR=0.3, dtheta=0.0)["V"]
        ahead = control.evaluate(C=0.0, Vc=speed, dR=np.linspace(0, 2, 40), dtheta=0.0)["V"]
        assert (np.diff(bends) <= 1e-9).all()
        assert (np.diff(ahead) >= -1e-9).all()


def test_tables_hold_the_numbers_of_the_file():
    worked = tables(Design())
    text = controller_text(Design())
    assert f"Ahead = 0.0, SlightLeft = {worked.turns[1, 0, 0]:.3f}" in text
    assert worked.distances == sorted(worked.distances)


def test_training_paths_are_none_of_the_paths_judged_by():
    judged = [make().path for make in track_paths.PATHS.values()]
    for case in track_tuning.training_cases(1):
        path = case.reference.path
        assert not any(path.shape == other.shape and np.allclose(path, other) for other in judged)


def test_tuning_twice_with_one_seed_finds_the_same_and_nothing_worse():
    pytest.importorskip("cma")
    base = {"rms_m": 0.01, "time_s": 10.0, "effort_v_mps": 1.0, "effort_w_radps": 4.0}
    drawn = [track_tuning.Case(track_paths.turned(5, length_m=3.0), base=base)]
    found = [
        track_tuning.tune(seed=3, evaluations=20, drawn=drawn, workers=workers)
        for workers in (1, 2)
    ]
    assert found[0][0] == found[1][0]
    history = found[0][1]["history"]
    assert history[-1][1] <= history[0][1]
    assert [cost for _, cost in history] == sorted((cost for _, cost in history), reverse=True)


# ---- the command --------------------------------------------------------------------------------


def told_by(*arguments):
    done = CliRunner().invoke(app, ["track", *map(str, arguments)])
    return done.exit_code, done.stdout


def test_the_command_prints_one_json_object_with_a_summary_and_leaves_it_and_a_picture(tmp_path):
    code, printed = told_by("ramp", "--json", "--out", tmp_path)
    assert code == 0
    record = json.loads(printed)
    assert record == json.loads((tmp_path / "summary.json").read_text())
    assert record["summary"]["ours"]["reached"]
    assert record["summary"]["best_baseline"]["lookahead_m"] in track.LOOKAHEADS_M
    assert len(record["baselines"]) == 2 * len(track.LOOKAHEADS_M)
    assert (tmp_path / "ramp.png").stat().st_size > 10_000


def test_the_command_tells_of_a_swap(tmp_path):
    code, printed = told_by("swap", "--out", tmp_path)
    assert code == 0
    assert "within" in printed
    assert (tmp_path / "swap.png").exists()


def test_what_the_command_does_not_know_is_refused_with_what_there_is():
    for arguments, said in (
        (("circle",), "squares"),
        (("sine", "--robot", "car"), "mujoco"),
        (("sine", "--under", "rain"), "carpet"),
    ):
        done = CliRunner().invoke(app, ["track", *arguments])
        assert done.exit_code == 2
        assert said in done.output


def test_conditions_are_all_drivable_and_named():
    for name, (sentence, conditions) in track.CONDITIONS.items():
        assert sentence, name
        assert isinstance(conditions, Conditions), name
