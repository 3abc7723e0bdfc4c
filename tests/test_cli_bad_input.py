"""Whatever is typed, no traceback reaches the one who typed it: a complaint, and code 2."""

import numpy as np
import pytest
import typer

from cairn.cli import app
from cairn.missions import Scenario, run
from cairn.record import Recorder

ROOT = typer.main.get_command(app)


def leaves(group=ROOT, names=()):
    """(names, command) of every command that does something."""
    for name, each in group.commands.items():
        if hasattr(each, "commands"):
            yield from leaves(each, (*names, name))
        else:
            yield (*names, name), each


COMMANDS = dict(leaves())
# What each command needs besides the option under test.
NEEDED = {
    ("run",): ["quick"],
    ("plan",): ["room", "--goal", "goal"],
    ("track",): ["sine"],
    ("tune",): ["tuned.toml"],
    ("bench", "movingai"): ["."],
}
NUMBERS = [
    (names, option)
    for names, command in COMMANDS.items()
    for option in command.params
    if option.opts[0].startswith("--") and option.type_descriptor.annotation in (int, float)
]


def bad_files(folder):
    """Files that hold nothing that anybody can read."""
    (folder / "empty.toml").touch()
    (folder / "binary.toml").write_bytes(bytes(range(256)))
    (folder / "binary.map").write_bytes(b"type octile\nheight \xff\xfe")
    (folder / "binary.yaml").write_bytes(b"\x00\xff\xfe")
    (folder / "list.yaml").write_text("- 1\n- 2\n")
    (folder / "binary.npy").write_bytes(b"\x93NUMPY\x01\x00garbage")
    (folder / "empty.map").touch()
    (folder / "folder.toml").mkdir()
    np.save(folder / "words.npy", np.array([["a", "b"]]))
    np.save(folder / "cube.npy", np.ones((2, 2, 2)))
    np.save(folder / "pickled.npy", np.array([{}], dtype=object), allow_pickle=True)


def refused(outcome, said=""):
    code, _, complaints = outcome
    assert code == 2, complaints
    assert "Traceback" not in complaints
    assert "a bug in cairn" not in complaints
    assert said in complaints.replace("\n", " ")
    return True


@pytest.mark.parametrize(("names", "option"), NUMBERS, ids=lambda each: getattr(each, "name", each))
def test_an_option_that_is_no_number_is_refused_by_name(command, names, option):
    outcome = command(*names, *NEEDED.get(names, []), option.opts[0], "x")
    assert refused(outcome, option.opts[0])


@pytest.mark.parametrize("names", COMMANDS, ids=" ".join)
def test_an_option_that_does_not_exist_is_refused_by_name(command, names):
    assert refused(command(*names, *NEEDED.get(names, []), "--no-such-option"), "--no-such-option")


@pytest.mark.parametrize(
    "name",
    [
        "", "moon", ".", "/", "/dev/null", "nowhere/x.toml", "empty.toml", "binary.toml",
        "folder.toml", "a\nb", "x" * 5000,
    ],
)  # fmt: skip
def test_a_scenario_that_is_none_is_refused(command, tmp_path, name):
    bad_files(tmp_path)
    assert refused(command("run", name))
    assert refused(command("run", name, "--seeds", 2))


@pytest.mark.parametrize(
    "name",
    [
        "", "moon", ".", "/dev/null", "nowhere.yaml", "empty.toml", "binary.map", "empty.map",
        "binary.yaml", "list.yaml", "binary.npy", "words.npy", "cube.npy", "pickled.npy",
        "x" * 5000,
    ],
)  # fmt: skip
def test_a_map_that_is_none_is_refused(command, tmp_path, name):
    bad_files(tmp_path)
    assert refused(command("plan", name, "--goal", "0.5,0.5"))
    terrain = ("--terrain", "tobler", "--cell-size", "1")
    assert refused(command("plan", name, "--goal", "0.5,0.5", *terrain))


