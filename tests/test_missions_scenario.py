from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cairn.errors import ScenarioInvalid, ScenarioNotFound
from cairn.missions import Scenario
from cairn.missions.reading import parse

GOOD = """\
name = "there-and-back"
map = "room"
robot = "kinematic"

[start]
x_m = 1.0
y_m = 1.0

[[goals]]
place = "window"

[[goals]]
x_m = 1.0
y_m = 2.0
expect = "refused"

[[boxes]]
x_m = 3.0
y_m = 3.0
length_m = 0.5
width_m = 0.5

[[events]]
do = "shove"
at_s = 3.0
dy_m = 1.0
"""


def refusal(text: str) -> ScenarioInvalid:
    with pytest.raises(ScenarioInvalid) as caught:
        parse(text, Path("mission.toml"))
    return caught.value


def test_a_scenario_reads_with_its_defaults():
    scenario = parse(GOOD, Path("mission.toml"))
    assert scenario.pose is None  # localised where the map shows something
    assert scenario.arrival_tolerance_m == 0.3
    assert [goal.expect for goal in scenario.goals] == ["reached", "refused"]
    assert scenario.events[0].do == "shove"


def test_the_config_hash_ignores_the_seed_and_nothing_else():
    scenario = parse(GOOD, Path("mission.toml"))
    reseeded = parse("seed = 7\n" + GOOD, Path("mission.toml"))
    noisier = parse("noise = 2.0\n" + GOOD, Path("mission.toml"))
    assert scenario.config_hash() == reseeded.config_hash() != noisier.config_hash()


def test_a_missing_scenario_is_refused_with_the_names_there_are():
    with pytest.raises(ScenarioNotFound, match="nowhere"):
        Scenario.load("nowhere")


def test_text_that_is_not_toml_is_refused_with_its_line():
    error = refusal('name = "x"\nmap = = "room"\n')
    assert (error.line, error.key) == (2, "")
    assert str(error).startswith("mission.toml:2: ")


def test_a_truncated_file_is_refused_with_its_line():
    error = refusal('name = "x"\ngoals = [\n')
    assert error.line == 3


def test_bytes_that_are_not_text_are_refused(tmp_path):
    (tmp_path / "mission.toml").write_bytes(b'name = "\xff"')
    with pytest.raises(ScenarioInvalid, match="UTF-8"):
        Scenario.load(tmp_path / "mission.toml")


@pytest.mark.parametrize(
    ("line", "replacement", "key", "reason"),
    [
        ('robot = "kinematic"', 'robott = "kinematic"', "robott", "unknown key"),
        ('robot = "kinematic"', 'robot = "flying"', "robot", "mujoco"),
        ('robot = "kinematic"', "noise = nan", "noise", "finite"),
        ('robot = "kinematic"', "noise = -1.0", "noise", "greater than or equal to 0"),
        ('robot = "kinematic"', "seed = -1", "seed", "greater than or equal to 0"),
        ('robot = "kinematic"', 'pose = "gps"', "pose", "odometry"),
        ("length_m = 0.5", "length_m = 0.0", "boxes[0].length_m", "greater than 0"),
        ("length_m = 0.5", "length_m = inf", "boxes[0].length_m", "finite"),
        ('expect = "refused"', 'expect = "maybe"', "goals[1].expect", "refused"),
        ("at_s = 3.0", "at_s = -3.0", "events[0].at_s", "greater than or equal to 0"),
        ("dy_m = 1.0", "dz_m = 1.0", "events[0].dz_m", "unknown key"),
        ('do = "shove"', 'do = "fly"', "events[0]", "shove"),
    ],
)
def test_a_wrong_value_is_refused_with_line_key_and_reason(line, replacement, key, reason):
    number = GOOD.splitlines().index(line) + 1
    error = refusal(GOOD.replace(line, replacement))
    assert error.key == key
    assert reason in error.reason
    if key != "events[0]":
        assert error.line == number
    assert f"mission.toml:{error.line}: `{key}`" in str(error)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('place = "window"', 'place = "window"\nx_m = 1.0', "either `place`"),
        ('place = "window"', "x_m = 1.0", "needs `place`"),
        ('place = "window"', 'place = "window"\nexplore_s = 9.0', "without a goal"),
        ("at_s = 3.0", "", "needs `at_s`, `at_distance_m` or `when_mode`"),
        ("at_s = 3.0", "at_s = 3.0\nmode_for_s = 1.0", "needs `when_mode`"),
        ("[[events]]", "[expect]\ntransitions = ['tired']\n[[events]]", "no event `tired`"),
        ("at_s = 3.0", "at_s = 3.0\nrobot = 1", "robot 1"),
        ('map = "room"', 'map = "none"', "[world]"),
        ("[start]", '[[robots]]\nname = "a"\n[robots.start]', None),
        ("[start]", "[world]\nmap = 'room'\n[elsewhere]", "unknown key"),
        ("width_m = 0.5", "width_m = 0.5\nuntil_s = 1.0\nfrom_s = 2.0", "later than"),
    ],
)
def test_what_contradicts_itself_is_refused_with_its_reason(old, new, reason):
    text = GOOD.replace(old, new)
    if reason is None:
        assert parse(text, Path("mission.toml")).starts[0].name == "a"
    else:
        with pytest.raises(ScenarioInvalid) as caught:
            parse(text, Path("mission.toml"))
        assert reason in str(caught.value) or caught.value.reason in ("missing", "unknown key")


def test_a_scenario_without_start_or_robots_is_refused():
    text = GOOD.replace("[start]\nx_m = 1.0\ny_m = 1.0\n", "")
    assert "start" in refusal(text).reason


def test_a_missing_key_is_refused_by_name():
    error = refusal(GOOD.replace('map = "room"\n', ""))
    assert (error.key, error.reason) == ("map", "missing")


def test_two_robots_of_one_name_are_refused():
    robot = '[[robots]]\nname = "a"\nstart = { x_m = 1.0, y_m = 1.0 }\n'
    text = GOOD.replace("[start]\nx_m = 1.0\ny_m = 1.0\n", robot + robot)
    assert "same name" in refusal(text).reason


@given(cut=st.integers(0, len(GOOD)), put=st.text(max_size=12), skip=st.integers(0, 40))
def test_a_damaged_file_is_read_or_refused_with_a_reason_and_never_more(cut, put, skip):
    damaged = GOOD[:cut] + put + GOOD[cut + skip :]
    try:
        parse(damaged, Path("mission.toml"))
    except ScenarioInvalid as error:
        assert error.reason  # noqa: PT017
        assert str(error).startswith("mission.toml")  # noqa: PT017


def test_every_line_of_a_scenario_is_found_by_its_key():
    for number, line in enumerate(GOOD.splitlines(), start=1):
        if "=" in line and not line.startswith(("do", "place")):
            key, value = line.split(" = ")
            lines = GOOD.splitlines()
            lines[number - 1] = f"{key} = [{value}]"
            assert refusal("\n".join(lines)).line == number, line
