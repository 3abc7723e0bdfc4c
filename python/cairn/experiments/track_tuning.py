"""Tunes the numbers of a `Design` by CMA-ES [Hansen16], offline and by seed.

Every candidate drives a set of rehearsals (`cairn.Tracker.rehearse`) on paths drawn by seed, none
of them one that `cairn track` judges by: winding ones, zigzags, lines beside or behind the robot;
at three speeds and spacings, some on a slippery floor or with a latency not expected. Each is
compared with the best of pure pursuit and regulated pure pursuit on the same path.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np

import cairn
from cairn.experiments import track_paths as paths
from cairn.experiments.track import CONDITIONS, Setting, best_of, sweep_baselines
from cairn.experiments.track_design import Design, controller_text
from cairn.experiments.track_drive import Drive, FuzzyFollower, drive, measures, robot_at
from cairn.experiments.track_paths import Reference

# What counts, beside the error: worth of a share of time beyond the allowance, and so on.
ALLOWED_TIME = 1.10
LEAST_RMS_M = 0.001
OVERSHOOT_M = 0.02
# An error of this share of the best baseline's is good enough: from there on, speed is worth more.
GOOD_ENOUGH = 0.4

# V changes by no more than this from one of these bearings to the next.
SMOOTH_MPS = 0.019
BEARINGS = np.linspace(0, math.pi, 400)

# Hardly off course: a driver does not weave here, though the robot answers later than expected.
STRAIGHT = Reference("straight", np.array([(0.0, 0.0), (8.0, 0.0)]), (0.0, 0.04, 0.0))


@dataclass(frozen=True)
class Case:
    """A path to rehearse, and how.

    `noisy` measures with the noise of `cairn track --under noise`. `base` is what the best baseline
    does there; without one only the error counts.
    """

    reference: Reference
    spacing_m: float = 0.15
    cruise_mps: float = 0.5
    turn_share: float = 1.0
    latency_s: float = 0.1
    corner_m: float | None = None
    noisy: bool = False
    base: dict[str, float] | None = None


def training_cases(seed: int) -> list[Case]:
    """What is rehearsed, drawn by seed."""
    first = 100 * seed
    wind, zig, beside, behind = paths.winding, paths.zigzag, paths.displaced, paths.turned
    right = (80.0, 100.0)
    return [
        Case(wind(first + 1), 0.2),
        Case(wind(first + 2, sharpest_per_m=0.8), 0.2, 0.7),
        Case(wind(first + 3, sharpest_per_m=1.6), 0.15, 0.3),
        Case(wind(first + 4), 0.3),
        Case(wind(first + 5, sharpest_per_m=0.9), 0.2),
        Case(wind(first + 6), turn_share=0.85),
        Case(wind(first + 7), latency_s=0.2),
        Case(replace(wind(first + 8), start=(0.0, 0.0, 0.8)), 0.2, corner_m=0.035),
        Case(wind(first + 1), 0.2, noisy=True),
        Case(wind(first + 9, sharpest_per_m=0.9), 0.2, noisy=True),
        Case(zig(first + 9), 0.2, noisy=True),
        Case(paths.arcs(first + 1), 0.2),
        Case(paths.arcs(first + 2), 0.3),
        Case(paths.arcs(first + 3), 0.15, latency_s=0.2),
        Case(zig(first + 1), 0.2, corner_m=0.04),
        Case(zig(first + 2, turn_deg=right), 0.2, corner_m=0.04),
        Case(zig(first + 3, turn_deg=right, leg_m=(2.5, 5.0)), 0.2, corner_m=0.04),
        Case(zig(first + 2, turn_deg=right), 0.3, corner_m=0.04),
        Case(zig(first + 4), 0.2, 0.7),
        Case(zig(first + 5), 0.15, 0.3, corner_m=0.04),
        Case(zig(first + 6, turn_deg=(20, 60), leg_m=(0.7, 2.0)), corner_m=0.04),
        Case(zig(first + 7), 0.3, turn_share=1.15, corner_m=0.05),
        Case(beside(first + 1), 0.2),
        Case(beside(first + 2), 0.2, 0.7),
        Case(beside(first + 3)),
        Case(beside(first + 4), turn_share=0.85),
        Case(beside(first + 5), 0.3),
        Case(behind(first + 1), 0.2),
        Case(behind(first + 2), 0.3),
        Case(behind(first + 3), latency_s=0.2),
        Case(STRAIGHT, 0.1),
        Case(STRAIGHT, 0.3, latency_s=0.2),
        Case(STRAIGHT, 0.15, latency_s=0.2),
        Case(beside(first + 6, aside_m=(0.9, 1.1), heading_rad=0.1), 0.2),
        Case(beside(first + 7, aside_m=(0.9, 1.1), heading_rad=0.1), 0.3),
    ]


def cost_of(case: Case, told: dict[str, Any]) -> float:
    """What a rehearsal costs: 1 is about as good as the best baseline."""
    if not told["reached"]:
        return 20.0
    base = case.base or {"time_s": math.inf, "effort_v_mps": 1.0, "effort_w_radps": 4.0}
    joins = told["overshoot_m"] is not None
    key = "after_turn_rms_m" if case.reference.joins and not joins else "rms_m"
    cost = max((told[key] or 0.0) / max(base.get(key, 0.01), LEAST_RMS_M), GOOD_ENOUGH)
    if not case.reference.joins and case.corner_m is None:
        late = (told["rms_late_m"] or 0.0) / max(base.get("rms_late_m", 0.005), LEAST_RMS_M)
        cost += max(late, GOOD_ENOUGH)
    slow = told["time_s"] / base["time_s"] - ALLOWED_TIME
    cost += 40.0 * max(0.0, slow) + 1.0 * max(0.0, slow + 0.1)
    for effort in ("effort_v_mps", "effort_w_radps"):
        cost += 0.2 * math.log(max(told[effort] / base[effort], 1.0))
    if case.reference.name == STRAIGHT.name:
        cost += 0.1 * told["effort_w_radps"]
    cost += 20.0 * max(0.0, told["arrival_error_m"] - 0.03)
    if case.corner_m is not None:
        cost += 15.0 * max(0.0, told["max_m"] / case.corner_m - 1)
    if joins:
        cost += 2.0 * max(0.0, told["overshoot_m"] / OVERSHOOT_M - 1)
        cost += 0.05 * (told["settled_s"] if told["settled_s"] is not None else told["time_s"])
    return cost


def roughness(text: str, profile: cairn.Profile) -> float:
    """How much steeper than `SMOOTH_MPS` the surface of V falls with the bearing, as a share."""
    control = cairn.Tracker(text, profile).control
    steepest = max(
        np.abs(np.diff(control.evaluate(C=0.0, Vc=0.35, dR=distance, dtheta=BEARINGS)["V"])).max()
        for distance in (0.1, 0.3, 0.6, 1.5)
    )
    return max(0.0, float(steepest) / SMOOTH_MPS - 1)


def rehearsed(text: str, case: Case, profile: cairn.Profile) -> dict[str, Any]:
    """The measures of one rehearsal of a controller."""
    tracker = cairn.Tracker(text, profile, cruise_mps=case.cruise_mps)
    tracker.follow(case.reference.path, spacing_m=case.spacing_m)
    if case.noisy:
        conditions = CONDITIONS["noise"][1]
        robot = robot_at("kinematic", profile, case.reference.start, conditions)
        return measures(drive(FuzzyFollower(tracker), robot, case.reference, conditions))
    done = tracker.rehearse(
        case.reference.start,
        latency_s=case.latency_s,
        turn_share=case.turn_share,
        most_s=20 + 8 * case.reference.length_m / min(case.cruise_mps, 0.5) / 2,
    )
    return measures(Drive(case.reference, done.times_s, done.poses, done.twists, done.commands))


def with_baseline(case: Case) -> Case:
    """The case with what the best of the baselines does on its path, undisturbed."""
    under = "noise" if case.noisy else "none"
    setting = Setting(cruise_mps=case.cruise_mps, under=under)
    best = best_of(sweep_baselines(case.reference, setting))
    keys = ("rms_m", "rms_late_m", "after_turn_rms_m", "time_s", "effort_v_mps", "effort_w_radps")
    return replace(case, base={key: best["measures"][key] or 0.0 for key in keys})


def total_cost(text: str, cases: list[Case], profile: cairn.Profile) -> float:
    """Mean over the cases, with weight on the worst ones."""
    costs = np.array([cost_of(case, rehearsed(text, case, profile)) for case in cases])
    worst = 0.25 * np.sort(costs)[-4:].mean()
    return float(costs.mean() + worst + 2.0 * roughness(text, profile))


def tune(
    *,
    seed: int = 1,
    evaluations: int = 3000,
    start: Design | None = None,
    spread: float = 0.06,
    profile: cairn.Profile | None = None,
    drawn: list[Case] | None = None,
    workers: int = 1,
    advance: Callable[[int, float, Design], None] = lambda count, cost, best: None,
) -> tuple[Design, dict[str, Any]]:
    """Search for the design of least cost; the same seed finds the same one.

    Args:
        seed: of the paths and of the search.
        evaluations: candidates tried.
        start: where to begin.
        spread: of the first candidates, as a share of each number's range.
        profile: the robot; the P3-AT.
        drawn: what to rehearse, instead of `training_cases(seed)`.
        workers: processes to rehearse in; what is found does not depend on it.
        advance: called with how many were tried, the least cost so far, and the design of it.

    Returns:
        The best design, and a record of the search.

    Raises:
        TunerNotInstalled: no `cma`.
    """
    try:
        import cma
    except ImportError as error:
        raise cairn.errors.TunerNotInstalled(
            "tuning needs the package `cma`: pip install 'cairn-nav[tune]'"
        ) from error
    profile = profile or cairn.Profile.load("p3at")
    cases = [
        case if case.base is not None else with_baseline(case)
        for case in drawn or training_cases(seed)
    ]
    begin = start or Design()
    best, least = begin, total_cost(controller_text(begin), cases, profile)
    history = [(0, least)]
    options = {
        "seed": seed, "bounds": [0, 1], "verbose": -9, "maxfevals": evaluations, "CMA_diagonal": 30,
    }  # fmt: skip
    search = cma.CMAEvolutionStrategy(begin.to_unit(), spread, options)
    count = 0
    with contextlib.ExitStack() as stack:
        spread_out: Any = map
        if workers > 1:
            pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
            spread_out = stack.enter_context(pool).map
        while count < evaluations and not search.stop():
            points = search.ask()
            designs = [Design.from_unit(point).rounded() for point in points]
            texts = [controller_text(design) for design in designs]
            costs = list(spread_out(partial(total_cost, cases=cases, profile=profile), texts))
            search.tell(points, costs)
            first = int(np.argmin(costs))
            if costs[first] < least:
                best, least = designs[first], costs[first]
            count += len(points)
            history.append((count, least))
            advance(count, least, best)
    told = [
        {"path": c.reference.name, **rehearsed(controller_text(best), c, profile)} for c in cases
    ]
    record = {"seed": seed, "evaluations": count, "cost": least, "history": history, "cases": told}
    return best, record
