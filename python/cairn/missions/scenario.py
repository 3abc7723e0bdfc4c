"""What a mission is: the model of a scenario file.

A scenario says where the robot is, what it knows, what really stands there, and where to go.
Units are in the key names; unknown keys and non-finite numbers are errors.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    field_validator,
    model_validator,
)

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Mode = Literal["stop", "path_planning", "path_tracking", "obstacle_avoidance"]
Seed = Annotated[int, Field(ge=0, lt=2**32)]


class _Model(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        allow_inf_nan=False,
        frozen=True,
        strict=False,
        use_attribute_docstrings=True,
    )


class _Where(_Model):
    """A point [m, world frame], or the name of a place of the world."""

    x_m: float | None = None
    """World frame [m]; with `y_m`, instead of `place`."""
    y_m: float | None = None
    """World frame [m]."""
    place: str | None = None
    """A named place of the map."""

    def _names_one_place(self) -> bool:
        return self.place is not None or self.x_m is not None or self.y_m is not None

    def _check_where(self) -> None:
        if self.place is not None and (self.x_m is not None or self.y_m is not None):
            raise ValueError("give either `place` or `x_m` and `y_m`, not both")
        if self.place is None and (self.x_m is None or self.y_m is None):
            raise ValueError("needs `place`, or both `x_m` and `y_m`")


class Start(_Where):
    """Where a robot stands at the beginning; the heading is counter-clockwise from +x."""

    heading_rad: float | None = None
    """Counter-clockwise from +x [rad]; if not given that of the place, or 0."""
    known: bool = True
    """To the navigator; otherwise it has to find out where it stands (`pose = "localised"`)."""

    @model_validator(mode="after")
    def _is_one_place(self) -> Start:
        self._check_where()
        return self


class Goal(_Where):
    """Something to do: drive to a point or place, or explore without a goal for some time."""

    explore_s: Positive | None = None
    """Explore without a goal for so long [s], instead of a point or place."""
    wait_s: NotNegative = 0.0
    """Standing still before it begins [s]."""
    expect: Literal["reached", "refused"] = "reached"
    """How it ought to end: `refused` where that is the point."""

    @model_validator(mode="after")
    def _is_one_task(self) -> Goal:
        if self.explore_s is None:
            self._check_where()
        elif self._names_one_place():
            raise ValueError("`explore_s` explores without a goal: give no place or point with it")
        return self


class Box(_Model):
    """A box [m, rad, world frame] that really stands there and that no map shows.

    It stands there from `from_s` to `until_s`; with `appears_within_m` only once a robot is that
    near to `appears_near_m`, by default the box itself: things put down on the way.
    """

    x_m: float
    """Of its centre, world frame [m]."""
    y_m: float
    """Of its centre, world frame [m]."""
    length_m: Positive
    """Along its own x axis [m]."""
    width_m: Positive
    """Along its own y axis [m]."""
    height_m: Positive = 0.6
    """Over the floor [m]."""
    yaw_rad: float = 0.0
    """Of its own x axis, counter-clockwise from the world's [rad]."""
    name: str = "box"
    """In pictures and records."""
    from_s: NotNegative = 0.0
    """When it is put there [s]."""
    until_s: Positive | None = None
    """When it is taken away [s]; if not given, never."""
    appears_within_m: Positive | None = None
    """It is put there only once a robot is this near [m]."""
    appears_near_m: tuple[float, float] | None = None
    """Near to this point, world frame [m]; if not given, to the box itself."""

    @model_validator(mode="after")
    def _stands_for_a_time(self) -> Box:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise ValueError("`until_s` must be later than `from_s`")
        return self


class _Event(_Model):
    """Something that happens once, as soon as all that it names holds for its robot.

    `at_s`: so much time is over; `at_distance_m`: it has driven that far; `when_mode`: its
    navigator is in that mode, and has been for `mode_for_s`.
    """

    at_s: NotNegative | None = None
    """Once so much time is over [s]."""
    at_distance_m: NotNegative | None = None
    """Once its robot has driven that far [m]."""
    when_mode: Mode | None = None
    """Once its robot's navigator is in this mode."""
    mode_for_s: NotNegative = 0.0
    """And has been for so long [s]."""
    robot: Annotated[int, Field(ge=0)] = 0
    """Number of its robot, from 0."""

    @model_validator(mode="after")
    def _happens_once(self) -> _Event:
        if self.at_s is None and self.at_distance_m is None and self.when_mode is None:
            raise ValueError("needs `at_s`, `at_distance_m` or `when_mode`")
        if self.mode_for_s and self.when_mode is None:
            raise ValueError("`mode_for_s` needs `when_mode`")
        return self


class Shove(_Event):
    """The robot is pushed: `dx_m` forward, `dy_m` to its left, turned by `dheading_rad`."""

    do: Literal["shove"]
    """The wheels do not notice."""
    dx_m: float = 0.0
    """Forward [m]."""
    dy_m: float = 0.0
    """To its left [m]."""
    dheading_rad: float = 0.0
    """Counter-clockwise [rad]."""


class NewGoal(_Event, _Where):
    """The goal under way is replaced by another one while the robot drives."""

    do: Literal["new_goal"]
    """The goal is a point or a place."""

    @model_validator(mode="after")
    def _is_one_place(self) -> NewGoal:
        self._check_where()
        return self


class Cancel(_Event):
    """The goal under way is called off; the robot stops and takes the next one."""

    do: Literal["cancel"]
    """No other keys than those of every event."""


class EmergencyStop(_Event):
    """Somebody presses the robot's emergency stop for a while: its motors ignore the navigator."""

    do: Literal["emergency_stop"]
    """The motors brake hard."""
    for_s: Positive
    """How long it stays pressed [s]."""


