import runpy
from pathlib import Path

EXAMPLES = Path(__file__).parent.parent / "examples"


def test_the_loop_of_the_example_drives_between_rooms_and_tells_why(capsys):
    example = runpy.run_path(str(EXAMPLES / "drive_between_rooms.py"))
    assert example["main"]() == "reached"
    told = capsys.readouterr().out
    assert "Path planning: the map and the place in it are known" in told
    assert "Obstacle avoidance: something the plan did not know" in told
    assert told.splitlines()[-1].endswith("Stop: arrived.")
