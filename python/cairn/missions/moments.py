"""A run as plain data: what the console is shown of it (`cairn.view.console.snapshot`)."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from cairn.errors import WorldShapeInvalid
from cairn.missions.runner import Follower, Loop
from cairn.missions.setting import way_left_m
from cairn.view.console.snapshot import (
    Body,
    BoxState,
    Grid,
    Lidar,
    Note,
    RobotState,
    Snapshot,
    Sonar,
)
from cairn.world import World

HISTORY_TICKS = 600  # of the plots: a minute
TRAIL_TICKS = 3000  # of the way driven: five minutes
TOLD = 12
# Maps and fields are large: they are copied at most this often [s].
MAP_EVERY_S, FIELD_EVERY_S = 0.4, 1.0

# The record of a robot whose time has not begun.
_NOT_YET: dict[str, Any] = {
    "mode": "stop",
    "sentence": "Stop: its time has not begun.",
    "twist": {"linear_mps": 0.0, "angular_radps": 0.0},
    "tracking": None,
    "avoidance": None,
    "waypoint_index": 0,
}


class Moments:
    """Takes snapshots of a run, between its ticks and in its own thread."""

    def __init__(self) -> None:
        """With nothing taken yet."""
        self._number = 0
        self._layers = 0
        self.begin(0)

    def begin(self, run: int) -> None:
        """Another run begins."""
        self._run = run
        self._world: Grid | None = None
        self._bodies: dict[str, Body] = {}
        self._grids: dict[str, Grid] = {}
        self._fields: dict[str, Grid] = {}
        self._looked: dict[str, float] = {}

    def take(
        self,
        loop: Loop,
        seed: int,
        *,
        shown: int,
        paused: bool,
        speed: float,
        pace: float,
        notes: tuple[Note, ...],
        over: str | None,
    ) -> Snapshot:
        """Copy what is to be seen after a tick; `shown` is the robot whose map is wanted."""
        self._number += 1
        follower = loop.followers[shown]
        stage = follower.agent.robot.stage
        if self._world is None:
            self._world = self._grid_of(loop.setting.world)
        return Snapshot(
            number=self._number,
            run=self._run,
            scenario=loop.scenario.name,
            seed=seed,
            time_s=loop.time_s,
            paused=paused,
            speed=speed,
            pace=pace,
            robots=tuple(self._robot(each) for each in loop.followers),
            world=self._world,
            grid=self._map(follower),
            costs=self._costs(follower),
            boxes=tuple(
                BoxState(
                    box.name, box.x, box.y, box.length_m, box.width_m, box.heading, box.height_m,
                    bool(stage.standing[i]),
                )
                for i, box in enumerate(stage.boxes)
                if stage.standing[i] or (i >= len(stage.scene.boxes) and not stage.gone[i])
            ),
            places={name: tuple(at) for name, at in loop.setting.world.goals.items()},
            spares_left=stage.spares_left,
            notes=notes,
            over=over,
        )  # fmt: skip

    def _robot(self, follower: Follower) -> RobotState:
        agent, trace = follower.agent, follower.trace
        goal = follower.heading_for
        path = agent.navigator.path
        # Paused, the robot itself is a tick ahead of all that it has sensed and decided.
        truth = follower.last or _pose(agent.robot.truth)
        recent = slice(-HISTORY_TICKS, None)
        return RobotState(
            name=agent.name,
            body=self._body(agent),
            truth=truth,
            estimate=_pose(agent.navigator.pose),
            ranges_m=self._ranges(follower),
            decision=follower.decision.to_dict() if follower.decision else _NOT_YET,
            goal=goal,
            to_go_m=None if goal is None else way_left_m(path, truth, goal),
            clearance_m=trace.clearance_m[-1] if trace.clearance_m else agent.robot.clearance_m,
            path=np.empty((0, 2)) if path is None else np.array(path, float),
            waypoints=np.array(agent.navigator.waypoints, float).reshape(-1, 2),
            trail=np.array(trace.truth[-TRAIL_TICKS:], float).reshape(-1, 3)[:, :2],
            trail_modes=tuple(trace.mode[-TRAIL_TICKS:]),
            history=np.column_stack(
                [trace.time_s[recent], np.reshape(trace.twist[recent], (-1, 2))]
            ),
            told=tuple(change.to_dict() for change in follower.transitions[-TOLD:]),
            goals=tuple(ended.to_dict() for ended in follower.goals),
            driven_m=follower.driven_m,
            contacts=len(agent.robot.contacts) + len(follower.meetings),
            plan_count=agent.navigator.plan_count,
        )

    def _ranges(self, follower: Follower) -> np.ndarray:
        if follower.readings is None:
            return np.full(follower.agent.robot.profile.range_count, np.nan)
        return np.array(follower.readings.ranges_m, float)

    def _body(self, agent: Any) -> Body:
        if agent.name not in self._bodies:
            profile, physics = agent.robot.profile, agent.robot.profile.physics
            height_m = 0.25
            if physics is not None:
                height_m = physics.ground_clearance_m + physics.body_height_m
            lidar = profile.lidar
            self._bodies[agent.name] = Body(
                length_m=profile.footprint.length_m,
                width_m=profile.footprint.width_m,
                height_m=height_m,
                sonars=tuple(
                    Sonar(_pose(sonar.pose), sonar.beam_rad, sonar.max_range_m)
                    for sonar in profile.sonars
                ),
                lidar=lidar and Lidar(_pose(lidar.pose), lidar.first_rad, lidar.step_rad),
                linear_mps=profile.limits.linear_mps,
                angular_radps=profile.limits.angular_radps,
            )
        return self._bodies[agent.name]

    def _map(self, follower: Follower) -> Grid:
        name = follower.agent.name
        known = self._grids.get(name)
        if known is not None and not self._is_time(f"map {name}", MAP_EVERY_S):
            return known
        world = _map_of(follower.agent)
        same = (
            known is not None
            and known.origin == tuple(world.origin)
            and np.array_equal(known.values, world.occupancy)
        )
        if known is None or not same:
            known = self._grids[name] = self._grid_of(world)
        return known

    def _costs(self, follower: Follower) -> Grid | None:
        name = follower.agent.name
        field = follower.agent.navigator.field
        if field is None or follower.under is None or follower.under.goal is None:
            self._fields.pop(name, None)
            return None
        known = self._fields.get(name)
        if known is None or self._is_time(f"field {name}", FIELD_EVERY_S):
            costs = field.cost_to_go().astype(np.float32)
            if known is None or not np.array_equal(known.values, costs):
                x, y, yaw = field.origin
                grid = Grid(costs, field.resolution_m, (x, y, yaw), self._next())
                known = self._fields[name] = grid
        return known

    def _grid_of(self, world: World) -> Grid:
        x, y, yaw = world.origin
        return Grid(np.array(world.occupancy), world.resolution_m, (x, y, yaw), self._next())

    def _next(self) -> int:
        self._layers += 1
        return self._layers

    def _is_time(self, what: str, every_s: float) -> bool:
        now = time.monotonic()
        if now - self._looked.get(what, -1e9) < every_s:
            return False
        self._looked[what] = now
        return True


def _map_of(agent: Any) -> World:
    """The map as a navigator has it; what it was given, as long as that has no cell."""
    try:
        return agent.navigator.map()
    except WorldShapeInvalid:
        if agent.navigator.world is not None:
            return agent.navigator.world
        x, y, _ = agent.robot.truth
        return World(np.full((1, 1), 2, np.uint8), resolution_m=0.05, origin=(x, y, 0.0))


def _pose(pose: Any) -> tuple[float, float, float]:
    return (pose.x, pose.y, pose.heading)
