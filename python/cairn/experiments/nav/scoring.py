"""The score of the BARN Challenge, and how sure a mean over worlds is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

CAP, OLD_CAP = (2.0, 8.0), (4.0, 8.0)
"""Actual times are clipped to these multiples of the optimal time: now, and before 2024."""

RESAMPLES = 2000


def score(
    success: bool,
    actual_s: float,
    path_length_m: float,
    top_speed_mps: float,
    cap: tuple[float, float],
) -> float:
    """Success · OT / clip(AT, cap), with the optimal time OT of the path at top speed [Xiao23].

    Args:
        success: the goal was reached without contact and in time.
        actual_s: AT, from the moment the robot has moved 0.1 m.
        path_length_m: of the world.
        top_speed_mps: 2 m/s in the challenge.
        cap: lower and upper bound of AT, in optimal times.
    """
    if not success:
        return 0.0
    optimal_s = path_length_m / top_speed_mps
    return float(optimal_s / np.clip(actual_s, cap[0] * optimal_s, cap[1] * optimal_s))


def mean_over_worlds(worlds: Sequence[Sequence[float]]) -> float | None:
    """Mean of the means of every world's trials; None without a world."""
    return float(np.mean([np.mean(trials) for trials in worlds])) if worlds else None


def interval(worlds: Sequence[Sequence[float]], seed: int) -> list[float] | None:
    """95 % bootstrap interval of `mean_over_worlds`: worlds are drawn anew, then their trials."""
    if not worlds:
        return None
    random = np.random.default_rng([seed, len(worlds)])
    means = np.zeros((RESAMPLES, len(worlds)))
    for column, trials in enumerate(worlds):
        values = np.asarray(trials, float)
        drawn = random.integers(len(values), size=(RESAMPLES, len(values)))
        means[:, column] = values[drawn].mean(axis=1)
    chosen = random.integers(len(worlds), size=means.shape)
    estimates = np.take_along_axis(means, chosen, axis=1).mean(axis=1)
    return [float(bound) for bound in np.quantile(estimates, [0.025, 0.975])]


def figures(worlds: Sequence[Sequence[dict[str, Any]]], seed: int) -> dict[str, Any]:
    """Summary of trials, world by world (`Trial.to_dict`)."""

    def values(key: str) -> list[list[float]]:
        return [[float(trial[key]) for trial in trials] for trials in worlds]

    def share(outcome: str) -> list[list[float]]:
        return [[float(trial["outcome"] == outcome) for trial in trials] for trials in worlds]

    succeeded = share("success")
    times = [t["time_s"] for trials in worlds for t in trials if t["outcome"] == "success"]
    return {
        "worlds": len(worlds),
        "trials": sum(map(len, worlds)),
        "success": mean_over_worlds(succeeded),
        "collision": mean_over_worlds(share("collision")),
        "timeout": mean_over_worlds(share("timeout")),
        "error": mean_over_worlds(share("error")),
        "score": mean_over_worlds(values("score")),
        "score_old_cap": mean_over_worlds(values("score_old_cap")),
        "time_s": float(np.mean(times)) if times else None,
        "success_95": interval(succeeded, seed),
        "collision_95": interval(share("collision"), seed),
        "timeout_95": interval(share("timeout"), seed),
        "score_95": interval(values("score"), seed),
        "score_old_cap_95": interval(values("score_old_cap"), seed),
    }
