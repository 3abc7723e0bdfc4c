"""The fuzzy path tracker and the fuzzy systems it is made of [Maalouf06 §4]."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import _brain, errors, shipped
from cairn.robots.robot import Twist

Point = tuple[float, float]


def controller_text(controller: str | Path) -> str:
    """Text of a controller: one shipped under a name, a file, or the text itself.

    Raises:
        ControllerNotFound: none of the three.
        ControllerUnreadable: the file is not text.
    """
    if isinstance(controller, str) and "\n" in controller:
        return controller
    path = shipped.find("controllers", controller)
    if path is None:
        known = shipped.names("controllers")
        raise errors.ControllerNotFound(
            f"controller `{controller}` is neither a file nor one of {', '.join(known)}",
            controller=str(controller),
            known=known,
        )
    return shipped.read(path, errors.ControllerUnreadable)


class FuzzySystem:
    """A zero-order Sugeno system, from TOML text.

    ```python
    system = cairn.FuzzySystem('''
    [inputs.distance]
    range = [0.0, 2.0]
    sets.Near = { left_shoulder = [0.2, 1.0] }
    sets.Far = { right_shoulder = [0.2, 1.0] }
    [outputs.speed]
    Slow = 0.1
    Fast = 0.7
    [[rules]]
    when = { distance = "Near" }
    then = { speed = "Slow" }
    [[rules]]
    when = { distance = "Far" }
    then = { speed = "Fast" }
    ''')
    system.evaluate(distance=0.6)["speed"]  # 0.4
    ```
    """

    def __init__(self, text: str) -> None:
        """Read and check a system.

        Raises:
            ControllerUnreadable: not TOML, or keys that do not belong.
            FuzzyNameUnknown, FuzzySetNotRising, FuzzyRangeNotRising, FuzzyNumberInvalid,
            FuzzySystemEmpty, FuzzyRuleRepeated, FuzzyRulesLeaveGap, FuzzySystemTooLarge: what is
                wrong with it, by name.
        """
        self._brain = _brain.FuzzySystem(text)

    @classmethod
    def _of(cls, brain: _brain.FuzzySystem) -> FuzzySystem:
        system = cls.__new__(cls)
        system._brain = brain
        return system

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
        return self._brain.input_names

    @property
    def outputs(self) -> list[str]:
        """Names of the outputs."""
        return self._brain.output_names

    def evaluate(self, **inputs: ArrayLike) -> dict[str, Any]:
        """Outputs by name: floats, or arrays of the inputs' common (broadcast) shape.

        Inputs beyond their range count as its nearer end.

        Raises:
            FuzzyInputsMismatch: not exactly the inputs of the system.
            FuzzyInputNotFinite: an input is NaN or infinite.
        """
        columns = np.broadcast_arrays(*(np.asarray(v, float) for v in self._in_order(inputs)))
        values = np.stack([column.ravel() for column in columns], axis=1)
        found = self._brain.outputs(values)
        shape = columns[0].shape
        if not shape:
            return {name: float(found[0, i]) for i, name in enumerate(self.outputs)}
        return {name: found[:, i].reshape(shape) for i, name in enumerate(self.outputs)}

    def explain(self, **inputs: float) -> dict[str, Any]:
        """As `evaluate` for one place, with what led there.

        Returns:
            `outputs` by name, `memberships` by input and set, `rules` that fired with their
            strengths, each rule as a sentence.
        """
        return self._brain.evaluate([float(v) for v in self._in_order(inputs)])

    def _in_order(self, inputs: dict[str, Any]) -> list[Any]:
        if sorted(inputs) != sorted(self.inputs):
            known = ", ".join(self.inputs)
            raise errors.FuzzyInputsMismatch(
                f"inputs {', '.join(inputs) or 'none'} given, the system has {known}",
                given=len(inputs),
                known=known,
            )
        return [inputs[name] for name in self.inputs]


class TrackingRecord(dict[str, Any]):
    """One tick of tracking, plain data.

    Keys: `waypoint_index`, `target` {x, y} or None, `alpha1`, `alpha2`, `C`, `dR`, `dtheta`, `Vc`,
    `world_from_robot_ahead` (where the robot will be when the command takes hold; dR and dtheta are
    seen from there), `remaining_m`, `look_ahead` and `tracker` (outputs, memberships, rules of both
    modules), `raw` and `twist` {linear_mps, angular_radps}, `caps` (what held the command back),
    `arrived`.
    """

    @property
    def twist(self) -> Twist:
        """The command."""
        return Twist(**self["twist"])

    @property
    def arrived(self) -> bool:
        """At rest at the goal."""
        return self["arrived"]


class Rehearsal(NamedTuple):
    """A drive worked out in advance, tick by tick.

    Times (n,) [s]; poses (n, 3) [m, m, rad]; how the robot moves and what it is told, (n, 2)
    [m/s, rad/s] each.
    """

    times_s: NDArray[np.float64]
    poses: NDArray[np.float64]
    twists: NDArray[np.float64]
    commands: NDArray[np.float64]


def deviations(
    path: ArrayLike, positions: ArrayLike, *, reach_m: float = 1.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Signed distance of every position to a path, positive left, and the way along it [m].

    Progress along the path is kept to: the nearest point is sought from a little before the last
    one to `reach_m` beyond it, so that a path may cross itself.

    Args:
        path: (m, 2) world frame [m], the continuous reference.
        positions: (n, 2) of a drive, in order.
        reach_m: how far a drive may get ahead of what was measured last.

    Raises:
        PathEmpty, PathPointNotFinite, PathShapeWrong, TrackValueOutOfRange.
    """
    found = _brain.deviations(_points(path), _points(positions), reach_m)
    return found[:, 0], found[:, 1]


