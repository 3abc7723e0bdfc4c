"""`cairn bench localise`: found from nothing, found again, kept; and honest where it cannot be.

Drives are recorded once (`streams`), with the truth beside them, and played to localisers that see
readings only. What is judged by truth: the first pose a localiser vouches for must be right.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import cairn
from cairn.experiments.streams import TICK_S, Stream, lidar_robot, off, record, sonar_robot
from cairn.localisation import Localiser, MonteCarlo
from cairn.odometry import MapMatcher, Odometry
from cairn.profile import Profile
from cairn.world import World

RIGHT_M, RIGHT_RAD = 0.3, math.radians(10)
MAPS = ("office", "warehouse", "labyrinth", "room", "dead_end")
SENSORS = {"sonar": sonar_robot, "lidar": lidar_robot}
# A localiser is also played drives of other worlds: here it must not find itself.
WRONG = {"office": "labyrinth", "warehouse": "office", "labyrinth": "warehouse"}
# Worlds that look the same from two or four poses: here nobody can tell.
SYMMETRIC = ("hall", "twin corridor")
KIDNAP_AFTER_S = 15.0
# A start that is told wrong by this much: 0.25 m aside and 5 degrees.
OFF_M, OFF_RAD = 0.25, math.radians(5)


@dataclass(frozen=True)
class Settings:
    """What to measure."""

    maps: tuple[str, ...] = MAPS
    sensors: tuple[str, ...] = tuple(SENSORS)
    trials: int = 20
    seconds: float = 60.0
    boxes: int = 6
    seed: int = 1
    honesty: bool = True


@dataclass
class Trial:
    """One localiser, one drive."""

    kind: str
    map: str
    sensor: str
    seed: int
    found_s: float | None = None
    """Until it first vouched for a pose, or again after the kidnapping."""
    found_m: float | None = None
    """Way driven until then."""
    noticed_s: float | None = None
    """After a kidnapping, until it no longer vouched for the old place."""
    wrong_after: float = 0.0
    """Share of the ticks at which it vouched for a wrong pose, once it had noticed."""
    right: bool = False
    """That pose was right, and so were those until the end."""
    vouched: float = 0.0
    """Share of the ticks at which it vouched for a pose (after the kidnapping)."""
    wrong: float = 0.0
    """Share of the ticks at which it vouched for a wrong one."""
    errors_m: list[float] = field(default_factory=list)
    errors_rad: list[float] = field(default_factory=list)
    step_ms: float = 0.0
    search_ms: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain JSON, errors summed up."""
        return {
            "kind": self.kind,
            "map": self.map,
            "sensor": self.sensor,
            "seed": self.seed,
            "found_s": self.found_s,
            "found_m": self.found_m,
            "noticed_s": self.noticed_s,
            "wrong_after": self.wrong_after,
            "right": self.right,
            "vouched": self.vouched,
            "wrong": self.wrong,
            **error_summary(self.errors_m, self.errors_rad),
            "step_ms": self.step_ms,
            "search_ms": self.search_ms,
        }


def error_summary(errors_m: Iterable[float], errors_rad: Iterable[float]) -> dict[str, Any]:
    """Return root mean square and greatest error, None without any."""
    metres, turns = np.array(list(errors_m)), np.array(list(errors_rad))
    if not len(metres):
        return {"rms_m": None, "max_m": None, "rms_rad": None}
    return {
        "rms_m": float(np.sqrt((metres**2).mean())),
        "max_m": float(metres.max()),
        "rms_rad": float(np.sqrt((turns**2).mean())),
    }


def world_of(name: str) -> World:
    """Return a shipped map, or the corridor that looks the same from both ends."""
    return twin_corridor() if name == "twin corridor" else cairn.maps.load(name)


def twin_corridor() -> World:
    """A corridor of 20 m with niches, the same when turned by half a turn."""
    cells = np.ones((80, 400), np.uint8)
    cells[20:60, 4:396] = 0
    for col in range(40, 200, 53):
        cells[60:72, col : col + 24] = 0
    cells[8:20, 100:120] = 0
    both = np.minimum(cells, cells[::-1, ::-1])
    return World(both, 0.05, (0.0, 0.0, 0.0), name="twin corridor")


