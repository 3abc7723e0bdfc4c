"""Reads the log of a run back: also one whose writer was killed."""

from __future__ import annotations

import io
import itertools
import json
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cairn import _brain, errors
from cairn.record.cdr import occupancy_grid, path_points
from cairn.world import World

Grid = tuple[float, NDArray[np.uint8], float, tuple[float, float, float]]


def open_run(folder_or_file: str | Path) -> Run:
    """Open the log of a run.

    Args:
        folder_or_file: the folder of the run, or its `run.mcap`.

    Raises:
        LogUnreadable: there is no log, or it is not one.
    """
    path = Path(folder_or_file)
    if path.is_dir():
        path = path / "run.mcap"
    return Run(path)


class Run:
    """A recorded run.

    Attributes:
        path: the log.
        scenario: what was asked, as plain values.
        seed: of everything random.
        version: of Cairn that recorded it.
        robots: names, in order.
        made_of: what each robot's navigator was made of, by name.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._maps: dict[str, bytes] = {}
        made_of: dict[str, Any] | None = None
        for name, time_ns, data in _brain.LogReader(path, {"run.json"}):
            if time_ns is None and name == "run.json":
                made_of = self._json(data)
                break
            self._maps[name] = data
        if made_of is None:
            raise errors.LogUnreadable(
                f"{path} cannot be read as a log: it was cut off before the run began",
                path=str(path),
                reason="it was cut off before the run began",
            )
        self.scenario: dict[str, Any] = made_of["scenario"]
        self.seed: int = made_of["seed"]
        self.version: str = made_of["version"]
        self.made_of: dict[str, dict[str, Any]] = made_of["robots"]
        self.robots: list[str] = list(self.made_of)

    @cached_property
    def summary(self) -> dict[str, Any] | None:
        """`summary.json` beside the log; None where the run was cut off."""
        path = self.path.parent / "summary.json"
        if not path.is_file():
            return None
        try:
            return json.loads(path.read_bytes())
        except ValueError as error:
            raise errors.LogUnreadable(
                f"{path} is not JSON: {error}", path=str(path), reason=str(error)
            ) from error

    @cached_property
    def complete(self) -> bool:
        """Whether the log was closed; one whose writer was killed was not."""
        reader = _brain.LogReader(self.path, set())
        for _ in reader:
            pass
        return reader.complete

    @property
    def tick_count(self) -> int:
        """Ticks of all robots that the log holds."""
        return sum(1 for _ in self._raw("/decision", None))

    def ticks(self, robot: str | None = None) -> Iterator[dict[str, Any]]:
        """Yield `{"time_s", "robot", "truth", "clearance_m", "decision"}` of every tick.

        `truth` is (x, y, heading) in the world frame [m, m, rad] and `clearance_m` the distance to
        the nearest thing, by truth; both None where nobody judged. `decision` is
        `Decision.to_dict()`, see docs/decision-record.md.

        Args:
            robot: only this one's; by default all, in order of time.

        Raises:
            RobotUnknown: there is none of that name.
        """
        yield from self._lines("/decision", robot)

    def at(self, time_s: float, robot: str | None = None) -> dict[str, Any] | None:
        """Return the last tick at or before `time_s`, by default the first robot's; None before."""
        last = None
        for _, data in self._raw("/decision", robot or self.robots[0]):
            line = self._json(data)
            if line["time_s"] > time_s + 1e-9:
                break
            last = line
        return None if last is None else restored(last)

    def inputs(self, robot: str | None = None) -> Iterator[dict[str, Any]]:
        """Yield all that navigators were given, in order: readings, goals, cancellations.

        `{"robot", "time_s", "call", ...}`: `call` is `step`, `set_goal`, `explore` or `cancel`; the
        rest are its arguments, to the bit.
        """
        yield from self._lines("/inputs", robot)

    def grids(self, robot: str | None = None) -> Iterator[Grid]:
        """Yield `(time_s, occupancy, resolution_m, origin)` of the map as a robot knew it.

        Every few seconds and at the end; `occupancy` is as `World.occupancy`. By default the first
        robot's.
        """
        topic = f"/{self._topics(robot or self.robots[0])}/map"
        for _, time_ns, data in _brain.LogReader(self.path, {topic}):
            if time_ns is not None:
                yield (time_ns / 1e9, *occupancy_grid(data))

    def paths(self, robot: str | None = None) -> Iterator[tuple[float, NDArray[np.float64]]]:
        """Yield `(time_s, points)` whenever the way to go changed; points (n, 2) [m, world frame].

        By default the first robot's.
        """
        topic = f"/{self._topics(robot or self.robots[0])}/path"
        for _, time_ns, data in _brain.LogReader(self.path, {topic}):
            if time_ns is not None:
                yield time_ns / 1e9, path_points(data)

    def map(self, robot: str | None = None) -> World | None:
        """Return the map a robot was given, by default the first; None where it had none."""
        name = self.made_of[self._known(robot or self.robots[0])]["map"]
        if name is None:
            return None
        with np.load(io.BytesIO(self._maps[name])) as packed:
            return World(
                packed["occupancy"],
                resolution_m=float(packed["resolution_m"]),
                origin=tuple(float(v) for v in packed["origin"]),  # type: ignore[arg-type]
                costs=packed.get("costs"),
                name=name,
            )

    def _topics(self, robot: str) -> str:
        return topic_names(self.robots)[self._known(robot)]

    def _known(self, robot: str) -> str:
        if robot not in self.made_of:
            raise errors.RobotUnknown(
                f"no robot `{robot}` in {self.path}; there is {', '.join(self.robots)}",
                robot=robot,
                known=self.robots,
            )
        return robot

    def _raw(self, ending: str, robot: str | None) -> Iterator[tuple[int, bytes]]:
        if robot is not None:
            ending = f"/{self._topics(robot)}{ending}"
        for _, time_ns, data in _brain.LogReader(self.path, {ending}):
            if time_ns is not None:
                yield time_ns, data

    def _lines(self, ending: str, robot: str | None) -> Iterator[dict[str, Any]]:
        for _, data in self._raw(ending, robot):
            line = self._json(data)
            yield restored(line) if b'inf"' in data or b'"nan"' in data else line

    def _json(self, data: bytes) -> Any:
        try:
            return json.loads(data)
        except ValueError as error:
            raise errors.LogUnreadable(
                f"{self.path} cannot be read as a log: {error}",
                path=str(self.path),
                reason=str(error),
            ) from error


def topic_names(robots: Iterable[str]) -> dict[str, str]:
    """Return what each robot, in the order recorded, is called in the names of its topics."""
    names: dict[str, str] = {}
    for robot in robots:
        plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in robot)
        numbered = itertools.chain([plain], (f"{plain}_{i}" for i in itertools.count(2)))
        names[robot] = next(name for name in numbered if name not in names.values())
    return names


NUMBERS = {"inf": float("inf"), "-inf": float("-inf"), "nan": float("nan")}


def restored(value: Any) -> Any:
    """`value` with the numbers that JSON does not have put back."""
    if isinstance(value, dict):
        return {key: restored(item) for key, item in value.items()}
    if isinstance(value, list):
        return [restored(item) for item in value]
    return NUMBERS.get(value, value) if isinstance(value, str) else value
