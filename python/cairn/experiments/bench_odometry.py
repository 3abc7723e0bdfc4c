"""`cairn bench odometry`: how far off wheels and gyroscope are after 100 m.

A robot drives courses by the truth, so that every odometry sees the same drive: squares of 4 m both
ways round [Borenstein96], a corridor up and down, and turns of all sizes. What it measured is then
played to odometries that know more or less of the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cairn import robots
from cairn.calibration import spin_test
from cairn.experiments.streams import TICK_S, Stream, off
from cairn.odometry import Odometry
from cairn.profile import Profile
from cairn.robots.robot import wrap_angle

Point = tuple[float, float]
REST_S = 10.0


def square(way: int) -> Callable[[np.random.Generator], list[Point]]:
    """Corners of squares of 4 m, to the left (1) or to the right (-1)."""
    return lambda _: [(4.0, 0.0), (4.0, 4.0 * way), (0.0, 4.0 * way), (0.0, 0.0)]


def corridor(_: np.random.Generator) -> list[Point]:
    """Both ends of 20 m."""
    return [(20.0, 0.0), (0.0, 0.0)]


def errands(random: np.random.Generator) -> list[Point]:
    """Random places in a hall of 10 × 10 m."""
    return [(float(x), float(y)) for x, y in random.uniform(-5, 5, (60, 2))]


COURSES: dict[str, Callable[[np.random.Generator], list[Point]]] = {
    "square left": square(1),
    "square right": square(-1),
    "corridor": corridor,
    "errands": errands,
}
# What an odometry knows: (a gyroscope, a rest at the start to learn its bias, a spin test before).
KNOWS: dict[str, tuple[bool, bool, bool]] = {
    "wheels": (False, False, False),
    "wheels, spin test": (False, False, True),
    "gyro, bias unknown": (True, False, False),
    "gyro": (True, True, False),
    "gyro, spin test": (True, True, True),
}


@dataclass(frozen=True)
class Settings:
    """What to measure."""

    courses: tuple[str, ...] = tuple(COURSES)
    robot: str = "kinematic"
    way_m: float = 100.0
    seeds: int = 20
    first_seed: int = 1


def make_robot(kind: str, profile: Profile, seed: int) -> Any:
    """Stand a simulated robot in the open."""
    make = robots.MujocoP3AT if kind == "mujoco" else robots.KinematicRobot
    return make(profile, robots.Scene(), (0.0, 0.0, 0.0), seed=seed)


def drive(robot: Any, places: list[Point], way_m: float, speed_mps: float = 0.5) -> Stream:
    """Rest, then drive from place to place, turning on the spot, until the way is driven."""
    rows: tuple[list, list, list, list] = ([], [], [], [])
    robot.sense()

    def tick(linear: float, angular: float) -> None:
        robot.command((linear, angular))
        robot.advance(TICK_S)
        readings = robot.sense()
        truth = tuple(robot.truth)
        for row, value in zip(
            rows, (readings.ranges_m, readings.wheels_m, readings.gyro_radps, truth), strict=True
        ):
            row.append(value)

    for _ in range(round(REST_S / TICK_S)):
        tick(0.0, 0.0)
    driven, last, k = 0.0, robot.truth, 0
    while driven < way_m:
        goal = places[k % len(places)]
        x, y, heading = robot.truth
        far, bearing = (
            math.dist((x, y), goal),
            wrap_angle(math.atan2(goal[1] - y, goal[0] - x) - heading),
        )
        if far < 0.15:
            k += 1
            continue
        turning = abs(bearing) > (0.5 if far > 0.5 else 1.2)
        slow = min(speed_mps, math.sqrt(2 * 0.25 * far) + 0.05)
        tick(0.0 if turning else slow, max(-1.0, min(1.0, 2.0 * bearing)))
        driven += math.dist(robot.truth[:2], last[:2])
        last = robot.truth
    for _ in range(20):
        tick(0.0, 0.0)
    ranges_m, wheels_m, gyro_radps, truths = map(np.array, rows)
    return Stream(ranges_m, wheels_m, gyro_radps, truths)


def play(stream: Stream, profile: Profile, gyro: bool, rest: bool) -> dict[str, float]:
    """Play a drive to an odometry; return how far off it is at the end and at most."""
    first = round(REST_S / TICK_S)
    odometry = Odometry(profile, stream.truth[0])
    if gyro and rest:
        for tick in range(first):
            odometry.predict(tuple(stream.wheels_m[tick]), float(stream.gyro_radps[tick]), TICK_S)
    odometry.set_pose(stream.truth[first - 1])
    most = 0.0
    for tick in range(first, len(stream)):
        rate = float(stream.gyro_radps[tick]) if gyro else None
        odometry.predict(tuple(stream.wheels_m[tick]), rate, TICK_S)
        far_m, _ = off(odometry.pose, stream.truth[tick])
        most = max(most, far_m)
    far_m, turned_rad = off(odometry.pose, stream.truth[-1])
    sigma_m = math.sqrt(float(np.trace(odometry.covariance[:2, :2])))
    return {"end_m": far_m, "max_m": most, "end_rad": turned_rad, "sigma_m": sigma_m}


def run(settings: Settings, course: str, seed: int) -> list[dict[str, Any]]:
    """Drive one course with one seed, and play it to every odometry."""
    profile = Profile.load("p3at")
    known = profile.drive.effective_track_m
    found = spin_test(make_robot(settings.robot, profile, seed)).effective_track_m
    after = Profile(_with_track(profile.text, known, found))
    places = COURSES[course](np.random.default_rng([seed, 23]))
    stream = drive(make_robot(settings.robot, profile, seed), places, settings.way_m)
    return [
        {"course": course, "odometry": name, "seed": seed}
        | play(stream, after if spun else profile, gyro, rest)
        for name, (gyro, rest, spun) in KNOWS.items()
    ]


def _with_track(text: str, old_m: float, new_m: float) -> str:
    line = next(each for each in text.splitlines() if each.startswith("effective_track_m"))
    assert f"{old_m:g}" in line
    return text.replace(line, f"effective_track_m = {new_m!r}", 1)


def measure(settings: Settings) -> Iterator[list[dict[str, Any]]]:
    """Run every course with every seed."""
    for course in settings.courses:
        for k in range(settings.seeds):
            yield run(settings, course, settings.first_seed + k)


def table(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sum up by odometry and course, then over all courses."""
    courses = list(dict.fromkeys(r["course"] for r in runs))
    rows = []
    for course in [*courses, "all"]:
        for name in KNOWS:
            group = [r for r in runs if r["odometry"] == name and course in ("all", r["course"])]
            ends = np.array([r["end_m"] for r in group])
            rows.append(
                {
                    "course": course,
                    "odometry": name,
                    "runs": len(group),
                    "end_m": float(np.median(ends)),
                    "end_p90_m": float(np.percentile(ends, 90)),
                    "max_m": float(np.median([r["max_m"] for r in group])),
                    "end_rad": float(np.median([r["end_rad"] for r in group])),
                    "within_2_sigma": float(
                        np.mean([r["end_m"] <= 2 * r["sigma_m"] for r in group])
                    ),
                }
            )
    return rows


def summary_of(rows: list[dict[str, Any]], settings: Settings) -> dict[str, Any]:
    """Return the headline figures of `table`."""
    return {
        "robot": settings.robot,
        "way_m": settings.way_m,
        "drift_m": {r["odometry"]: r["end_m"] for r in rows if r["course"] == "all"},
        "drift_p90_m": {r["odometry"]: r["end_p90_m"] for r in rows if r["course"] == "all"},
        "drift_rad": {r["odometry"]: r["end_rad"] for r in rows if r["course"] == "all"},
    }
