"""The setting of a run: what really stands there, the robots in it, and a navigator for each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import cairn
from cairn import errors
from cairn.missions.scenario import Box, Goal, NewGoal, Scenario, Start

if TYPE_CHECKING:
    from cairn import robots
    from cairn.world import World

Pose = tuple[float, float, float]


@dataclass
class Agent:
    """One robot (`cairn.robots.SimulatedRobot`), its navigator, and what it has to do."""

    name: str
    robot: Any
    navigator: Any
    tasks: list[Goal]


@dataclass
class Setting:
    """What a run plays in: what stands there, what the robots know of it, and the robots."""

    world: World
    known: World | None
    agents: list[Agent]
    pose: str = "odometry"  # what the navigators know of theirs: see `Scenario`

    def point_of(self, where: Start | Goal | NewGoal) -> tuple[float, float]:
        """Return the point [m, world frame] a scenario means."""
        return point_of(where, self.world)


def build(scenario: Scenario, seed: int, *, spares: int = 0) -> Setting:
    """Build the setting a scenario describes, ready to run.

    Args:
        scenario: what to build.
        seed: of everything random.
        spares: how many boxes may be put down during the run.

    Raises:
        CairnError: what the scenario names does not exist or does not fit together.
    """
    from cairn import robots

    known = None if scenario.map == "none" else load_map(scenario.map, scenario.folder)
    world = known if scenario.world is None else load_map(scenario.world.map, scenario.folder)
    assert world is not None  # the scenario is checked: no map needs a world
    profile = cairn.Profile.load(_beside(scenario.profile, scenario.folder))
    pose = _pose_source(scenario, known, profile)
    scene = robots.Scene.from_world(world, [body_of(box) for box in scenario.boxes], spares=spares)
    noise = None if profile.noise is None else profile.noise.scaled(scenario.noise)
    for goal in scenario.goals:
        if goal.explore_s is None:
            point_of(goal, world)
    starts = [start_pose(entry.start, world) for entry in scenario.starts]
    seeds = [seed + 1_000_003 * number for number in range(len(starts))]
    if scenario.robot == "kinematic":
        bodies = [
            robots.KinematicRobot(profile, scene, start, seed=own_seed, noise=noise)
            for start, own_seed in zip(starts, seeds, strict=True)
        ]
    else:
        specs = [
            robots.RobotSpec(profile, start, own_seed, noise, name=entry.name)
            for entry, start, own_seed in zip(scenario.starts, starts, seeds, strict=True)
        ]
        bodies = robots.MujocoWorld(scene, specs).robots
    agents = [
        Agent(
            entry.name,
            body,
            _navigator(scenario, profile, known, start if entry.start.known else None, pose, own),
            [*scenario.goals, *entry.goals],
        )
        for entry, body, start, own in zip(scenario.starts, bodies, starts, seeds, strict=True)
    ]
    return Setting(world, known, agents, pose)


def _navigator(
    scenario: Scenario,
    profile: cairn.Profile,
    known: World | None,
    start: Pose | None,
    pose: str,
    seed: int,
) -> cairn.Navigator:
    config = dict(scenario.navigator)
    if pose == "localised":
        config["localise"] = True
        config["localiser"] = {"seed": seed, **config.get("localiser", {})}
    try:
        return cairn.Navigator(profile, known, start=start, config=config or None)
    except errors.SettingsInvalid as error:
        raise errors.ScenarioInvalid(
            f"scenario `{scenario.name}`: `navigator`: {error}",
            path=str(scenario.folder or ""),
            line=None,
            key="navigator",
            reason=str(error),
        ) from error


def body_of(box: Box) -> robots.Box:
    """The thing that stands in a simulation for a box of a scenario."""
    from cairn import robots

    return robots.Box(
        x=box.x_m,
        y=box.y_m,
        length_m=box.length_m,
        width_m=box.width_m,
        heading=box.yaw_rad,
        name=box.name,
        height_m=box.height_m,
        from_s=box.from_s,
        until_s=math.inf if box.until_s is None else box.until_s,
        appears_within_m=box.appears_within_m,
        appears_near=box.appears_near_m,
    )


def _pose_source(scenario: Scenario, known: World | None, profile: cairn.Profile) -> str:
    """What the scenario says, or localised wherever a map shows something to recognise."""
    shows = known is not None and bool((known.occupancy == 1).any())
    sees = profile.range_count > 0
    if scenario.pose == "localised" and not (shows and sees):
        why = "the robot has no sonar or lidar" if shows else "there is no map with walls on it"
        raise errors.PoseSourceUnavailable(
            f'pose = "localised": {why} to recognise a place by', pose=scenario.pose
        )
    return scenario.pose or ("localised" if shows and sees else "odometry")


def point_of(where: Start | Goal | NewGoal, world: World) -> tuple[float, float]:
    """Return the point [m, world frame] a scenario means by coordinates or a place of its world.

    Raises:
        ScenarioPlaceUnknown: the world has no place of that name.
    """
    if where.x_m is not None and where.y_m is not None:
        return (where.x_m, where.y_m)
    assert where.place is not None  # a checked scenario gives one or the other
    place = _place(where.place, world)
    return (float(place[0]), float(place[1]))


def start_pose(start: Start, world: World) -> Pose:
    """Return the pose a scenario means; the heading of a place counts where none is given."""
    x, y = point_of(start, world)
    heading = start.heading_rad
    if heading is None and start.place is not None:
        place = _place(start.place, world)
        heading = float(place[2]) if len(place) > 2 else 0.0
    return (x, y, heading or 0.0)


def _place(name: str, world: World) -> tuple[float, ...]:
    if name not in world.goals:
        known = sorted(world.goals)
        raise errors.ScenarioPlaceUnknown(
            f"the world `{world.name}` has no place `{name}`; it has {', '.join(known) or 'none'}",
            place=name,
            known=known,
        )
    return world.goals[name]


def load_map(name: str, folder: Path | None) -> World:
    """Load a map beside the scenario file, or a shipped one by name."""
    from cairn import maps

    return maps.load(name if name in maps.shipped() else _beside(name, folder))


def _beside(name: str, folder: Path | None) -> str:
    path = (folder or Path.cwd()) / name
    return str(path) if path.is_file() else name


def way_left_m(path: np.ndarray | None, at: Pose, goal: tuple[float, float]) -> float:
    """Return the way left [m]: to the nearest point of the plan, along it and on to the goal.

    Args:
        path: (n, 2) points [m]; with none, or one, the way is straight.
        at: where the robot is.
        goal: what it drives to; a path over what is seen so far may end before it.
    """
    if path is None or len(path) < 2:
        return math.dist(at[:2], goal)
    path = np.asarray(path, dtype=float)
    here = np.array(at[:2])
    along = np.diff(path, axis=0)
    squares = np.maximum((along**2).sum(axis=1), 1e-18)
    shares = np.clip(((here - path[:-1]) * along).sum(axis=1) / squares, 0.0, 1.0)
    feet = path[:-1] + shares[:, None] * along
    away = np.hypot(*(here - feet).T)
    nearest = int(away.argmin())
    left = np.vstack([feet[nearest], path[nearest + 1 :], goal])
    return float(away[nearest]) + length_m(left)


def length_m(path: np.ndarray) -> float:
    """Return the length [m] of a polyline (n, 2)."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