def _points(points: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(points, float)
    if array.size == 0:
        array = array.reshape(0, 2)
    if array.ndim != 2 or array.shape[1] != 2:
        raise errors.PathShapeWrong(
            f"a path has shape (n, 2), this one {array.shape}", shape=array.shape
        )
    return array


class Tracker:
    """Drives along waypoints: (V, ω) = f(C, dR, dθ, Vc) [Maalouf06 (6)].

    ```python
    tracker = cairn.Tracker("p3at", cairn.Profile.load("p3at"))
    tracker.follow([(0, 0), (4, 0), (4, 3)], spacing_m=0.3)
    record = tracker.step(pose=(0, 0, 0), twist=(0, 0), dt_s=0.1)
    record.twist
    ```
    """

    def __init__(
        self,
        controller: str | Path,
        profile: _brain.Profile,
        *,
        cruise_mps: float | None = None,
    ) -> None:
        """A tracker without a path.

        Args:
            controller: name of a shipped controller, a file, or the text of one.
            profile: the robot; its limits and latency are kept to.
            cruise_mps: greatest speed wanted [m/s]; by default the robot's own.

        Raises:
            ControllerNotFound, ControllerUnreadable, ControllerInvalid, ControllerMismatch,
            TrackValueOutOfRange: what is wrong with the controller.
        """
        self._brain = _brain.Tracker(controller_text(controller), profile, cruise_mps)

    def follow(
        self,
        points: ArrayLike,
        *,
        spacing_m: float | None = 0.3,
        corridor_m: float = 0.0,
        is_clear: Callable[[Point, Point], bool] | None = None,
    ) -> None:
        """Take up a path from its first point on, now or while driving.

        Args:
            points: (n, 2) world frame [m].
            spacing_m: greatest distance between waypoints; None: `points` are the waypoints.
            corridor_m: the path may be drawn straight within this distance of where it was.
            is_clear: whether the straight way between two points may be driven; default always.

        Raises:
            PathEmpty, PathPointNotFinite, PathShapeWrong, TrackValueOutOfRange.
        """
        self._brain.follow(_points(points), spacing_m, corridor_m, is_clear)

    def clear(self) -> None:
        """Forget the path; the next steps brake."""
        self._brain.clear()

    @property
    def waypoints(self) -> NDArray[np.float64] | None:
        """Waypoints (n, 2), world frame [m]; None without a path."""
        return self._brain.waypoints

    @property
    def index(self) -> int:
        """Index of the current node N_i, from 0; may be set, as after an avoidance."""
        return self._brain.index

    @index.setter
    def index(self, index: int) -> None:
        self._brain.index = index

    def advance_pointer(self, position: Point) -> None:
        """Move the pointer forward while `position` is nearer to the next node."""
        self._brain.advance_pointer(*map(float, position))

    def step(
        self, pose: tuple[float, float, float], twist: tuple[float, float], dt_s: float
    ) -> TrackingRecord:
        """The command for the next `dt_s`, and how it came about.

        Args:
            pose: (x [m], y [m], heading [rad]) of the robot in the world.
            twist: measured (V [m/s], ω [rad/s]).
            dt_s: one tick [s].

        Raises:
            MeasurementNotFinite: NaN or infinity among them.
            TimeStepInvalid: the tick is not above 0.
        """
        x, y, heading = (float(value) for value in pose)
        linear, angular = (float(value) for value in twist)
        return TrackingRecord(self._brain.step((x, y, heading), (linear, angular), float(dt_s)))

    def overridden(self, twist: tuple[float, float]) -> None:
        """Tell what the robot was sent instead of the last command, if something changed it."""
        linear, angular = (float(value) for value in twist)
        self._brain.overridden((linear, angular))

    def rehearse(
        self,
        start: tuple[float, float, float],
        *,
        tick_s: float = 0.1,
        latency_s: float = 0.1,
        turn_share: float = 1.0,
        most_s: float = 600.0,
    ) -> Rehearsal:
        """The drive along the path taken up, worked out in advance, from rest until arrival.

        The robot obeys [Maalouf06 (1)] and its ramp; nothing stands in the way. The tracker itself
        stays as it is.

        Args:
            start: pose (x [m], y [m], heading [rad]), world frame.
            tick_s: from one command to the next [s].
            latency_s: from a command to the motion that follows it, in truth [s].
            turn_share: turn rate of the robot as a share of that of its wheels.
            most_s: it ends after this [s].

        Raises:
            MeasurementNotFinite, TimeStepInvalid, TrackValueOutOfRange.
        """
        x, y, heading = (float(value) for value in start)
        table = self._brain.rehearse((x, y, heading), tick_s, latency_s, turn_share, most_s)
        return Rehearsal(table[:, 0], table[:, 1:4], table[:, 4:6], table[:, 6:8])

    @property
    def look_ahead(self) -> FuzzySystem:
        """The first module: alpha1, alpha2 → C (Table 1)."""
        return FuzzySystem._of(self._brain.look_ahead_system())

    @property
    def control(self) -> FuzzySystem:
        """The second module: C, Vc, dR, dtheta → V, omega; Fig. 9 is its V at C = Vc = 0."""
        return FuzzySystem._of(self._brain.tracker_system())
