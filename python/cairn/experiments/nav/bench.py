"""Many trials over processes, and the record of them."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Any

import numpy as np

import cairn
from cairn import errors
from cairn.experiments.nav import scoring
from cairn.experiments.nav.stacks import maker
from cairn.experiments.nav.trial import ROBOTS, Trial, checked_period, drive, fitted
from cairn.experiments.nav.worlds import NavWorld

CAVEAT = (
    "BARN's worlds and formula in our own simulator: not Gazebo, not the organisers' hidden "
    "worlds; not a BARN Challenge score and not rankable."
)


@dataclass(frozen=True)
class Settings:
    """What to run.

    Attributes:
        stack: a built-in name or `module:function`.
        worlds: what to drive through, at BARN's scale.
        robot: `jackal` or `p3at`; the worlds are scaled to it.
        trials: of each world.
        seed: of everything drawn.
        processes: that share the work; the results do not depend on it.
        source: what the worlds are, for the record.
    """

    stack: str
    worlds: Sequence[NavWorld]
    robot: str = "jackal"
    trials: int = 10
    seed: int = 1
    processes: int = 2
    source: str = ""

    def check(self) -> None:
        """Refuse what cannot be run, before anything is.

        Raises:
            StackNotFound, StackPeriodInvalid: the stack cannot be entered.
            NavBenchValueOutOfRange: an unknown robot, or no trial, process or world.
        """
        wrong = {
            "robot": self.robot not in ROBOTS,
            "trials": self.trials < 1,
            "processes": self.processes < 1,
            "worlds": len(self.worlds) < 1,
            "seed": self.seed < 0,
        }
        for key, is_wrong in wrong.items():
            if is_wrong:
                value = len(self.worlds) if key == "worlds" else getattr(self, key)
                raise errors.NavBenchValueOutOfRange(
                    f"navigation benchmark: {key} is {value!r}; robots are {', '.join(ROBOTS)}, "
                    "numbers start at 1, seeds at 0",
                    key=key,
                    value=value,
                )
        make = maker(self.stack)
        checked_period(self.stack, getattr(make, "period_s", ROBOTS[self.robot].period_s))


def run(settings: Settings, told: Callable[[Trial], None] | None = None) -> dict[str, Any]:
    """Run every trial and return the record: `summary`, `worlds`, `trials`, and more.

    Args:
        settings: what to run.
        told: called with every trial as it ends, in no fixed order.

    Raises:
        StackNotFound, StackPeriodInvalid, NavBenchValueOutOfRange: nothing has been run then.
    """
    settings.check()
    done: dict[tuple[str, int], Trial] = {}
    for trial in _all(settings):
        done[trial.world, trial.trial] = trial
        if told is not None:
            told(trial)
    return record_of(settings, done)


def run_office(
    numbers: Sequence[int],
    seed: int,
    robot: str,
    processes: int,
    told: Callable[[Trial], None] | None = None,
) -> dict[str, Any]:
    """Run office missions of our navigator and return a record like that of `run`.

    Args:
        numbers: which missions of the series of `seed`.
        seed: of the series.
        robot: `mujoco` (physics) or `kinematic`.
        processes: that share the work.
        told: called with every mission as it ends.
    """
    from cairn.experiments.nav.office import office_figures

    done: dict[str, Trial] = {}
    for trial in _over_processes(_one_mission, [(n, seed, robot) for n in numbers], processes):
        done[trial.world] = trial
        if told is not None:
            told(trial)
    trials = [done[f"office_{number}"] for number in numbers]
    return {
        "office": office_figures(trials),
        **_record([[trial.to_dict()] for trial in trials], seed, [t.wall for t in trials]),
        "by_difficulty": {},
        "stack": "cairn",
        "robot": f"P3-AT, {robot}",
        "scale": 1.0,
        "source": f"office missions, seed {seed}",
        "trials_per_world": 1,
        "seed": seed,
        "worlds": [
            {"world": trial.world, "kind": "office", "difficulty": "", **_row([trial.to_dict()])}
            for trial in trials
        ],
    }


def record_of(settings: Settings, done: dict[tuple[str, int], Trial]) -> dict[str, Any]:
    """Make the record of a benchmark from its trials."""
    rows = [
        [done[world.name, number].to_dict() for number in range(settings.trials)]
        for world in settings.worlds
    ]
    worlds = list(zip(settings.worlds, rows, strict=True))
    groups = sorted({world.difficulty for world in settings.worlds if world.difficulty})
    return {
        **_record(rows, settings.seed, [trial.wall for trial in done.values()]),
        "by_difficulty": {
            group: scoring.figures(
                [own for world, own in worlds if world.difficulty == group], settings.seed
            )
            for group in groups
        },
        "stack": settings.stack,
        "robot": settings.robot,
        "scale": ROBOTS[settings.robot].scale,
        "source": settings.source,
        "trials_per_world": settings.trials,
        "seed": settings.seed,
        "worlds": [
            {"world": world.name, "kind": world.kind, "difficulty": world.difficulty, **_row(own)}
            for world, own in worlds
        ],
    }


def _record(
    rows: list[list[dict[str, Any]]], seed: int, walls: Sequence[dict[str, float]]
) -> dict[str, Any]:
    return {
        "summary": {**scoring.figures(rows, seed), "caveat": CAVEAT},
        "version": cairn.__version__,
        "trials": [trial for own in rows for trial in own],
        "wall": {
            "tick_mean_ms": float(np.mean([tick["tick_mean_ms"] for tick in walls])),
            "tick_p99_ms": float(np.quantile([tick["tick_p99_ms"] for tick in walls], 0.99)),
            "tick_max_ms": float(max(tick["tick_max_ms"] for tick in walls)),
        },
    }


def _row(trials: list[dict[str, Any]]) -> dict[str, Any]:
    kinds = ("success", "collision", "timeout", "error")
    times = [trial["time_s"] for trial in trials if trial["outcome"] == "success"]
    return {
        **{kind: sum(trial["outcome"] == kind for trial in trials) for kind in kinds},
        "time_s": float(np.mean(times)) if times else None,
        "score": float(np.mean([trial["score"] for trial in trials])),
        "score_old_cap": float(np.mean([trial["score_old_cap"] for trial in trials])),
    }


def _all(settings: Settings) -> Iterator[Trial]:
    worlds = [fitted(world, settings.robot) for world in settings.worlds]
    jobs = [
        (settings.stack, world, number, settings.seed, settings.robot)
        for number in range(settings.trials)
        for world in worlds
    ]
    return _over_processes(_one, jobs, settings.processes)


def _over_processes(
    one: Callable[[Any], Trial], jobs: Sequence[Any], processes: int
) -> Iterator[Trial]:
    if processes == 1:
        yield from map(one, jobs)
        return
    # Processes forked from one with threads may hang; these begin anew, each on one thread.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, context, initializer=_alone) as pool:
        for future in as_completed([pool.submit(one, job) for job in jobs]):
            yield future.result()


def _alone() -> None:
    """Let a process use one thread: there is one for each core already."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
        os.environ[name] = "1"


def _one(job: tuple[str, NavWorld, int, int, str]) -> Trial:
    stack, world, number, seed, robot = job
    return drive(stack, world, number, seed, robot=robot)


def _one_mission(job: tuple[int, int, str]) -> Trial:
    from cairn.experiments.nav.office import drive_office

    return drive_office(*job)[0]