class Hold(_Event):
    """Something that no sensor shows holds the robot, a doorstep, say: its wheels spin.

    It cannot drive on across the line through it, at a right angle to its heading and
    `half_width_m` to either side.
    """

    do: Literal["hold"]
    """Driving back is possible."""
    half_width_m: Positive = 0.4
    """Of the line that holds it [m]."""


Event = Annotated[Shove | NewGoal | Cancel | EmergencyStop | Hold, Field(discriminator="do")]


class RobotEntry(_Model):
    """One of several robots, which share the goals and the field.

    `goals` are its own, taken after the shared ones: to clear the way, say.
    """

    name: str
    """In tables, pictures and records; no two the same."""
    start: Start
    """As `[start]` of a single robot."""
    goals: tuple[Goal, ...] = ()
    """Its own goals."""


class WorldEntry(_Model):
    """What really stands there, where that differs from the map the robot is given."""

    map: str
    """A map file beside the scenario, or the name of a shipped map."""


class Expect(_Model):
    """What else must come out of the run; tests read it, and so does the exit code.

    Goals say themselves what is expected of them, and a contact is never expected.
    """

    plan_count: Annotated[int, Field(ge=0)] | None = None
    """How often it plans, all robots together."""
    plan_count_at_least: Annotated[int, Field(ge=0)] | None = None
    """The same, at least."""
    transitions_at_least: Annotated[int, Field(ge=0)] | None = None
    """How often the mode changes, at least."""
    modes: tuple[Mode, ...] = ()
    """Modes that must be entered."""
    transitions: tuple[str, ...] = ()
    """Events that must change the mode, `local_minimum`, say."""
    recoveries: tuple[str, ...] = ()
    """Causes that it must recover from, `way_shut`, say."""
    path_length_at_least_m: NotNegative | None = None
    """How far it must have driven [m]."""

    @field_validator("transitions")
    @classmethod
    def _are_events(cls, given: tuple[str, ...]) -> tuple[str, ...]:
        from cairn.missions.coverage import changes_of_mode

        known = {change.event for change in changes_of_mode()}
        for event in given:
            if event not in known:
                raise ValueError(f"no event `{event}`; there is {', '.join(sorted(known))}")
        return given


class Scenario(_Model):
    """A mission, checked. Read one with `Scenario.load`, or build it from a dict."""

    name: Annotated[str, Field(min_length=1, pattern=r"^[\w.-]+$")]
    """What it is called; `runs/<name>` is where a run is kept."""
    description: str = ""
    """One line for lists."""
    map: str
    """What the robot is given: a map file beside this one, a shipped map's name, or `"none"`."""
    world: WorldEntry | None = None
    """What really stands there; if not given, what the map shows."""
    profile: str = "p3at"
    """Robot profile, shipped or a file."""
    robot: Literal["mujoco", "kinematic"] = "mujoco"
    """What is driven: `"mujoco"` has physics, `"kinematic"` is faster."""
    start: Start | None = None
    """Where the only robot stands."""
    robots: tuple[RobotEntry, ...] = ()
    """Several robots, instead of `[start]`."""
    goals: Annotated[tuple[Goal, ...], Field(min_length=1)]
    """One after another."""
    boxes: tuple[Box, ...] = ()
    """Things that no map shows."""
    events: tuple[Event, ...] = ()
    """What happens on the way."""
    pose: Literal["odometry", "localised", "truth"] | None = None
    """What the navigator knows of its pose: `"localised"` (kept on the map, found when lost),
    `"odometry"` or `"truth"`.

    If not given, `"localised"` where the map shows something, else `"odometry"`."""
    noise: NotNegative = 1.0
    """Factor on all sensor noise of the profile; 0: none."""
    seed: Seed = 1
    """Of everything random."""
    timeout_s: Positive = 600.0
    """Simulated time after which the run ends [s]."""
    arrival_tolerance_m: Positive = 0.3
    """How near to a goal counts as reached, by truth [m]."""
    navigator: dict[str, Any] = {}
    """Settings that differ from `cairn.Navigator.default_config()`, nested like it."""
    expect: Expect = Expect()
    """What else must come out of the run."""

    _folder: Path | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _is_whole(self) -> Scenario:
        if (self.start is None) == (not self.robots):
            raise ValueError("needs either one `start` or several `[[robots]]`")
        if self.map == "none" and self.world is None:
            raise ValueError('with map = "none", `[world]` must name the map of what stands there')
        count = len(self.starts)
        for event in self.events:
            if event.robot >= count:
                raise ValueError(f"an event is for robot {event.robot}, but there are {count}")
        if self.pose in ("odometry", "truth") and not all(e.start.known for e in self.starts):
            raise ValueError('`known = false` is for `pose = "localised"`')
        names = [entry.name for entry in self.robots]
        if len(set(names)) < len(names):
            raise ValueError("two robots have the same name")
        return self

    @property
    def starts(self) -> tuple[RobotEntry, ...]:
        """Every robot with its start, also where there is only one."""
        if self.start is not None:
            return (RobotEntry(name="robot", start=self.start),)
        return self.robots

    @property
    def folder(self) -> Path | None:
        """The folder of the file it was read from; paths in the scenario are relative to it."""
        return self._folder

    @classmethod
    def load(cls, name_or_path: str | Path) -> Scenario:
        """Read a shipped scenario by name, or any by path.

        Raises:
            ScenarioNotFound: no such file, and no shipped scenario of that name.
            ScenarioInvalid: the file is not TOML, or not a scenario; with line, key and reason.
        """
        from cairn.missions.reading import load

        return load(name_or_path)

    def config_hash(self) -> str:
        """Hash of all that shapes the run but the seed: equal hashes ask for the same mission."""
        text = json.dumps(self.model_dump(mode="json", exclude={"seed"}), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]
