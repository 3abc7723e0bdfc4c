"""What a robot measures on a drive, with the truth beside it: recorded once, played to many."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import cairn
from cairn import robots
from cairn.profile import Profile
from cairn.robots.robot import wrap_angle
from cairn.world import World

TICK_S = 0.1
LIDAR = """
[lidar]                         # a scanner on the deck: 270° in steps of 1.5°
pose = { x = 0.15, y = 0.0, heading = 0.0 }
beams = 181
first_rad = -2.356194
step_rad = 0.0261799
min_range_m = 0.05
max_range_m = 10.0
"""


@dataclass(frozen=True)
class Stream:
    """One drive, tick by tick."""

    ranges_m: NDArray[np.float64]
    """(ticks, sensors)"""
    wheels_m: NDArray[np.float64]
    """(ticks, 2): travel of left and right since the tick before."""
    gyro_radps: NDArray[np.float64]
    truth: NDArray[np.float64]
    """(ticks, 3): (x, y, heading) [m, m, rad]."""

    def __len__(self) -> int:
        return len(self.truth)

    def then(self, other: Stream) -> Stream:
        """Return this drive, then the other: between them the robot is carried away."""
        return Stream(
            *(
                np.concatenate([getattr(self, name), getattr(other, name)])
                for name in ("ranges_m", "wheels_m", "gyro_radps", "truth")
            )
        )

    def part(self, start: int, stop: int) -> Stream:
        """Return the ticks from `start` to before `stop`."""
        return Stream(
            self.ranges_m[start:stop],
            self.wheels_m[start:stop],
            self.gyro_radps[start:stop],
            self.truth[start:stop],
        )

    @property
    def way_m(self) -> NDArray[np.float64]:
        """Path driven until each tick, by truth [m]."""
        steps = np.hypot(*np.diff(self.truth[:, :2], axis=0).T)
        return np.concatenate([[0.0], np.cumsum(steps)])


def sonar_robot() -> Profile:
    """The P3-AT with its sixteen sonars."""
    return Profile.load("p3at")


def lidar_robot() -> Profile:
    """The P3-AT with a lidar instead of its sonars."""
    text = sonar_robot().text
    sonars, noise = text.index("[[sonars]]"), text.index("[noise]")
    body = text.index("[physics]")
    return Profile(
        f"{text[:sonars]}{LIDAR}\n{text[body:noise]}"
        + text[noise:].replace("[noise]", "[noise]\nlidar_sigma_m = 0.01", 1)
    )


def record(world: World, profile: Profile, seed: int, seconds: float, boxes: int = 0) -> Stream:
    """Drive between random places of a map and write down what is measured.

    The navigator is told the true pose: what is recorded does not depend on any localisation.

    Args:
        world: what stands there.
        profile: the robot.
        seed: of places and noise.
        seconds: how long.
        boxes: things that the map does not show, at random places.
    """
    random = np.random.default_rng([seed, 17])
    places = Places(world, profile, random)
    start = places.pose()
    scene = robots.Scene.from_world(world, places.boxes(boxes, away_from=start))
    robot = robots.KinematicRobot(profile, scene, start, seed=seed)
    navigator = cairn.Navigator(profile, world, start=start)
    navigator.set_goal(places.point())
    rows: tuple[list, list, list, list] = ([], [], [], [])
    for _ in range(round(seconds / TICK_S)):
        readings = robot.sense()
        truth = tuple(robot.truth)
        for row, value in zip(
            rows, (readings.ranges_m, readings.wheels_m, readings.gyro_radps, truth), strict=True
        ):
            row.append(value)
        decision = navigator.step(
            readings.ranges_m, readings.wheels_m, readings.gyro_radps, TICK_S, truth
        )
        if decision.goal_status in ("reached", "refused"):
            navigator.set_goal(places.point())
        robot.command(decision.twist)
        robot.advance(TICK_S)
    ranges_m, wheels_m, gyro_radps, truths = map(np.array, rows)
    return Stream(ranges_m, wheels_m, gyro_radps, truths)


class Places:
    """Random places of a map that the robot can reach from one another."""

    def __init__(self, world: World, profile: Profile, random: np.random.Generator) -> None:
        self.world, self.random = world, random
        costs = cairn.costmap(world, profile).costs
        assert costs is not None
        free = np.isfinite(costs)
        self.cells = np.argwhere(_largest_part(free) & _roomy(world, 0.5))

    def point(self) -> tuple[float, float]:
        """Return a place [m]."""
        row, col = self.cells[self.random.integers(len(self.cells))]
        x, y = self.world.point_of((int(row), int(col)))
        return (float(x), float(y))

    def pose(self) -> tuple[float, float, float]:
        """Return a place and a heading [m, m, rad]."""
        return (*self.point(), float(self.random.uniform(-math.pi, math.pi)))

    def boxes(self, count: int, away_from: tuple[float, ...]) -> list[robots.Box]:
        """Return boxes at places at least 1.5 m from a point."""
        found = []
        while len(found) < count:
            x, y = self.point()
            if math.dist((x, y), away_from[:2]) > 1.5:
                sides = self.random.uniform(0.3, 0.6, 2)
                turn = float(self.random.uniform(0, math.pi))
                found.append(
                    robots.Box(x, y, float(sides[0]), float(sides[1]), turn, f"box {len(found)}")
                )
        return found


def _roomy(world: World, metres: float) -> NDArray[np.bool_]:
    return cairn.distance_to_occupied(world.occupancy == 1, world.resolution_m) > metres


def _largest_part(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The largest part of the free cells that hangs together, side by side."""
    left, best = free.copy(), np.zeros_like(free)
    while left.any():
        row, col = np.argwhere(left)[0]
        field = cairn.plan_grid(free, goal=(int(row), int(col)))
        part = np.isfinite(field.cost_to_go) & free
        if part.sum() > best.sum():
            best = part
        left &= ~part
        if left.sum() <= best.sum():
            break
    return best


def off(pose: tuple[float, ...], truth: NDArray[np.float64]) -> tuple[float, float]:
    """Return how far a pose is from the truth [m, rad]."""
    return (
        math.hypot(pose[0] - truth[0], pose[1] - truth[1]),
        abs(wrap_angle(pose[2] - float(truth[2]))),
    )
