"""What a run leaves behind: a log that reads back to the bit, here and in the tools of others."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import cairn
from cairn import _brain, errors
from cairn.missions import Scenario, run
from cairn.record import Recorder, open_run

STORE = get_typestore(Stores.ROS2_JAZZY)


class Keep:
    """An observer that keeps every tick as it was handed out."""

    def __init__(self):
        self.ticks = []

    def __call__(self, tick):
        self.ticks.append((tick, tick.decision.to_dict()))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A short real run: the folder, the ticks as observers saw them, and the result."""
    folder = tmp_path_factory.mktemp("run")
    keep = Keep()
    with Recorder(folder) as recorder:
        result = run(Scenario.load("quick"), observers=[recorder, keep])
    return folder, keep.ticks, result


def listed(value):
    """Tuples as lists, as JSON has them."""
    if isinstance(value, dict):
        return {key: listed(item) for key, item in value.items()}
    return [listed(item) for item in value] if isinstance(value, list | tuple) else value


def messages(folder, topic):
    """(time [ns], message) of a topic, as an independent reader decodes it."""
    with Reader(folder / "run.mcap") as reader:
        chosen = [each for each in reader.connections if each.topic == topic]
        return [
            (at, STORE.deserialize_cdr(data, each.msgtype))
            for each, at, data in reader.messages(connections=chosen)
        ]


def test_every_tick_reads_back_to_the_bit(recorded):
    folder, seen, _ = recorded
    read = list(open_run(folder).ticks())
    assert len(read) == len(seen)
    for line, (tick, decision) in zip(read, seen, strict=True):
        assert repr(line["decision"]) == repr(listed(decision))
        assert (line["time_s"], line["truth"]) == (tick.time_s, list(tick.truth))
        assert (line["robot"], line["clearance_m"]) == (tick.robot, tick.clearance_m)


def test_the_tick_at_a_time_is_the_last_one_not_after_it(recorded):
    folder, seen, _ = recorded
    made = open_run(folder)
    assert made.at(1.25)["time_s"] == 1.2
    assert made.at(1.2)["time_s"] == 1.2
    assert made.at(1e9)["time_s"] == seen[-1][0].time_s
    assert made.at(-1.0) is None


def test_a_log_says_what_the_run_was_made_of(recorded):
    folder, _, result = recorded
    made = open_run(folder)
    assert made.scenario["name"] == "quick"
    assert (made.seed, made.robots) == (result.seed, ["robot"])
    given = made.map()
    assert np.array_equal(given.occupancy, result.map.occupancy)
    assert (given.resolution_m, given.origin) == (result.map.resolution_m, result.map.origin)
    assert made.complete


def test_the_maps_of_a_run_begin_with_the_given_one_and_end_with_the_last(recorded):
    folder, seen, result = recorded
    times, grids, sides, origins = zip(*open_run(folder).grids(), strict=True)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(seen[-1][0].time_s + 0.1)
    assert set(sides) == {result.map.resolution_m}
    assert origins[0] == pytest.approx(result.map.origin)
    assert (grids[0] != result.map.occupancy).mean() < 0.1


def test_another_reader_finds_ros_messages_with_the_values_of_the_run(recorded):
    folder, seen, _ = recorded
    for (at, odometry), (tick, decision) in zip(messages(folder, "/robot/odom"), seen, strict=True):
        pose = odometry.pose.pose
        assert at == round(tick.time_s * 1e9)
        assert at == odometry.header.stamp.sec * 10**9 + odometry.header.stamp.nanosec
        assert (pose.position.x, pose.position.y) == (decision["pose"]["x"], decision["pose"]["y"])
        heading = 2 * np.arctan2(pose.orientation.z, pose.orientation.w)
        assert heading == pytest.approx(decision["pose"]["heading"], abs=1e-12)
        assert odometry.twist.twist.linear.x == decision["measured"]["linear_mps"]
        assert odometry.pose.covariance[35] == decision["covariance"][2][2]
    commands = [message.twist for _, message in messages(folder, "/robot/cmd_vel")]
    assert [(each.linear.x, each.angular.z) for each in commands] == [
        tuple(tick.decision.twist) for tick, _ in seen
    ]


def test_another_reader_finds_every_echo(recorded):
    folder, _, _ = recorded
    steps = [line for line in open_run(folder).inputs() if line["call"] == "step"]
    for number in (0, 3, 7):
        told = [line["ranges_m"][number] for line in steps]
        told = [value for value in told if not np.isnan(value)]
        heard = [message.range for _, message in messages(folder, f"/robot/sonar_{number}")]
        assert np.array_equal(np.float32(told), np.float32(heard))


def test_another_reader_finds_the_map_the_path_and_the_text(recorded):
    folder, _, result = recorded
    (_, grid), *_ = messages(folder, "/robot/map")
    assert grid.data.reshape(grid.info.height, grid.info.width).shape == result.map.shape
    assert np.isin(grid.data, (-1, 0, 100)).all()
    (_, path), *_ = messages(folder, "/robot/path")
    assert len(path.poses) > 2
    said = [message.msg for _, message in messages(folder, "/rosout")]
    assert any("arrived" in line for line in said)
    frames = {
        (each.header.frame_id, each.child_frame_id)
        for _, message in messages(folder, "/tf_static")
        for each in message.transforms
    }
    assert ("robot/base_link", "robot/sonar_15") in frames


def test_our_message_definitions_are_those_of_ros(recorded):
    folder, _, _ = recorded
    with Reader(folder / "run.mcap") as reader:
        found = {each.msgtype: each.msgdef.data for each in reader.connections}
    ours = {name: text for name, text in found.items() if text}
    assert len(ours) >= 9
    for name, text in ours.items():
        for kind, (_, fields) in get_types_from_msg(text, name).items():
            assert fields == STORE.fielddefs[kind][1], kind


