"""Drives new navigators with the inputs of a log: the same commands must come out, to the bit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cairn import errors
from cairn.navigator import Navigator
from cairn.record.run import Run


@dataclass(frozen=True)
class Difference:
    """Where a replay first said something else than the log.

    Attributes:
        robot, time_s, tick: of whom, when.
        key: dotted, of the first part of the decision that differs: `tracking.raw.linear_mps`.
        logged, replayed: its value then and now.
        is_command: whether the command of that tick differs too.
    """

    robot: str
    time_s: float
    tick: int
    key: str
    logged: Any
    replayed: Any
    is_command: bool


@dataclass(frozen=True)
class Replay:
    """What came out of a replay.

    Attributes:
        ticks: how many were replayed, by robot.
        differences: the first one of each robot that has one.
        command_from: the first tick whose command differs, by robot.
    """

    ticks: dict[str, int]
    differences: list[Difference]
    command_from: dict[str, Difference]

    @property
    def is_same(self) -> bool:
        """Whether every decision came out as it is in the log."""
        return not self.differences


def replay(
    run: Run,
    *,
    make: Callable[[str, dict[str, Any]], Navigator] | None = None,
    observer: Callable[[int, int], None] | None = None,
) -> Replay:
    """Replay a run from its log.

    Args:
        run: of `open_run`.
        make: (name, recipe) → the navigator to drive instead of the one the log tells of: one with
            another controller, say. Recipes: `Navigator.recipe`.
        observer: told (ticks done, ticks in all) now and then.

    Raises:
        LogNotReplayable: an input that is not in the log was used.
    """
    navigators = {
        name: make(name, recipe) if make else Navigator.from_recipe(recipe, run.map(name))
        for name, recipe in run.made_of.items()
    }
    wanted = _fields_wanted(run)
    fields: dict[tuple[str, int | None], Any] = {}
    counts = dict.fromkeys(navigators, 0)
    first: dict[str, Difference] = {}
    first_command: dict[str, Difference] = {}
    ticks = {name: run.ticks(name) for name in navigators}
    total = sum(1 for line in run.inputs() if line["call"] == "step") if observer else 0
    for line in run.inputs():
        name = line["robot"]
        navigator = navigators[name]
        if line["call"] != "step":
            _tell(navigator, line, fields, run)
            continue
        decision = _step(navigator, line).to_dict()
        counts[name] += 1
        if (name, line["tick"]) in wanted:
            fields[name, line["tick"]] = navigator.field
        logged = next(ticks[name], None)
        if logged is None:  # cut off between inputs and decision
            break
        for found in _compared(name, logged, decision):
            first.setdefault(name, found)
            if found.is_command:
                first_command.setdefault(name, found)
        if observer and sum(counts.values()) % 50 == 0:
            observer(sum(counts.values()), total)
    return Replay(counts, list(first.values()), first_command)


def _fields_wanted(run: Run) -> set[tuple[str, int | None]]:
    goals = (line for line in run.inputs() if line["call"] == "set_goal" and line["field"])
    return {(line["field"]["robot"], line["field"]["tick"]) for line in goals}


def _tell(
    navigator: Navigator, line: dict[str, Any], fields: dict[tuple[str, int | None], Any], run: Run
) -> None:
    match line["call"]:
        case "explore":
            navigator.explore()
        case "cancel":
            navigator.cancel()
        case "set_goal":
            source = line["field"]
            if line["shared"] and source is None:
                reason = f"at {line['time_s']:g} s a field was given with the goal that no log has"
                raise errors.LogNotReplayable(
                    f"{run.path} cannot be replayed: {reason}", path=str(run.path), reason=reason
                )
            field = fields[source["robot"], source["tick"]] if source else None
            navigator.set_goal(line["goal"], field)
        case other:
            raise errors.LogNotReplayable(
                f"{run.path} cannot be replayed: it holds a call `{other}`",
                path=str(run.path),
                reason=f"call `{other}`",
            )


def _step(navigator: Navigator, line: dict[str, Any]) -> Any:
    return navigator.step(
        np.array(line["ranges_m"], float),
        line["wheels_m"],
        line["gyro_radps"],
        line["dt_s"],
        line["world_from_robot"],
    )


def _compared(name: str, logged: dict[str, Any], decision: dict[str, Any]) -> Iterator[Difference]:
    before = logged["decision"]
    found = next(_differing("", before, decision), None)
    if found is not None:
        is_command = next(_differing("", before["twist"], decision["twist"]), None) is not None
        yield Difference(name, logged["time_s"], before["tick"], *found, is_command)


def _differing(key: str, one: Any, other: Any) -> Iterator[tuple[str, Any, Any]]:
    """Every place where two plain values differ, in the order of the record."""
    if isinstance(one, dict) and isinstance(other, dict):
        for name in dict.fromkeys([*one, *other]):
            inside = f"{key}.{name}" if key else str(name)
            yield from _differing(inside, one.get(name), other.get(name))
    elif isinstance(one, list | tuple) and isinstance(other, list | tuple):
        if len(one) != len(other):
            yield (f"{key}.length", len(one), len(other))
        for number, (left, right) in enumerate(zip(one, other, strict=False)):
            yield from _differing(f"{key}[{number}]", left, right)
    elif not _same(one, other):
        yield (key, one, other)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        both_nan = math.isnan(one) and math.isnan(other)
        return both_nan or (one == other and math.copysign(1, one) == math.copysign(1, other))
    return type(one) is type(other) and one == other
