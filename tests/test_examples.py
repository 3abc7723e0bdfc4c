import runpy
from pathlib import Path

EXAMPLES = Path(__file__).parent.parent / "examples"


def test_the_loop_of_the_example_drives_between_rooms_and_tells_why(capsys):
    example = runpy.run_path(str(EXAMPLES / "drive_between_rooms.py"))
    assert example["main"]() == "reached"
    told = capsys.readouterr().out
    assert "Path planning: the map and the place in it are known" in told
    assert "Path tracking: a path of 6.4 m to (7.20, 2.00) m was found" in told
    assert "Path tracking: the way is shut" in told
    assert "the repaired field is walked anew from here" in told
    assert told.splitlines()[-1].endswith("Stop: arrived.")