def play(
    trial: Trial,
    world: World,
    profile: Profile,
    stream: Stream,
    *,
    start: tuple[float, float, float] | None,
    judged_from: int = 0,
) -> Trial:
    """Play a drive to a localiser and judge what it vouches for, from a tick on."""
    localiser = Localiser(world, profile, start=start, seed=trial.seed)
    way, took, searches = stream.way_m, [], []
    vouched, wrong, wrong_after = 0, 0, 0
    lost = judged_from == 0  # a pose vouched for at once counts as found only after a loss
    for tick in range(len(stream)):
        began = time.process_time()
        report = localiser.step(
            stream.ranges_m[tick],
            (float(stream.wheels_m[tick, 0]), float(stream.wheels_m[tick, 1])),
            float(stream.gyro_radps[tick]),
            TICK_S,
        )
        (searches if report.searched else took).append(1e3 * (time.process_time() - began))
        if tick < judged_from:
            continue
        lost = lost or not report.is_found
        if trial.noticed_s is None and (lost or report.jump is not None):
            trial.noticed_s = (tick - judged_from) * TICK_S
        if not report.is_found:
            continue
        far_m, turned_rad = off(localiser.pose, stream.truth[tick])
        is_right = far_m <= RIGHT_M and turned_rad <= RIGHT_RAD
        vouched += 1
        wrong += not is_right
        wrong_after += not is_right and trial.noticed_s is not None
        if lost or is_right:
            if trial.found_s is None:
                trial.found_s = (tick - judged_from) * TICK_S
                trial.found_m = float(way[tick] - way[judged_from])
            trial.errors_m.append(far_m)
            trial.errors_rad.append(turned_rad)
    judged = len(stream) - judged_from
    trial.vouched, trial.wrong = vouched / judged, wrong / judged
    trial.wrong_after = wrong_after / judged
    trial.right = trial.found_s is not None and max(trial.errors_m) <= RIGHT_M
    trial.step_ms = float(np.mean(took)) if took else 0.0
    trial.search_ms = float(np.mean(searches)) if searches else 0.0
    return trial


def play_odometry(
    trial: Trial, world: World | None, profile: Profile, stream: Stream, start: tuple[float, ...]
) -> Trial:
    """Play a drive to odometry, matched to a map or not: what a localiser is compared with."""
    odometry = Odometry(profile, start)
    matcher = None if world is None else MapMatcher(world)
    for tick in range(len(stream)):
        odometry.predict(
            (float(stream.wheels_m[tick, 0]), float(stream.wheels_m[tick, 1])),
            float(stream.gyro_radps[tick]),
            TICK_S,
        )
        if matcher is not None:
            matcher.correct(odometry, profile, stream.ranges_m[tick])
        far_m, turned_rad = off(odometry.pose, stream.truth[tick])
        trial.errors_m.append(far_m)
        trial.errors_rad.append(turned_rad)
    trial.right = trial.errors_m[-1] <= RIGHT_M
    return trial


@dataclass(frozen=True)
class Job:
    """Trials that share their drives."""

    kind: str
    map: str
    sensor: str
    seed: int
    seconds: float
    boxes: int


