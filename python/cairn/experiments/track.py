"""`cairn track`: the fuzzy tracker beside pure pursuit on the same path, robot and conditions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

import cairn
from cairn.experiments.track_drive import (
    Conditions,
    Drive,
    Follower,
    FuzzyFollower,
    drive,
    measures,
    most,
    profile_with,
    rms,
    robot_at,
)
from cairn.experiments.track_paths import Reference
from cairn.experiments.track_pursuit import PurePursuit, regulated
from cairn.profile import Profile
from cairn.tracking import deviations

LOOKAHEADS_M = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
MOST_TIME_RATIO = 1.15
BASELINES = {"pure pursuit": PurePursuit, "regulated pure pursuit": regulated}


CONDITIONS: dict[str, tuple[str, Conditions]] = {
    "none": ("perfect pose, 100 ms loop, 100 ms latency", Conditions()),
    "slip": (
        "a floor that changes every 3 m: turn rate × 1, 0.75, 1.15 of the wheels'",
        Conditions(turn_share=lambda way_m: (1.0, 0.75, 1.15)[int(way_m / 3.0) % 3]),
    ),
    "carpet": (
        "dead band: no turning below 0.12 rad/s, no driving below 0.03 m/s",
        Conditions(dead_band_radps=0.12, dead_band_mps=0.03),
    ),
    "latency": ("300 ms of latency, known to the tracker", Conditions(latency_s=0.3)),
    "late": (
        "200 ms of latency, believed to be 100 ms",
        Conditions(latency_s=0.2, told_latency_s=0.1),
    ),
    "noise": (
        "measured pose ± 1 cm, ± 1°, speeds ± 5 % (white)",
        Conditions(pose_sigma_m=0.01, heading_sigma_rad=math.radians(1), twist_sigma=0.05),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """How a path is driven."""

    robot: str = "kinematic"
    cruise_mps: float = 0.5
    spacing_m: float = 0.2
    controller: str = "p3at"
    under: str = "none"
    seed: int = 1


AS_BELIEVED = Setting()


def drive_ours(reference: Reference, setting: Setting = AS_BELIEVED) -> Drive:
    """Drive a path with the fuzzy tracker."""
    conditions = CONDITIONS[setting.under][1]
    told_s = (
        conditions.latency_s if conditions.told_latency_s is None else conditions.told_latency_s
    )
    profile = profile_with(Profile.load("p3at"), told_s)
    tracker = cairn.Tracker(setting.controller, profile, cruise_mps=setting.cruise_mps)
    tracker.follow(reference.path, spacing_m=setting.spacing_m)
    return _driven(FuzzyFollower(tracker), reference, setting)


def drive_baseline(
    kind: str, lookahead_m: float, reference: Reference, setting: Setting = AS_BELIEVED
) -> Drive:
    """Drive a path with one of `BASELINES`."""
    limits = Profile.load("p3at").limits
    follower = BASELINES[kind](reference.path, lookahead_m, setting.cruise_mps, limits)
    return _driven(follower, reference, setting)


def _driven(follower: Follower, reference: Reference, setting: Setting) -> Drive:
    conditions = CONDITIONS[setting.under][1]
    body = robot_at(setting.robot, Profile.load("p3at"), reference.start, conditions)
    return drive(follower, body, reference, conditions, seed=setting.seed)


def sweep_baselines(
    reference: Reference,
    setting: Setting = AS_BELIEVED,
    advance: Callable[[str], None] = lambda what: None,
) -> list[dict[str, Any]]:
    """Every baseline with every look-ahead: `kind`, `lookahead_m`, `measures`, `drive`."""
    swept = []
    for kind in BASELINES:
        for lookahead_m in LOOKAHEADS_M:
            advance(f"{kind} {lookahead_m} m")
            run = drive_baseline(kind, lookahead_m, reference, setting)
            swept.append(
                {"kind": kind, "lookahead_m": lookahead_m, "measures": measures(run), "drive": run}
            )
    return swept


def best_of(swept: list[dict[str, Any]]) -> dict[str, Any]:
    """The one of least RMS error among those that reached the goal (or among all)."""
    reached = [entry for entry in swept if entry["measures"]["reached"]] or swept
    return min(reached, key=lambda entry: entry["measures"]["rms_m"] or math.inf)


def compare(
    reference: Reference,
    setting: Setting,
    advance: Callable[[str], None] = lambda what: None,
) -> dict[str, Any]:
    """A path driven by the fuzzy tracker and by every baseline, in the same conditions.

    Returns:
        `summary`: ours and the best baseline in numbers, `rms_ratio` and `time_ratio` to it,
        `ahead` whether ours has the lower RMS error in at most 1.15 times its time; `ours`, `best`
        (measures and traces), `baselines` (measures of all).
    """
    advance("fuzzy tracker")
    run = drive_ours(reference, setting)
    ours = measures(run)
    swept = sweep_baselines(reference, setting, advance)
    best = best_of(swept)
    rms_ratio = ours["rms_m"] / max(best["measures"]["rms_m"], 1e-6)
    time_ratio = ours["time_s"] / best["measures"]["time_s"]
    summary = {
        "path": reference.name,
        "joins": reference.joins,
        **asdict(setting),
        "conditions": CONDITIONS[setting.under][0],
        "ours": ours,
        "best_baseline": {
            "kind": best["kind"], "lookahead_m": best["lookahead_m"], **best["measures"],
        },
        "rms_ratio": rms_ratio,
        "time_ratio": time_ratio,
        "ahead": bool(ours["reached"] and rms_ratio < 1.0 and time_ratio <= MOST_TIME_RATIO),
    }  # fmt: skip
    return {
        "summary": summary,
        "reference_m": reference.path,
        "ours": trace(run),
        "best": trace(best["drive"]),
        "baselines": [
            {key: entry[key] for key in ("kind", "lookahead_m", "measures")} for entry in swept
        ],
    }


def trace(run: Drive) -> dict[str, Any]:
    """A drive as plain lists."""
    return {
        "times_s": run.times_s,
        "poses": run.poses,
        "twists": run.twists,
        "commands": run.commands,
    }


SPACINGS_M = (0.1, 0.15, 0.2, 0.3, 0.45, 0.6)
SPEEDS_MPS = (0.3, 0.5, 0.7)


def steps(*, sweep: bool) -> int:
    """How often `sweep`, or else `compare`, tells of an advance."""
    swept = len(SPEEDS_MPS) * len(SPACINGS_M)
    return swept if sweep else 1 + len(BASELINES) * len(LOOKAHEADS_M)


def sweep(
    reference: Reference, setting: Setting, advance: Callable[[str], None] = lambda what: None
) -> dict[str, Any]:
    """The paper's claim: waypoints close together are precise and slow, far apart fast.

    The path is driven at every spacing and speed; `summary` holds, for each speed, RMS and time by
    spacing, and whether time falls and error rises with it.
    """
    rows = []
    for cruise_mps in SPEEDS_MPS:
        for spacing_m in SPACINGS_M:
            advance(f"{cruise_mps} m/s, {spacing_m} m")
            here = replace(setting, cruise_mps=cruise_mps, spacing_m=spacing_m)
            run = drive_ours(reference, here)
            rows.append({"cruise_mps": cruise_mps, "spacing_m": spacing_m, **measures(run)})
    by_speed = {
        str(speed): {
            "rms_m": [row["rms_m"] for row in rows if row["cruise_mps"] == speed],
            "time_s": [row["time_s"] for row in rows if row["cruise_mps"] == speed],
        }
        for speed in SPEEDS_MPS
    }
    summary = {
        "path": reference.name,
        "robot": setting.robot,
        "controller": setting.controller,
        "under": setting.under,
        "spacings_m": list(SPACINGS_M),
        "by_speed": by_speed,
    }
    return {"summary": summary, "drives": rows}


def swap(setting: Setting) -> dict[str, Any]:
    """A path exchanged while driving, and once more: nothing is parametrised anew, nothing jumps.

    From a straight line, at cruising speed, to a curve that begins where the robot is; then to a
    line 0.5 m aside.
    """
    profile = Profile.load("p3at")
    tracker = cairn.Tracker(setting.controller, profile, cruise_mps=setting.cruise_mps)
    first = np.array([(0.0, 0.0), (12.0, 0.0)])
    tracker.follow(first, spacing_m=setting.spacing_m)
    conditions = CONDITIONS[setting.under][1]
    body = robot_at(setting.robot, profile, (0.0, 0.0, 0.0), conditions)
    followed = [first]
    swapped_at: list[float] = []
    ticks = {60: "curve", 130: "aside"}

    def exchange(tick: int) -> None:
        if tick not in ticks:
            return
        x, y, heading = body.truth
        c, s = math.cos(heading), math.sin(heading)
        if ticks[tick] == "curve":
            a = np.linspace(0, 2.2, 200)
            local = np.column_stack([2.0 * np.sin(a), 2.0 * (1 - np.cos(a))])
        else:
            local = np.array([(0.0, 0.5), (6.0, 0.5)])
        path = np.array([x, y]) + local @ np.array([(c, s), (-s, c)])
        followed.append(path)
        swapped_at.append(tick * conditions.tick_s)
        tracker.follow(path, spacing_m=setting.spacing_m)

    # The end is that of the last path: the drive is cut by time, and judged piece by piece.
    ghost = Reference("swap", np.array([(-900.0, 0.0), (-901.0, 0.0)]), (0.0, 0.0, 0.0))
    run = drive(
        FuzzyFollower(tracker), body, ghost, conditions, seed=setting.seed, most_s=32.0,
        at_tick=exchange,
    )  # fmt: skip
    bounds = [0, *(round(t / conditions.tick_s) for t in swapped_at), len(run.times_s)]
    pieces = []
    for path, begin, end in zip(followed, bounds[:-1], bounds[1:], strict=True):
        left_m, _ = deviations(path, run.poses[begin:end, :2])
        driven = np.cumsum(np.hypot(*np.diff(run.poses[begin:end, :2], axis=0).T))
        late = np.concatenate([[False], driven > 1.5]) & (driven[-1] > 0)
        pieces.append(
            {"from_s": begin * conditions.tick_s, "rms_m": rms(left_m), "max_m": most(left_m),
             "max_after_1_5_m": most(left_m[late])}
        )  # fmt: skip
    changes = np.abs(np.diff(run.commands, axis=0)).max(0)
    allowed = np.array([profile.limits.linear_mps2, profile.limits.angular_radps2])
    summary = {
        "path": "swap",
        **asdict(setting),
        "pieces": pieces,
        "greatest_change_v_mps": float(changes[0]),
        "greatest_change_w_radps": float(changes[1]),
        "within_limits": bool((changes <= allowed * conditions.tick_s + 1e-9).all()),
        "arrival_error_m": float(np.hypot(*(run.poses[-1, :2] - followed[-1][-1]))),
        "least_v_mps": float(run.commands[:, 0].min()),
    }
    return {"summary": summary, "paths_m": followed, "ours": trace(run)}
