import subprocess
import sys

import pytest

import cairn


def cairn_command(*arguments):
    """Run the real command in a process of its own."""
    program = "from cairn.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)], capture_output=True, text=True
    )


def test_the_command_says_its_version():
    done = cairn_command("--version")
    assert (done.returncode, done.stdout.strip()) == (0, f"cairn {cairn.__version__}")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["fly"], "fly"),
        (["run"], "scenario"),
        (["run", "nowhere"], "nowhere"),
        (["run", "nowhere", "--seed", "x"], "--seed"),
        (["run", "quick", "--seed", "-1"], "--seed"),
        (["plan", "room", "--goal", "goal", "--out", "field.foo"], "only .npy"),
        (["plan", "room", "--goal", "goal", "--picture", "plan.foo"], "only .png"),
    ],
)
def test_wrong_usage_is_exit_code_2_with_a_complaint(command, arguments, complaint):
    code, _, complaints = command(*arguments)
    assert code == 2
    assert complaint in complaints.lower()


def test_a_malformed_scenario_is_exit_code_2_with_its_line(tmp_path):
    path = tmp_path / "mission.toml"
    path.write_text('name = "x"\nmap = 3\n')
    done = cairn_command("run", path)
    assert done.returncode == 2
    assert f"{path}:2: `map`" in done.stderr
    assert "ScenarioInvalid" in done.stderr


def test_the_doctor_finds_this_installation_sound(command):
    code, said, _ = command("doctor")
    assert code == 0, said
    assert "sound" in said
