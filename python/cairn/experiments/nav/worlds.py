"""Worlds to drive through: posts, walls, things that move, a start and a goal."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from cairn import _brain, errors
from cairn.experiments.nav.movers import Mover, Movers
from cairn.robots.robot import Pose

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NavWorld:
    """A world of the benchmark, in its own frame.

    Attributes:
        name: what tables call it; seeds follow from it.
        circles: (n, 3) x, y, radius [m].
        boxes: (m, 5) x, y, heading, length, width [m, rad].
        movers: obstacles that move.
        start: pose of the robot at the beginning.
        goal: (x, y) [m].
        path_length_m: what the score measures times by.
        goal_tolerance_m, timeout_s: as the benchmark has them.
        kind: `static` or `dynamic`.
        difficulty: of dynamic worlds; empty otherwise.
        reference_path: (k, 2) a way through; empty where none is known.
    """

    name: str
    circles: Floats
    boxes: Floats
    start: Pose
    goal: tuple[float, float]
    path_length_m: float
    movers: tuple[Mover, ...] = ()
    goal_tolerance_m: float = 1.0
    timeout_s: float = 100.0
    kind: str = "static"
    difficulty: str = ""
    reference_path: Floats = field(default_factory=lambda: np.zeros((0, 2)))

    def shapes(self) -> _brain.Shapes:
        """Everything that stands, for exact rays and contact."""
        return _brain.Shapes(self.circles, self.boxes)

    def motion(self) -> Movers | None:
        """Everything that moves; None where nothing does."""
        return Movers(self.movers) if self.movers else None

    def scaled(self, factor: float) -> NavWorld:
        """The same world, larger or smaller; times stay."""
        scale = np.array([factor, factor, 1.0])
        return replace(
            self,
            circles=self.circles * factor,
            boxes=self.boxes * np.array([factor, factor, 1.0, factor, factor]),
            start=Pose(self.start.x * factor, self.start.y * factor, self.start.heading),
            goal=(self.goal[0] * factor, self.goal[1] * factor),
            path_length_m=self.path_length_m * factor,
            movers=tuple(
                replace(
                    mover,
                    radius_m=mover.radius_m * factor,
                    keyframes=mover.keyframes * scale[[2, 0, 1]],
                )
                for mover in self.movers
            ),
            reference_path=self.reference_path * factor,
        )


def load_folder(folder: Path, indices: tuple[int, ...] | None = None) -> list[NavWorld]:
    """Read `world_N.json` and `world_N.world` files of a folder, in the order of their numbers.

    Args:
        folder: what the user names.
        indices: which numbers; None for all.

    Raises:
        NavWorldsMissing: the folder holds no world, or not one of those asked for.
        NavWorldInvalid: a file is not a world.
    """
    found: dict[int, Path] = {}
    if folder.is_dir():
        for path in sorted(folder.iterdir()):
            stem, number = path.stem.rpartition("_")[::2]
            if path.suffix in (".json", ".world") and stem == "world" and number.isdecimal():
                found.setdefault(int(number), path)
    if not found:
        raise errors.NavWorldsMissing(
            f"{folder}: no world_N.json or world_N.world there", folder=str(folder), missing=[]
        )
    wanted = sorted(found) if indices is None else list(indices)
    missing = [index for index in wanted if index not in found]
    if missing:
        raise errors.NavWorldsMissing(
            f"{folder}: no world number {', '.join(map(str, missing))} there",
            folder=str(folder),
            missing=missing,
        )
    return [load(found[index]) for index in wanted]


def load(path: Path) -> NavWorld:
    """Read one world: JSON, or a .world file of Gazebo.

    Raises:
        NavWorldInvalid: it is neither, or its numbers are not those of a world.
    """
    if path.suffix == ".world":
        from cairn.experiments.nav.gazebo import load_gazebo

        return load_gazebo(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        refuse(path, "", str(error))
    if not isinstance(data, dict):
        refuse(path, "", "a JSON object was expected")
    return _from_json(path, data)


def refuse(path: Path, key: str, reason: str) -> NoReturn:
    """Refuse a file as a world, naming what is wrong.

    Raises:
        NavWorldInvalid: always.
    """
    where = f"{path}: {key}: " if key else f"{path}: "
    raise errors.NavWorldInvalid(where + reason, path=str(path), key=key, reason=reason)


def _from_json(path: Path, data: dict[str, Any]) -> NavWorld:
    circles = rows(path, data, "cylinders", 3)
    walls = rows(path, data, "boxes", 4)
    boxes = np.column_stack([walls[:, :2], np.zeros(len(walls)), walls[:, 2:]])
    movers = tuple(_mover(path, i, each) for i, each in enumerate(data.get("obstacles") or ()))
    length = data.get("path_length", data.get("path_length_nominal"))
    start, goal = rows(path, data, "start", 3, one=True), rows(path, data, "goal", 2, one=True)
    difficulty = ""
    if movers:
        difficulty = movers[0].name.partition("libobs")[0]
    return checked(
        path,
        NavWorld(
            name=path.stem,
            circles=circles,
            boxes=boxes,
            start=Pose(*map(float, start[0])),
            goal=(float(goal[0, 0]), float(goal[0, 1])),
            path_length_m=positive(path, "path_length", length),
            movers=movers,
            goal_tolerance_m=positive(path, "goal_tolerance", data.get("goal_tolerance", 1.0)),
            timeout_s=positive(path, "timeout", data.get("timeout", 100.0)),
            kind="dynamic" if movers else "static",
            difficulty=difficulty,
            reference_path=rows(path, data, "reference_path_fitted", 2),
        ),
    )


def checked(path: Path, world: NavWorld) -> NavWorld:
    """Return the world, or refuse its file: every shape must be one."""
    try:
        world.shapes()
    except (errors.CircleNotUsable, errors.BlockNotUsable) as error:
        refuse(
            path, "boxes" if isinstance(error, errors.BlockNotUsable) else "cylinders", str(error)
        )
    return world


def positive(path: Path, key: str, value: Any) -> float:
    """Return a positive finite number, or refuse the file."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (number and math.isfinite(value) and value > 0):
        refuse(path, key, f"is {value!r}, must be a positive number")
    return float(value)


def rows(path: Path, data: dict[str, Any], key: str, width: int, *, one: bool = False) -> Floats:
    """Return the rows under a key as (n, width), (1, width) if `one`, or refuse the file."""
    value = data.get(key)
    if value is None and not one:
        return np.zeros((0, width))
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        refuse(path, key, f"is {value!r:.60}, must be numbers")
    if one:
        array = array.reshape(1, -1)
    elif array.size == 0:
        return np.zeros((0, width))
    if array.ndim != 2 or array.shape[1] != width or not np.isfinite(array).all():
        refuse(path, key, f"must be {'one row' if one else 'rows'} of {width} finite numbers")
    return array


def _mover(path: Path, number: int, data: Any) -> Mover:
    key = f"obstacles[{number}]"
    if not isinstance(data, dict):
        refuse(path, key, "an object was expected")
    frames = rows(path, data, "keyframes", 3)
    times = frames[:, 0]
    period = positive(path, f"{key}.period", data.get("period"))
    if len(frames) < 2 or times[0] != 0 or (np.diff(times) <= 0).any() or times[-1] > period + 1e-9:
        refuse(path, f"{key}.keyframes", "times must rise from 0 up to the period, at least two")
    radius = positive(path, f"{key}.radius", data.get("radius"))
    return Mover(str(data.get("name", f"obstacle {number}")), radius, period, frames)
