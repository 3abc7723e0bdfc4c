"""A recorded run told again as plain data, for reports and animations."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cairn
from cairn import errors
from cairn.missions.setting import load_map
from cairn.record import Run, open_run
from cairn.view.story import Story, tell
from cairn.world import World

LOG = "run.mcap"


def is_run(path: Path) -> bool:
    """Whether a folder, or the folder of the log or summary named, holds a recorded run."""
    folder = path if path.is_dir() else path.parent
    named = path.is_dir() or path.name in (LOG, "summary.json")
    return named and (folder / LOG).is_file()


def of_record(
    path: Path,
    *,
    maps_from: Path | None = None,
    observer: Callable[[int, int], None] | None = None,
) -> Story:
    """Tell a recorded run, cut off or not, from its folder or log.

    Args:
        path: the folder of the run, or a file in it.
        maps_from: the folder of the scenario's file, where its maps may lie.
        observer: told (ticks read, ticks in all) now and then.

    Raises:
        LogUnreadable: there is no log of a run there.
        NothingToReport: there is not one tick in it.
    """
    run = open_run(path if path.is_dir() else path.parent)
    known = run.map()
    try:
        return tell(
            run.summary,
            run.scenario,
            run.ticks() if observer is None else _watched(run, observer),
            known=known,
            world=_really_there(run, known, maps_from),
            plans={robot: list(run.paths(robot)) for robot in run.robots},
            echoes=_echoes(run),
            **_body(run),
        )
    except ValueError as error:
        raise errors.NothingToReport(
            f"{path}: {error}", path=str(path), reason=str(error)
        ) from error


def _watched(run: Run, observer: Callable[[int, int], None]) -> Iterator[dict[str, Any]]:
    total = run.tick_count
    for count, tick in enumerate(run.ticks(), start=1):
        if count % 50 == 0:
            observer(count, total)
        yield tick


def _really_there(run: Run, known: World | None, maps_from: Path | None) -> World | None:
    """What stands there, boxes apart: the given map, the scenario's world, else what was seen."""
    real = run.scenario.get("world")
    if real is None:
        return known
    try:
        return load_map(real["map"], maps_from)
    except (errors.CairnError, OSError):  # its file is not to be had any more
        return seen(run)


def seen(run: Run) -> World | None:
    """The map as the first robot knew it last; None where it kept none."""
    grids = deque(run.grids(), maxlen=1)
    if not grids:
        return None
    _, occupancy, resolution_m, origin = grids[0]
    return World(occupancy, resolution_m=resolution_m, origin=origin, name="map as seen")


def _echoes(run: Run) -> dict[str, dict[int, list[float]]]:
    """What every robot's sonars measured, by the number of the tick."""
    return {
        robot: {
            line["tick"]: line["ranges_m"] for line in run.inputs(robot) if line["call"] == "step"
        }
        for robot in run.robots
    }


def _body(run: Run) -> dict[str, Any]:
    """Outline, limits and sonars of the first robot: all of a run have one profile."""
    profile = cairn.Profile(run.made_of[run.robots[0]]["profile"])
    box, limits = profile.footprint, profile.limits
    return {
        "outline_m": (box.length_m, box.width_m),
        "limits": (limits.linear_mps, limits.angular_radps),
        "sonars": [
            (one.pose.x, one.pose.y, one.pose.heading, one.beam_rad) for one in profile.sonars
        ],
    }
