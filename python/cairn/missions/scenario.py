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
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=False)


class _Where(_Model):
    """A point [m, world frame], or the name of a place of the world."""

    x_m: float | None = None
    y_m: float | None = None
    place: str | None = None

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
    known: bool = True  # to the navigator; otherwise it has to find out where it stands

    @model_validator(mode="after")
    def _is_one_place(self) -> Start:
        self._check_where()
        return self


class Goal(_Where):
    """Something to do: drive to a point or place, or explore without a goal for some time."""

    explore_s: Positive | None = None
    wait_s: NotNegative = 0.0  # standing still before it begins
    expect: Literal["reached", "refused"] = "reached"

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
    y_m: float
    length_m: Positive
    width_m: Positive
    height_m: Positive = 0.6
    yaw_rad: float = 0.0
    name: str = "box"
    from_s: NotNegative = 0.0
    until_s: Positive | None = None
    appears_within_m: Positive | None = None
    appears_near_m: tuple[float, float] | None = None

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
    at_distance_m: NotNegative | None = None
    when_mode: Mode | None = None
    mode_for_s: NotNegative = 0.0
    robot: Annotated[int, Field(ge=0)] = 0

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
    dx_m: float = 0.0
    dy_m: float = 0.0
    dheading_rad: float = 0.0


class NewGoal(_Event, _Where):
    """The goal under way is replaced by another one while the robot drives."""

    do: Literal["new_goal"]

    @model_validator(mode="after")
    def _is_one_place(self) -> NewGoal:
        self._check_where()
        return self


class Cancel(_Event):
    """The goal under way is called off; the robot stops and takes the next one."""

    do: Literal["cancel"]


class EmergencyStop(_Event):
    """Somebody presses the robot's emergency stop for a while: its motors ignore the navigator."""

    do: Literal["emergency_stop"]
    for_s: Positive


class Hold(_Event):
    """Something that no sensor shows holds the robot, a doorstep, say: its wheels spin.

    It cannot drive on across the line through it, at a right angle to its heading and
    `half_width_m` to either side.
    """

    do: Literal["hold"]
    half_width_m: Positive = 0.4


Event = Annotated[Shove | NewGoal | Cancel | EmergencyStop | Hold, Field(discriminator="do")]


class RobotEntry(_Model):
    """One of several robots, which share the goals and the field.

    `goals` are its own, taken after the shared ones: to clear the way, say.
    """

    name: str
    start: Start
    goals: tuple[Goal, ...] = ()


class WorldEntry(_Model):
    """What really stands there, where that differs from the map the robot is given."""

    map: str


class Expect(_Model):
    """What else must come out of the run; tests read it, and so does the exit code.

    Goals say themselves what is expected of them, and a contact is never expected.
    """

    plan_count: Annotated[int, Field(ge=0)] | None = None
    plan_count_at_least: Annotated[int, Field(ge=0)] | None = None
    transitions_at_least: Annotated[int, Field(ge=0)] | None = None
    modes: tuple[Mode, ...] = ()
    transitions: tuple[str, ...] = ()  # events that must change the mode, `local_minimum`, say
    recoveries: tuple[str, ...] = ()  # causes that it must recover from, `way_shut`, say
    path_length_at_least_m: NotNegative | None = None

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
    description: str = ""
    map: str
    world: WorldEntry | None = None
    profile: str = "p3at"
    robot: Literal["mujoco", "kinematic"] = "mujoco"
    start: Start | None = None
    robots: tuple[RobotEntry, ...] = ()
    goals: Annotated[tuple[Goal, ...], Field(min_length=1)]
    boxes: tuple[Box, ...] = ()
    events: tuple[Event, ...] = ()
    pose: Literal["odometry", "localised", "truth"] | None = None  # localised where a map is
    noise: NotNegative = 1.0
    seed: Seed = 1
    timeout_s: Positive = 600.0
    arrival_tolerance_m: Positive = 0.3
    navigator: dict[str, Any] = {}
    expect: Expect = Expect()

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
