"""A run told again for pictures and reports: from its result, or from the folder it left."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cairn
from cairn import errors
from cairn.missions.result import Result
from cairn.missions.runner import Tick
from cairn.missions.setting import load_map
from cairn.record import open_run
from cairn.view.story import Story, tell
from cairn.world import World

LOG = "run.mcap"


class Listener:
    """An observer of `cairn.missions.run` that keeps every tick as plain data."""

    def __init__(self) -> None:
        """Begin with nothing heard."""
        self.ticks: list[dict[str, Any]] = []

    def __call__(self, tick: Tick) -> None:
        """Keep one robot's tick."""
        self.ticks.append(
            {
                "time_s": tick.time_s,
                "robot": tick.robot,
                "truth": list(tick.truth),
                "clearance_m": tick.clearance_m,
                "decision": tick.decision.to_dict(),
            }
        )


def of_result(result: Result, ticks: Iterable[dict[str, Any]]) -> Story:
    """Tell a run that has just ended, from its result and what a `Listener` heard."""
    heard = list(ticks)
    plans = {}
    for robot in result.robots:
        times = [
            tick["time_s"]
            for tick in heard
            if tick["robot"] == robot.name and tick["decision"].get("plan")
        ]
        times += [0.0] * max(len(robot.trace.plans) - len(times), 0)
        plans[robot.name] = list(zip(times, robot.trace.plans, strict=False))
    summary = result.to_dict()
    return tell(
        summary,
        summary["scenario"],
        heard,
        known=result.map,
        world=result.world,
        plans=plans,
        **_body(summary["scenario"], result.scenario.folder),
    )


def _body(scenario: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """Outline and limits of the scenario's robot; those of the P3-AT if it is not to be had."""
    name = scenario.get("profile", "p3at")
    path = (folder or Path.cwd()) / name
    try:
        profile = cairn.Profile.load(path if path.is_file() else name)
    except errors.CairnError:
        profile = cairn.Profile.load("p3at")
    box, limits = profile.footprint, profile.limits
    return {
        "outline_m": (box.length_m, box.width_m),
        "limits": (limits.linear_mps, limits.angular_radps),
        "sonars": [
            (one.pose.x, one.pose.y, one.pose.heading, one.beam_rad) for one in profile.sonars
        ],
    }


def _real_world(scenario: dict[str, Any], known: World | None) -> World | None:
    """What really stands there, as far as its file is still to be had."""
    real = scenario.get("world")
    if not real:
        return known
    try:
        return load_map(real["map"], None)
    except (errors.CairnError, OSError):
        return None


def is_run(path: Path) -> bool:
    """Whether a folder, or the folder of the log or summary named, holds a recorded run."""
    folder = path if path.is_dir() else path.parent
    named = path.is_dir() or path.name in (LOG, "summary.json")
    return named and (folder / LOG).is_file()


def of_record(path: Path) -> Story:
    """Tell a recorded run, cut off or not, from its folder or log.

    Raises:
        NothingToReport: there is no log of a run there, or not one tick in it.
    """
    folder = path if path.is_dir() else path.parent
    if not is_run(path):
        raise errors.NothingToReport(
            f"{path}: no recorded run; `cairn run NAME --record {folder}` makes one",
            path=str(path),
            reason="no recorded run",
        )
    made = open_run(folder)
    scenario, known = made.scenario, made.map()
    try:
        return tell(
            made.summary,
            scenario,
            made.ticks(),
            known=known,
            world=_real_world(scenario, known),
            **_body(scenario, None),
        )
    except ValueError as error:
        raise errors.NothingToReport(
            f"{path}: {error}", path=str(path), reason=str(error)
        ) from error
