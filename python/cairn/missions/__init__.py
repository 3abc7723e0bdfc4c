"""Missions: a scenario file → a run of simulated robots → a result judged by truth."""

from cairn.missions.batch import run_many
from cairn.missions.reading import shipped
from cairn.missions.result import Result
from cairn.missions.runner import Tick, run
from cairn.missions.scenario import Scenario

__all__ = ["Result", "Scenario", "Tick", "run", "run_many", "shipped"]
