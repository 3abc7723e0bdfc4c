"""Records of runs: open files that anything can read, the story they tell, and their replay."""

from cairn.record.files import write_summary
from cairn.record.recorder import Recorder
from cairn.record.replay import Difference, Replay, replay
from cairn.record.run import Run, open_run
from cairn.record.run_story import Moment, RobotStory, tell_run
from cairn.record.tick_story import Paragraph, tell_tick

__all__ = [
    "Difference",
    "Moment",
    "Paragraph",
    "Recorder",
    "Replay",
    "RobotStory",
    "Run",
    "open_run",
    "replay",
    "tell_run",
    "tell_tick",
    "write_summary",
]
