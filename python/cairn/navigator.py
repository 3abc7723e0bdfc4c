"""The navigator in Python: one call per tick, one record out that says everything."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain, errors
from cairn.profile import Profile
from cairn.robots.robot import Pose, Twist
from cairn.strict_json import plain
from cairn.tracking import controller_text
from cairn.world import World


class Decision:
    """What one tick saw, decided and commands, and why. Everything is in `to_dict`."""

    def __init__(self, brain: _brain.Decision) -> None:
        self._brain = brain

    @property
    def twist(self) -> Twist:
        """The command (V [m/s], ω [rad/s])."""
        return Twist(*self._brain.twist)

    @property
    def pose(self) -> Pose:
        """Estimated pose of the robot in the world frame [m, m, rad]."""
        return Pose(*self._brain.pose)

    @property
    def time_s(self) -> float:
        """Time since the navigator began, this tick's step included."""
        return self._brain.time_s

    @property
    def mode(self) -> str:
        """`stop`, `path_planning`, `path_tracking` or `obstacle_avoidance`."""
        return self._brain.mode

    @property
    def event(self) -> str:
        """What was perceived, reduced to the one thing that mattered most."""
        return self._brain.event

    @property
    def reason(self) -> str:
        """Why the mode is what it is: a code that stays stable."""
        return self._brain.reason

    @property
    def sentence(self) -> str:
        """Mode and reason in words, with the values."""
        return self._brain.sentence

    @property
    def recovery(self) -> dict[str, Any] | None:
        """What went wrong in this tick and what is done about it; None as long as all is well.

        `{"cause": {"code": "way_shut", "ahead_m": ..., "detour": ...}, "remedy": "walk_anew"}`: the
        remedy follows from the cause.
        """
        return self._brain.recovery

    @property
    def goal_status(self) -> str:
        """`idle`, `driving`, `reached`, `refused` or `cancelled`."""
        return self._brain.goal_status

    def to_dict(self) -> dict[str, Any]:
        """Return the whole record as plain dicts and lists; numbers may be inf."""
        return self._brain.to_dict()

    def to_json(self) -> str:
        """Return the whole record as one line of strict JSON; what is not finite becomes null."""
        return json.dumps(plain(self.to_dict()), separators=(",", ":"), allow_nan=False)

    def __repr__(self) -> str:
        v, w = self.twist
        return f"<Decision {self.time_s:.1f} s: {self.sentence} ({v:.2f} m/s, {w:.2f} rad/s)>"


