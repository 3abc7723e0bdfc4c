"""Writes the log of a run: an observer of `cairn.missions.run`.

Everything is handed to a thread of the brain's own that serialises, compresses and writes: beside
the control loop there are a few copies per tick.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from cairn import _brain
from cairn.navigator import Navigator
from cairn.strict_json import plain
from cairn.world import World

FORMAT = 1  # of run.json; goes up when an older reader would misread it


class Recorder:
    """Begins `run.mcap` in a folder; at the latest half a second after a tick it is in the file.

    A context manager: leaving it writes what is left, with an index, and closes the file. A file
    whose writer was killed has no index, but everything up to its last second.

    Args:
        folder: made if need be; what an earlier run left there as `run.mcap` and `summary.json`
            is replaced.

    Raises:
        LogUnwritable: the file cannot be written, now or later.
    """

    def __init__(self, folder: str | Path) -> None:
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "summary.json").unlink(missing_ok=True)
        self.path = folder / "run.mcap"
        self._brain = _brain.Recorder(self.path)
        self._robots: dict[str, tuple[int, Navigator]] = {}

    def begin(self, scenario: Any, seed: int, setting: Any) -> None:
        """Take note of what the run is made of; `cairn.missions.run` calls this once.

        Args:
            scenario: what was asked, a model with `model_dump`, or a dict.
            seed: of everything random.
            setting: its `agents` have a `name` and a `navigator`.
        """
        if hasattr(scenario, "model_dump"):
            scenario = scenario.model_dump(mode="json", exclude_none=True)
        navigators = {agent.name: agent.navigator for agent in setting.agents}
        self.follow(navigators, scenario=scenario, seed=seed)

    def follow(
        self,
        navigators: dict[str, Navigator],
        *,
        scenario: dict[str, Any] | None = None,
        seed: int = 0,
    ) -> None:
        """Record these navigators from now on, whoever drives them; to be called once.

        Args:
            navigators: by the name of their robot, none of them used before.
            scenario: what they are to do, as plain values.
            seed: of everything random.
        """
        worlds: list[World] = []
        robots = {}
        for name, navigator in navigators.items():
            world = navigator.world
            if world is not None and not any(world is known for known in worlds):
                worlds.append(world)
            number = next((i for i, known in enumerate(worlds) if known is world), None)
            robots[name] = {
                **navigator.recipe,
                "map": None if number is None else _map_name(number),
            }
        for number, world in enumerate(worlds):
            self._brain.attach(_map_name(number), "application/octet-stream", _packed(world))
        made_of = {
            "format": FORMAT,
            "version": _brain.__version__,
            "scenario": scenario or {},
            "seed": seed,
            "robots": robots,
        }
        text = json.dumps(plain(made_of), allow_nan=False)
        self._brain.attach("run.json", "application/json", text.encode())
        for name, navigator in navigators.items():
            self._robots[name] = (self._brain.follow(name, navigator._brain), navigator)

    def __call__(self, tick: Any) -> None:
        """Take note of what the judge saw at a robot's tick: `time_s`, `truth`, `clearance_m`."""
        number, _ = self._robots[tick.robot]
        x, y, heading = (float(v) for v in tick.truth)
        self._brain.judged(number, float(tick.time_s), (x, y, heading), float(tick.clearance_m))

    def close(self) -> None:
        """Write what is left and close the file.

        Raises:
            LogUnwritable: something could not be written.
        """
        for _, navigator in self._robots.values():
            self._brain.leave(navigator._brain)
        self._robots.clear()
        self._brain.finish()

    def __enter__(self) -> Self:
        """Open already; returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self.close()


def _map_name(number: int) -> str:
    return f"map_{number}.npz"


def _packed(world: World) -> bytes:
    """The map that a navigator was given, to the bit."""
    arrays: dict[str, Any] = {
        "occupancy": world.occupancy,
        "resolution_m": np.float64(world.resolution_m),
        "origin": np.asarray(world.origin, np.float64),
    }
    if world.costs is not None:
        arrays["costs"] = world.costs
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()
