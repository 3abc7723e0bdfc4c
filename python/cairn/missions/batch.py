"""Many runs at once, one process each: the same results as one after another."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from cairn.missions.runner import run
from cairn.missions.scenario import Scenario

Job = tuple[str, int]  # scenario (name or path) and seed


def run_one(job: Job) -> dict[str, Any]:
    """Run one scenario with one seed and return its record, see `Result.to_dict`."""
    scenario, seed = job
    return run(Scenario.load(scenario), seed=seed).to_dict()


def run_many(
    scenarios: Iterable[str | Path], seeds: Iterable[int], workers: int | None = None
) -> Iterator[tuple[Job, dict[str, Any] | Exception]]:
    """Run every scenario with every seed, in parallel.

    Args:
        scenarios: names of shipped scenarios or paths.
        seeds: the seeds to run each with.
        workers: processes; by default one per core.

    Yields:
        ((scenario, seed), record) as runs finish; an exception in place of a record where a run
        could not be made.
    """
    seeds = list(seeds)
    jobs: list[Job] = [(str(scenario), seed) for scenario in scenarios for seed in seeds]
    workers = min(workers or os.cpu_count() or 1, len(jobs))
    if workers <= 1:
        for job in jobs:
            yield job, _guarded(job)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        running = {pool.submit(run_one, job): job for job in jobs}
        for future in as_completed(running):
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            yield running[future], future.result() if error is None else error


def _guarded(job: Job) -> dict[str, Any] | Exception:
    try:
        return run_one(job)
    except Exception as error:
        return error