@pytest.mark.parametrize("name", ["explain", "replay", "report"])
@pytest.mark.parametrize(
    "folder",
    [
        "", "moon", ".", "/", "/dev/null", "nowhere/x", "empty.toml", "binary.toml", "folder.toml",
        "a\nb", "x" * 5000, "empty", "words", "other", "headless",
    ],
)  # fmt: skip
def test_a_run_that_is_none_is_refused(command, tmp_path, name, folder):
    bad_files(tmp_path)
    begins = b"\x89MCAP0\r\n"
    for other, log in (
        ("empty", b""),
        ("words", b"it went well\n"),
        ("other", begins + bytes(200)),
        ("headless", begins),
    ):
        (tmp_path / other).mkdir()
        (tmp_path / other / "run.mcap").write_bytes(log)
    assert refused(command(name, folder))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The folder of a run, recorded once."""
    folder = tmp_path_factory.mktemp("recorded")
    with Recorder(folder) as recorder:
        run(Scenario.load("quick"), seed=1, observers=[recorder])
    return folder


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["explain", "--at", "nan"], "nan"),
        (["explain", "--at", "-1"], "-1"),
        (["explain", "--at", "2", "--robot", "moon"], "moon"),
        (["explain", "--robot", "moon"], "moon"),
        (["replay", "--controller", "moon"], "moon"),
        (["replay", "--controller", "flat.npy"], "flat.npy"),
        (["report", "--out", "taken/page.html"], "taken"),
        (["report", "--animate", "run.avi"], ".gif"),
        (["report", "--animate", "taken/run.gif"], "taken"),
    ],
    ids=lambda each: " ".join(each) if isinstance(each, list) else "",
)
def test_what_a_recorded_run_cannot_be_asked_is_refused(
    command, tmp_path, recorded, arguments, said
):
    (tmp_path / "taken").write_text("a file, not a folder")
    np.save(tmp_path / "flat.npy", np.zeros((4, 4)))
    assert refused(command(arguments[0], recorded, *arguments[1:]), said)


def test_a_log_cut_off_or_overwritten_anywhere_is_told_or_refused(command, tmp_path, recorded):
    whole = (recorded / "run.mcap").read_bytes()
    holes = np.random.default_rng(1).integers(len(whole), size=(6, 40))
    spoilt = [whole[: len(whole) // share] for share in (2, 5, 100, 2000)]
    for hole in holes:
        bytes_ = bytearray(whole)
        for at in hole:
            bytes_[at] ^= 0x55
        spoilt.append(bytes(bytes_))
    for log in spoilt:
        (tmp_path / "run.mcap").write_bytes(log)
        for name in ("explain", "report"):
            code, _, complaints = command(name, tmp_path)
            assert code in (0, 2), complaints
            assert "Traceback" not in complaints


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["plan", "room", "--goal", "goal", "--robot", "moon"], "moon"),
        (["plan", "room", "--goal", "goal", "--robot", "."], "robot profile"),
        (["plan", "room", "--goal", "goal", "--start", "inf,0"], "--start"),
        (["plan", "room", "--goal", "goal", "--start", "1e9,0"], "outside the map"),
        (["plan", "room", "--goal", "goal", "--out", "taken/f.npy"], "taken"),
        (["plan", "room", "--goal", "goal", "--picture", "taken/f.png"], "taken"),
        (["plan", "room", "--goal", "goal", "--terrain", "moon", "--cell-size", "1"], "moon"),
        (["plan", "flat.npy", "--goal", "0,0", "--terrain", "tobler"], "--cell-size"),
        (["plan", "flat.npy", "--goal", "0,0", "--terrain", "tobler", "--cell-size", "nan"], ""),
        (["plan", "flat.npy", "--goal", "9,9", "--terrain", "tobler", "--cell-size", "1"], "9"),
        (["run", "quick", "--seed", "-1"], "--seed"),
        (["run", "quick", "--seed", str(2**32)], "--seed"),
        (["run", "quick", "--seed", "1", "--seeds", "2"], "--seed"),
        (["run", "quick", "--record", "taken"], "taken"),
        (["run", "quick", "--record", "/proc/nowhere"], "/proc"),
        (["run", "quick", "--live", "--seeds", "2"], "--live"),
        (["run", "quick", "--live", "--speed", "0", "--no-browser"], "--speed"),
        (["run", "quick", "--live", "--speed", "nan", "--no-browser"], "--speed"),
        (["run", "quick", "--live", "--port", "70000"], "--port"),
        (["run", "quick", "--live", "--host", "no.such.host.invalid", "--no-browser"], ""),
        (["run", "quick", "--live", "--record", "taken"], "taken"),
        (["run", "moon", "--live"], "moon"),
        (["run", "quick", "--animate", "run.avi"], ".gif"),
        (["scenarios", "--seeds", "-1"], "--seeds"),
        (["track", "moon"], "moon"),
        (["track", "sine", "--robot", "moon"], "moon"),
        (["track", "sine", "--under", "moon"], "moon"),
        (["track", "sine", "--controller", "moon"], "moon"),
        (["track", "sine", "--controller", "flat.npy"], "flat.npy"),
        (["track", "sine", "--speed", "nan"], ""),
        (["track", "sine", "--spacing", "nan"], ""),
        (["track", "sine", "--out", "taken"], "taken"),
        (["tune", "."], "folder"),
        (["tune", "taken/x.toml"], "taken"),
        (["reproduce", "moon"], "moon"),
        (["reproduce", "fig9", "--out", "taken"], "taken"),
        (["reproduce", "fig9", "moon"], "moon"),
        (["reproduce", "fig9", "--seed", "-1"], "--seed"),
        (["spin-test", "--robot", "moon"], "moon"),
        (["spin-test", "--profile", "moon"], "moon"),
        (["spin-test", "--rates", "fast"], "fast"),
        (["spin-test", "--rates", "nan"], ""),
        (["spin-test", "--turns", "nan", "--robot", "kinematic"], ""),
        (["spin-test", "--rest", "inf", "--robot", "kinematic"], ""),
        (["bench", "plan", "--size", "big"], "--size"),
        (["bench", "plan", "--classes", "moon"], "--classes"),
        (["bench", "plan", "--peers", "moon"], "--peers"),
        (["bench", "plan", "--corner-cutting", "moon"], "--corner-cutting"),
        (["bench", "plan", "--quick", "--out", "taken"], "taken"),
        (["bench", "plan", "--budget", "nan"], ""),
        (["bench", "movingai", "nowhere"], "nowhere"),
        (["bench", "movingai", "taken"], "taken"),
        (["bench", "graph", "--nodes", "many"], "--nodes"),
        (["bench", "graph", "--graphs", "moon"], "--graphs"),
        (["bench", "graph", "--nodes", "1000", "--out", "taken"], "taken"),
        (["bench", "repair", "--size", "1"], "--size"),
        (["bench", "repair", "--classes", "moon"], "--classes"),
        (["bench", "nav", "--worlds", "nowhere"], "nowhere"),
        (["bench", "nav", "--worlds", "."], ""),
        (["bench", "nav", "--worlds", "taken"], "taken"),
        (["bench", "nav", "--indices", "few"], "--indices"),
        (["bench", "nav", "--indices", "9-1"], "--indices"),
        (["bench", "nav", "--stack", "moon"], "moon"),
        (["bench", "nav", "--stack", "os:path"], "os:path"),
        (["bench", "nav", "--robot", "moon"], "moon"),
        (["bench", "nav", "--generate", "1", "--office", "1"], "--office"),
        (["bench", "nav", "--generate", "1", "--picture", "moon"], "--picture"),
        (["bench", "nav", "--office", "1", "--picture", "moon"], "--picture"),
        (["bench", "nav", "--generate", "1", "--out", "taken"], "taken"),
        (["bench", "odometry", "--robot", "moon"], "moon"),
        (["bench", "odometry", "--courses", "moon"], "--courses"),
        (["bench", "odometry", "--out", "taken"], "taken"),
        (["bench", "odometry", "--way", "nan"], ""),
        (["bench", "localise", "--maps", "moon"], "--maps"),
        (["bench", "localise", "--sensors", "moon"], "--sensors"),
        (["bench", "localise", "--out", "taken"], "taken"),
        (["bench", "localise", "--seconds", "nan"], ""),
        (["bench", "tick", "--rounds", "0"], "--rounds"),
        (["bench", "tick", "--out", "taken"], "taken"),
        (["report", "nowhere"], "nowhere"),
        (["report", "."], "summary"),
        (["report", "taken"], "not JSON"),
        (["report", "flat.npy"], ""),
        (["console", "moon"], "moon"),
        (["console", ""], ""),
        (["console", "taken"], "taken"),
        (["console", "quick", "--seed", "-1"], "--seed"),
        (["console", "quick", "--port", "-1"], "--port"),
        (["console", "quick", "--record", "taken", "--no-browser"], "taken"),
        (["console", "quick", "--speed", "nan", "--no-browser"], ""),
        (["console", "quick", "--host", "no.such.host.invalid", "--no-browser"], ""),
        ([], ""),
        (["bench"], ""),
        (["moon"], "moon"),
        (["bench", "moon"], "moon"),
    ],
    ids=lambda each: " ".join(each) if isinstance(each, list) else "",
)
def test_what_cannot_be_meant_is_refused_before_any_work(command, tmp_path, arguments, said):
    (tmp_path / "taken").write_text("a file, not a folder")
    np.save(tmp_path / "flat.npy", np.zeros((4, 4)))
    assert refused(command(*arguments), said)
