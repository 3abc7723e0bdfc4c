"""Missions: a scenario file → a run of simulated robots → a result judged by truth."""

from cairn.missions.batch import run_many
from cairn.missions.coverage import Change, changes_of_mode, coverage
from cairn.missions.reading import shipped
from cairn.missions.result import Result
from cairn.missions.runner import Tick, run
from cairn.missions.scenario import Scenario

__all__ = [
    "Change",
    "Result",
    "Scenario",
    "Tick",
    "changes_of_mode",
    "coverage",
    "run",
    "run_many",
    "shipped",
]