def jobs_of(settings: Settings) -> list[Job]:
    """Return everything to do."""
    jobs = []
    for sensor in settings.sensors:
        for name in settings.maps:
            for k in range(settings.trials):
                seed = settings.seed * 1000 + k
                jobs.append(Job("drive", name, sensor, seed, settings.seconds, settings.boxes))
        if settings.honesty:
            for k in range(max(1, settings.trials // 4)):
                seed = settings.seed * 1000 + k
                jobs += [
                    Job("wrong map", name, sensor, seed, settings.seconds, 0)
                    for name in settings.maps
                    if name in WRONG
                ]
                jobs += [
                    Job("symmetric", name, sensor, seed, settings.seconds, 0) for name in SYMMETRIC
                ]
    return jobs


def run(job: Job) -> list[dict[str, Any]]:
    """Record the drives of a job, play them, and return its trials."""
    profile, world = SENSORS[job.sensor](), world_of(job.map)

    def trial(kind: str) -> Trial:
        return Trial(kind, job.map, job.sensor, job.seed)

    if job.kind == "wrong map":
        stream = record(world_of(WRONG[job.map]), profile, job.seed, job.seconds)
        return [play(trial("wrong map"), world, profile, stream, start=None).to_dict()]
    if job.kind == "symmetric":
        stream = record(world, profile, job.seed, job.seconds)
        return [play(trial("symmetric"), world, profile, stream, start=None).to_dict()]
    stream = record(world, profile, job.seed, job.seconds, job.boxes)
    elsewhere = record(world, profile, job.seed + 500_000, job.seconds, job.boxes)
    x, y, heading = map(float, stream.truth[0])
    truth = (x, y, heading)
    aside = np.random.default_rng([job.seed, 3]).uniform(-math.pi, math.pi)
    told = (
        truth[0] + OFF_M * math.cos(aside),
        truth[1] + OFF_M * math.sin(aside),
        truth[2] + math.copysign(OFF_RAD, aside),
    )
    kidnapped = round(KIDNAP_AFTER_S / TICK_S)
    both = stream.part(0, kidnapped).then(elsewhere)
    trials = [
        play(trial("global"), world, profile, stream, start=None),
        play(trial("kidnapped"), world, profile, both, start=truth, judged_from=kidnapped),
        play(trial("tracking"), world, profile, stream, start=truth),
        play(trial("start off"), world, profile, stream, start=told),
        play_odometry(trial("matching"), world, profile, stream, truth),
        play_odometry(trial("matching, start off"), world, profile, stream, told),
        play_odometry(trial("odometry"), None, profile, stream, truth),
    ]
    return [each.to_dict() for each in trials]


def kidnapping(settings: Settings) -> tuple[World, Profile, Stream, int]:
    """Return the first kidnapping of the settings: world, robot, drive, and the tick of it."""
    job = jobs_of(settings)[0]
    world, profile = world_of(job.map), SENSORS[job.sensor]()
    first = record(world, profile, job.seed, KIDNAP_AFTER_S, job.boxes)
    then = record(world, profile, job.seed + 500_000, 30.0, job.boxes)
    return world, profile, first.then(then), len(first)


def measure(settings: Settings, workers: int = 1) -> Iterator[list[dict[str, Any]]]:
    """Run every job, `workers` at a time, in the order of `jobs_of` whatever finishes first."""
    jobs = jobs_of(settings)
    if workers <= 1:
        yield from map(run, jobs)
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        yield from pool.map(run, jobs)


def speed(particles: int = 5000, rounds: int = 200, seed: int = 1) -> dict[str, Any]:
    """Time one update of a set of poses with 16 sonars that all hear, on one core [ms]."""
    world, profile = cairn.maps.load("office"), sonar_robot()
    pose = world.goals["reception"]
    ranges = np.full(16, 1.7)
    config = {"least_particles": particles, "most_particles": particles}
    took = []
    for spread_m in (0.2, 2.0):
        poses = MonteCarlo(world, profile, seed=seed, config=config)
        for _ in range(rounds):
            poses.spread(pose, spread_m, 0.1)
            poses.predict((0.1, 0.0, 0.05))
            began = time.process_time()
            poses.update(ranges)
            took.append(1e3 * (time.process_time() - began))
    poses = MonteCarlo(world, profile, seed=seed)
    began = time.process_time()
    weighed = poses.search(ranges)
    search_ms = 1e3 * (time.process_time() - began)
    return {
        "particles": particles,
        "sonars": 16,
        "update_ms": float(np.median(took)),
        "update_p95_ms": float(np.percentile(took, 95)),
        "search_poses": weighed,
        "search_ms": search_ms,
    }


def table(trials: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sum up by kind, sensor and map, then by kind and sensor over all maps."""
    rows = []
    keys = {(t["kind"], t["sensor"], t["map"]): None for t in trials}
    alls = {(t["kind"], t["sensor"], "all"): None for t in trials}
    for kind, sensor, name in [*keys, *alls]:
        group = [
            t
            for t in trials
            if (t["kind"], t["sensor"]) == (kind, sensor) and name in ("all", t["map"])
        ]
        rows.append({"kind": kind, "sensor": sensor, "map": name, **_of(group)})
    return rows


def _of(group: list[dict[str, Any]]) -> dict[str, Any]:
    found = [t["found_s"] for t in group if t["found_s"] is not None and t["right"]]
    ways = [t["found_m"] for t in group if t["found_m"] is not None and t["right"]]
    noticed = [t["noticed_s"] for t in group if t["noticed_s"] is not None]
    squares = [t["rms_m"] ** 2 for t in group if t["rms_m"] is not None]
    turns = [t["rms_rad"] ** 2 for t in group if t["rms_rad"] is not None]
    most = [t["max_m"] for t in group if t["max_m"] is not None]
    return {
        "trials": len(group),
        "right": float(np.mean([t["right"] for t in group])),
        "found_s": float(np.median(found)) if found else None,
        "found_p90_s": float(np.percentile(found, 90)) if found else None,
        "found_m": float(np.median(ways)) if ways else None,
        "noticed_p90_s": float(np.percentile(noticed, 90)) if noticed else None,
        "noticed_within_10_s": sum(t <= 10.0 for t in noticed) / len(group),
        "vouched": float(np.mean([t["vouched"] for t in group])),
        "wrong_after": float(np.mean([t["wrong_after"] for t in group])),
        "wrong": float(np.mean([t["wrong"] for t in group])),
        "rms_m": float(np.sqrt(np.mean(squares))) if squares else None,
        "max_m": float(max(most)) if most else None,
        "rms_rad": float(np.sqrt(np.mean(turns))) if turns else None,
        "step_ms": float(np.mean([t["step_ms"] for t in group])),
        "search_ms": float(np.mean([t["search_ms"] for t in group])),
    }


def summary_of(rows: list[dict[str, Any]], timing: dict[str, Any]) -> dict[str, Any]:
    """Return the headline figures of `table`, by sensor."""
    summary: dict[str, Any] = {
        "update_ms": timing["update_ms"],
        "update_5000x16_within_2_ms": timing["update_ms"] <= 2.0,
    }
    for row in rows:
        if row["map"] != "all":
            continue
        of = summary.setdefault(row["sensor"], {})
        kind = row["kind"].replace(" ", "_").replace(",", "")
        if row["kind"] in ("global", "kidnapped"):
            of[kind] = {
                k: row[k]
                for k in ("right", "found_s", "found_p90_s", "found_m", "wrong", "wrong_after")
            }
            if row["kind"] == "kidnapped":
                of[kind] |= {k: row[k] for k in ("noticed_p90_s", "noticed_within_10_s")}
        elif row["kind"] in ("wrong map", "symmetric"):
            of[kind] = {k: row[k] for k in ("vouched", "wrong")}
        else:
            of[kind] = {k: row[k] for k in ("right", "rms_m", "max_m", "rms_rad")}
    return summary