class Navigator:
    """Plans, tracks, avoids and arrives [Maalouf06 §6].

    Args:
        profile: the robot, or the name or file of its profile.
        world: the map to plan on, with its `costs` if it has any: cells of infinite cost are
            forbidden to the robot's centre. None: the robot maps as it goes.
        start: (x, y, heading) of the robot in the world frame [m, m, rad]. Without it a given map
            is used only once `step` is told a pose.
        controller: name, file or TOML text of the fuzzy controller.
        config: settings that differ from `default_config`, nested like it.

    Raises:
        SettingsInvalid: an unknown setting, or one of the wrong type.
        NavigatorSettingInvalid, and the errors of the parts: a setting is not usable.
    """

    def __init__(
        self,
        profile: Profile | str | Path = "p3at",
        world: World | None = None,
        *,
        start: ArrayLike | None = None,
        controller: str | Path = "p3at",
        config: Mapping[str, Any] | None = None,
    ) -> None:
        self.profile = profile if isinstance(profile, Profile) else Profile.load(profile)
        self.world = world
        self._controller = controller_text(controller)
        self._config = None if config is None else dict(config)
        self._start = None if start is None else _triple(start, "start")
        grid = ground = None
        if world is not None:
            if world.costs is not None:
                ground = np.asarray(world.costs, np.float32)
            grid = (world.occupancy, world.resolution_m, world.origin)
        self._brain = _brain.Navigator(
            self.profile,
            self._controller,
            self._config,
            grid,
            self._start,
            ground,
        )

    @property
    def recipe(self) -> dict[str, Any]:
        """What this navigator was made of, its map apart: texts of profile and controller, the
        settings that differ, the start. Plain values, for a log."""
        return {
            "profile": self.profile.text,
            "controller": self._controller,
            "config": self._config,
            "start": None if self._start is None else list(self._start),
        }

    @classmethod
    def from_recipe(cls, recipe: Mapping[str, Any], world: World | None) -> Navigator:
        """Make a navigator anew from `recipe`; see there."""
        return cls(
            Profile(recipe["profile"]),
            world,
            start=recipe["start"],
            controller=recipe["controller"],
            config=recipe["config"],
        )

    @staticmethod
    def default_config() -> dict[str, Any]:
        """Return every setting with its default value."""
        return _brain.Navigator.default_config()

    def set_goal(self, goal: ArrayLike, field: _brain.SharedField | None = None) -> None:
        """Drive to (x, y) in the world frame [m]; a moving robot first comes to rest.

        Args:
            goal: (x, y) [m].
            field: the `field` of another navigator for the same goal: no plan is made then until
                something it does not know stands in the way.

        Raises:
            GoalMalformed: not (x, y) or (x, y, heading).
            GoalNotFinite: a coordinate is NaN or infinite.
        """
        self._brain.set_goal(*_point(goal), field)

    def explore(self) -> None:
        """See what is unknown, until there is nothing left or another command comes."""
        self._brain.explore()

    def cancel(self) -> None:
        """End the task; the robot brakes to rest."""
        self._brain.cancel()

    def step(
        self,
        ranges: ArrayLike,
        wheels: ArrayLike,
        gyro: float | None,
        dt_s: float,
        world_from_robot: ArrayLike | None = None,
    ) -> Decision:
        """One tick: what was measured in, everything decided out.

        Args:
            ranges: (n,) one per sonar, then per lidar beam [m]; inf no echo, nan not measured.
            wheels: (left, right) travel of each side since the last tick, by encoders [m].
            gyro: mean turn rate since the last tick [rad/s]; None without a gyroscope.
            dt_s: time since the last tick.
            world_from_robot: (x, y, heading) of the robot in the world frame, where something else
                knows it; otherwise it is estimated from wheels, gyro and the given map.

        Raises:
            RangeCountWrong, RangeNegative, TimeStepInvalid, MeasurementNotFinite: the input cannot
                be a measurement; nothing has changed then.
            MappingTooLarge: the map would grow beyond `mapping.most_cells`. It is as before, but
                time has passed and the robot has moved: the tick counts, and gives no command.
        """
        travel = np.asarray(wheels, float)
        if travel.shape != (2,):
            raise errors.MeasurementNotFinite(
                f"wheels are {wheels!r}: they must be (left, right), two finite numbers",
                what="wheels",
                value=wheels,
            )
        readings = np.ascontiguousarray(ranges, np.float64)
        if readings.ndim != 1:
            raise errors.RangeCountWrong(
                f"ranges have shape {readings.shape}: they must be ({self.profile.range_count},)",
                given=readings.size,
                expected=self.profile.range_count,
            )
        left, right = (float(way) for way in travel)
        return Decision(
            self._brain.step(
                readings,
                (left, right),
                None if gyro is None else float(gyro),
                float(dt_s),
                None if world_from_robot is None else _triple(world_from_robot, "world_from_robot"),
            )
        )

    @property
    def pose(self) -> Pose:
        """Estimated pose in the world frame [m, m, rad]."""
        return Pose(*self._brain.pose)

    @property
    def mode(self) -> str:
        """Mode after the last tick."""
        return self._brain.mode

    @property
    def path(self) -> NDArray[np.float64] | None:
        """(n, 2) the path last walked to this goal, world frame [m]; None before the first."""
        path = self._brain.path
        return path if len(path) else None

    @property
    def waypoints(self) -> NDArray[np.float64]:
        """(n, 2) what the tracker follows, world frame [m]."""
        return self._brain.waypoints

    @property
    def lidar_points(self) -> NDArray[np.float64]:
        """(n, 2) what the lidar has seen and not seen through again, world frame [m].

        Empty for a robot without a lidar, and where a map is given.
        """
        return self._brain.lidar_points

    @property
    def plan_count(self) -> int:
        """Number of fields this navigator has solved itself."""
        return self._brain.plan_count

    @property
    def field(self) -> _brain.SharedField | None:
        """The cost-to-go field in use, to share with others that want the same goal."""
        return self._brain.field

    def map(self) -> World:
        """Return the map as it is now."""
        occupancy, resolution_m, origin = self._brain.map()
        return World(occupancy, resolution_m=resolution_m, origin=origin, name="map as seen")


def transitions() -> list[tuple[str, str, str, str]]:
    """Every transition of the four modes: (mode, event, next mode, reason) [Maalouf06 Fig. 11]."""
    return _brain.transitions()


def _point(goal: ArrayLike) -> tuple[float, float]:
    try:
        numbers = np.asarray(goal, float)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape not in ((2,), (3,)):
        raise errors.GoalMalformed(f"goal {goal!r}: a goal is one (x, y) in metres", value=goal)
    return float(numbers[0]), float(numbers[1])


def _triple(pose: ArrayLike, what: str) -> tuple[float, float, float]:
    numbers = np.asarray(pose, float).ravel()
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise errors.MeasurementNotFinite(
            f"{what} is {pose!r}: it must be (x, y, heading), three finite numbers",
            what=what,
            value=pose,
        )
    x, y, heading = (float(v) for v in numbers)
    return x, y, heading