def test_two_logs_of_one_seed_say_the_same(recorded, tmp_path):
    folder, _, _ = recorded
    with Recorder(tmp_path) as recorder:
        run(Scenario.load("quick"), observers=[recorder])

    def content(where):
        return list(cairn._brain.LogReader(where / "run.mcap"))

    assert content(tmp_path) == content(folder)


DRIVER = """
import sys, time
from pathlib import Path
from cairn.missions import Scenario, run
from cairn.record import Recorder

def tell(tick):
    print(tick.time_s, flush=True)
    time.sleep(0.02)

with Recorder(Path(sys.argv[1])) as recorder:
    run(Scenario.load("quick"), observers=[recorder, tell])
"""


@pytest.mark.parametrize("after_s", [0.5, 1.13])
def test_a_killed_run_loses_less_than_its_last_second(tmp_path, after_s):
    child = subprocess.Popen(
        [sys.executable, "-c", DRIVER, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    told = [(float(child.stdout.readline()), time.monotonic())]
    while told[-1][1] - told[0][1] < after_s:
        told.append((float(child.stdout.readline()), time.monotonic()))
    os.kill(child.pid, signal.SIGKILL)
    killed = time.monotonic()
    child.communicate()
    assert child.returncode == -signal.SIGKILL
    made = open_run(tmp_path)
    last_s = [tick["time_s"] for tick in made.ticks()][-1]
    lost = [at for time_s, at in told if time_s > last_s]
    assert all(killed - at < 1.0 for at in lost)
    assert not made.complete
    assert made.summary is None


def test_a_run_cut_off_anywhere_reads_as_far_as_it_goes(recorded, tmp_path):
    folder, seen, _ = recorded
    whole = (folder / "run.mcap").read_bytes()
    counts = []
    for share in np.linspace(0.05, 0.999, 40):
        (tmp_path / "run.mcap").write_bytes(whole[: int(share * len(whole))])
        try:
            counts.append(len(list(open_run(tmp_path).ticks())))
        except errors.LogUnreadable:
            counts.append(0)
    assert counts == sorted(counts)
    assert counts[-1] == len(seen)


@pytest.mark.parametrize("content", [b"", b"no log", b"\x89MCAP0\r\n" + bytes(200)])
def test_what_is_no_log_is_refused_with_its_name(tmp_path, content):
    (tmp_path / "run.mcap").write_bytes(content)
    with pytest.raises(errors.LogUnreadable, match=r"run\.mcap"):
        list(open_run(tmp_path).ticks())


def test_an_unknown_robot_is_refused_with_those_there_are(recorded):
    folder, _, _ = recorded
    with pytest.raises(errors.RobotUnknown, match="robot"):
        list(open_run(folder).ticks("marvin"))


def test_a_log_where_none_can_be_written_is_refused(tmp_path):
    (tmp_path / "run.mcap").mkdir()
    with pytest.raises(errors.LogUnwritable, match=r"run\.mcap"):
        Recorder(tmp_path)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_full_disk_is_said_and_not_passed_over(tmp_path):
    (tmp_path / "run.mcap").symlink_to("/dev/full")
    with pytest.raises(errors.LogUnwritable), Recorder(tmp_path) as recorder:
        run(Scenario.load("quick"), observers=[recorder])


def test_navigators_that_somebody_else_drives_are_recorded_too(tmp_path):
    nav = cairn.Navigator("p3at", cairn.maps.load("room"), start=(1.0, 1.0, 0.0))
    with Recorder(tmp_path) as recorder:
        recorder.follow({"mine": nav})
        nav.set_goal((2.0, 1.0))
        for _ in range(3):
            nav.step(np.full(16, np.inf), (0.0, 0.0), 0.0, 0.1)
    made = open_run(tmp_path)
    assert [line["truth"] for line in made.ticks("mine")] == [None] * 3
    assert [line["call"] for line in made.inputs()] == ["set_goal", "step", "step", "step"]


def test_a_new_recording_leaves_no_summary_of_the_old_run(tmp_path):
    (tmp_path / "summary.json").write_text(json.dumps({"summary": {}}))
    Recorder(tmp_path).close()
    assert not (tmp_path / "summary.json").exists()


def test_robots_whose_names_differ_in_a_sign_have_topics_of_their_own(tmp_path):
    names = ["a-1", "a_1", "a 1"]
    robots = {name: cairn.Navigator("p3at") for name in names}
    ranges = np.full(cairn.Profile.load("p3at").range_count, np.inf)
    with Recorder(tmp_path) as recorder:
        recorder.follow(robots)
        for number, nav in enumerate(robots.values()):
            for _ in range(number + 1):
                nav.step(ranges, (0.0, 0.0), 0.0, 0.1)
    made = open_run(tmp_path)
    for number, name in enumerate(names):
        assert [line["robot"] for line in made.ticks(name)] == [name] * (number + 1)
        assert len(list(made.inputs(name))) == number + 1
        assert len(list(made.grids(name))) >= 1
    with Reader(tmp_path / "run.mcap") as reader:
        topics = {each.topic for each in reader.connections}
    assert {"/a_1/pose", "/a_1_2/pose", "/a_1_3/pose"} <= topics


def test_a_robot_that_is_not_recorded_is_refused_and_the_log_goes_on(tmp_path):
    recorder = _brain.Recorder(tmp_path / "run.mcap")
    with pytest.raises(errors.RecordedRobotUnknown) as caught:
        recorder.judged(7, 0.0, (0.0, 0.0, 0.0), 1.0)
    assert (caught.value.number, caught.value.robots) == (7, 0)
    recorder.attach("run.json", "application/json", b"{}")
    recorder.finish()
