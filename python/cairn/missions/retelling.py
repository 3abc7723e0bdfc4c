"""A run told again for pictures and reports: from its result, or from the folder it left."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cairn
from cairn import errors
from cairn.missions.result import Result
from cairn.missions.runner import Tick
from cairn.missions.setting import load_map
from cairn.view.story import Story, tell
from cairn.world import World


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


def _worlds(scenario: dict[str, Any], folder: Path | None) -> tuple[World | None, World | None]:
    """The given map and what really stands there, as far as their files are still to be had."""

    def loaded(name: str | None) -> World | None:
        if name is None or name == "none":
            return None
        try:
            return load_map(name, folder)
        except (errors.CairnError, OSError):
            return None

    known = loaded(scenario.get("map"))
    real = scenario.get("world")
    return known, loaded(real["map"]) if real else known


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
    summary, scenario, ticks = _opened(folder)
    known, world = _worlds(scenario, None)
    try:
        return tell(
            summary, scenario, ticks, known=known, world=world, **_body(scenario, None)
        )  # fmt: skip
    except ValueError as error:
        raise errors.NothingToReport(
            f"{path}: {error}", path=str(path), reason=str(error)
        ) from error


LOG = "decisions.jsonl"


def _opened(folder: Path) -> tuple[dict[str, Any] | None, dict[str, Any], Iterable[Any]]:
    """Summary, scenario and ticks of a run, as its log has them."""
    path = folder / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    with (folder / LOG).open(encoding="utf-8") as lines:
        ticks = [json.loads(line) for line in lines if line.endswith("\n")]
    return summary, (summary or {}).get("scenario", {}), ticks
