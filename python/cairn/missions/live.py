"""A run that people watch and steer: in a thread of its own, at its own pace.

Commands go in and are obeyed between two ticks; the newest snapshot comes out. The run never waits
for whoever watches: a snapshot is taken only when the last one was fetched, and nobody fetching
costs nothing.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from cairn.errors import CairnError
from cairn.missions import scenario as scenarios
from cairn.missions.moments import Moments
from cairn.missions.result import CANCELLED, REPLACED, Result
from cairn.missions.runner import TICK_S, Loop, Observer
from cairn.missions.scenario import (
    Cancel,
    EmergencyStop,
    Expect,
    Goal,
    NewGoal,
    Scenario,
    Shove,
    Start,
)
from cairn.missions.setting import Setting, body_of, build
from cairn.view.console.commands import (
    Begin,
    CallOff,
    Carry,
    Command,
    DriveTo,
    End,
    Explore,
    Pause,
    PutBox,
    Show,
    Speed,
    Step,
    StopNow,
    TakeBox,
)
from cairn.view.console.snapshot import Note, Snapshot

SPARES = 32  # boxes that may stand at a time besides the scenario's
STOP_S = 1.0  # how long the emergency stop is pressed
NOTES = 20
SLOWEST, FASTEST = 0.1, 100.0  # times real time; beyond, inf: as fast as it goes


class Live:
    """One run at a time of a scenario, watched and steered.

    Args:
        scenario: what to do, where.
        seed: of everything random; by default the scenario's own.
        observers: makes the observers of run 0, 1, ...: context managers are closed at its end.
        finish: given every run's result and number, in the run's thread.
        speed: simulated seconds per second; inf: as many as there can be.
        paused: begin paused.
        open_end: go on when all goals are done, until told to end; a goal may then take the
            scenario's `timeout_s`. Otherwise the whole run may.

    Raises:
        CairnError: the scenario names what does not exist or does not fit together.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        seed: int | None = None,
        observers: Callable[[int], Iterable[Observer]] = lambda run: (),
        finish: Callable[[Result, int], None] = lambda result, run: None,
        speed: float = 1.0,
        paused: bool = False,
        open_end: bool = False,
        setting: Callable[..., Setting] = build,
    ) -> None:
        self._scenario = scenario
        self._seed = scenario.seed if seed is None else seed
        self._observers, self._finish, self._setting = observers, finish, setting
        self._speed, self._paused, self._open_end = _speed(speed), paused, open_end
        self._steps = 0
        self._shown = 0
        self._run = -1
        self._notes: deque[Note] = deque(maxlen=NOTES)
        self._note_count = 0
        self._inbox: deque[Command] = deque()
        self._bell = threading.Condition()
        self._moments = Moments()
        self._wanted = True
        self._newest: Snapshot | None = None
        self._pace, self._due = 0.0, 0.0
        self._marks: deque[tuple[float, float]] = deque(maxlen=50)
        self._over: str | None = None
        self._ended = threading.Event()
        self._stopping = False
        self._error: BaseException | None = None
        self.results: list[Result] = []
        self._thread = threading.Thread(target=self._live, name="cairn run", daemon=True)
        self._enter(scenario, *self._built(scenario))

    # ---- for whoever watches, in any thread ------------------------------------------------------

    def start(self) -> Live:
        """Let time pass."""
        self._thread.start()
        return self

    def do(self, command: Command) -> None:
        """Ask for something: obeyed before the next tick. Never waits."""
        with self._bell:
            self._inbox.append(command)
            self._bell.notify_all()

    def snapshot(self) -> Snapshot | None:
        """The newest snapshot, at once; None before the first. Asks for a newer one."""
        with self._bell:
            newest = self._newest
            self._wanted = True
            self._bell.notify_all()
        return newest

    def newer(self, than: int, timeout_s: float) -> Snapshot | None:
        """A snapshot with a number above `than`, waited for; None if there was none in time."""
        with self._bell:
            self._wanted = True
            self._bell.notify_all()
            self._bell.wait_for(lambda: self._is_newer(than) or self._ended.is_set(), timeout_s)
            return self._newest if self._is_newer(than) else None

    @property
    def ended(self) -> bool:
        """Whether the last run is over and its result is there."""
        return self._ended.is_set()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for the end; False if it did not come in time.

        Raises:
            Whatever broke the run in its thread.
        """
        over = self._ended.wait(timeout_s)
        if self._error is not None:
            raise self._error
        return over

    def end(self, timeout_s: float = 30.0) -> Result:
        """End the run and return the last result."""
        self.do(End())
        self.wait(timeout_s)
        return self.results[-1]

    def _is_newer(self, than: int) -> bool:
        return self._newest is not None and self._newest.number > than

    # ---- the run, in its own thread --------------------------------------------------------------

    def _live(self) -> None:
        try:
            self._due = time.monotonic()
            while self._tick():
                pass
            self._close_run()
            self._publish()
        except BaseException as error:
            self._error = error
        finally:
            with self._bell:
                self._ended.set()
                self._bell.notify_all()

    def _tick(self) -> bool:
        """Obey, decide, let time pass, keep pace. False once the run is over."""
        self._obey()
        if self._stopping:
            return False
        if self._paused and self._steps == 0:
            self._rest()
            return True
        self._steps = max(self._steps - 1, 0)
        loop = self._loop
        if self._open_end:
            for follower in loop.followers:
                follower.give_up(loop.time_s, self._scenario.timeout_s)
        ended = sum(len(follower.goals) for follower in loop.followers)
        loop.decide()
        if ended < sum(len(follower.goals) for follower in loop.followers):
            self._tell_ends()
        self._publish()
        if not self._open_end and loop.done:
            return False
        loop.move()
        if not self._open_end and loop.time_s >= self._scenario.timeout_s:
            return False
        self._keep_pace()
        return True

    def _keep_pace(self) -> None:
        """Sleep until the next tick is due; time lost is not made up for."""
        now = time.monotonic()
        self._due = max(self._due + TICK_S / self._speed, now - TICK_S / self._speed)
        while (left_s := self._due - time.monotonic()) > 0 and not self._stopping:
            with self._bell:
                if not self._inbox:
                    self._bell.wait(left_s)
            self._obey()
        self._marks.append((time.monotonic(), self._loop.time_s))
        (before, then_s), (after, now_s) = self._marks[0], self._marks[-1]
        self._pace = (now_s - then_s) / (after - before) if after > before else 0.0

    def _rest(self) -> None:
        """Paused: wait for a command, or for somebody who wants to see."""
        self._marks.clear()
        self._pace = 0.0
        self._publish()
        with self._bell:
            self._bell.wait_for(lambda: self._inbox or self._wanted, 0.5)
        self._due = time.monotonic()

    def _publish(self) -> None:
        """Take a snapshot if somebody wants one."""
        with self._bell:
            if not (self._wanted or self._over):
                return
            self._wanted = False
        snapshot = self._moments.take(
            self._loop,
            self._seed,
            shown=self._shown,
            paused=self._paused,
            speed=self._speed,
            pace=self._pace,
            notes=tuple(self._notes),
            over=self._over,
        )
        with self._bell:
            self._newest = snapshot
            self._bell.notify_all()

    def _built(self, scenario: Scenario) -> tuple[Setting, float]:
        """The setting of a run, and how long it took to build."""
        began = time.perf_counter()
        setting = self._setting(scenario, self._seed, spares=SPARES)
        return setting, time.perf_counter() - began

    def _enter(self, scenario: Scenario, setting: Setting, build_s: float) -> None:
        """Begin a run; the one before has been closed."""
        self._scenario, self._build_s = scenario, build_s
        self._run += 1
        self._over = None
        self._boxes: dict[str, scenarios.Box] = {}
        self._events: list[scenarios.Event] = []
        self._moments.begin(self._run)
        self._stack = contextlib.ExitStack()
        observers = list(self._observers(self._run))
        for each in observers:
            if isinstance(each, contextlib.AbstractContextManager):
                self._stack.enter_context(each)
        self._loop = Loop(scenario, setting, observers, self._seed)
        self._shown = min(self._shown, len(self._loop.followers) - 1)
        self._began = time.perf_counter()
        self._marks.clear()

    def _close_run(self) -> None:
        """Sum the run up."""
        loop = self._loop
        if not loop.decisions:
            loop.decide()
        if self._stopping or self._open_end:
            for follower in loop.followers:
                follower.abandon(loop.time_s)
        loop.close()
        self._stack.close()
        # What people did is part of what happened: the record can be run again.
        loop.scenario = loop.scenario.model_copy(
            update={
                "boxes": (*loop.scenario.boxes, *self._boxes.values()),
                "events": (*loop.scenario.events, *self._events),
            }
        )
        run_s = time.perf_counter() - self._began
        result = loop.result(self._seed, build_s=self._build_s, run_s=run_s)
        self.results.append(result)
        self._finish(result, self._run)
        self._over = result.sentence
        self._tell(f"Run over: {result.sentence}", wrong=result.exit_code != 0)

    # ---- commands --------------------------------------------------------------------------------

    def _obey(self) -> None:
        """Carry out what was asked for."""
        while self._inbox and not self._stopping:
            try:
                self._carry_out(self._inbox.popleft())
            except (CairnError, ValueError) as error:
                self._tell(str(error), wrong=True)
            with self._bell:
                self._wanted = True

    def _carry_out(self, command: Command) -> None:
        match command:
            case Pause(on):
                self._paused, self._steps = on, 0
            case Step(ticks):
                self._paused, self._steps = True, self._steps + ticks
            case Speed(factor):
                self._speed, self._due = _speed(factor), time.monotonic()
                self._marks.clear()
            case Show(robot):
                self._follower(robot)
                self._shown = robot
            case Begin(start):
                self._begin_anew(start)
            case End():
                self._stopping = True
            case _:
                self._do_in_world(command)

    def _do_in_world(self, command: Command) -> None:
        now_s = self._loop.time_s
        match command:
            case DriveTo(x_m, y_m, robot):
                self._happens(NewGoal(do="new_goal", at_s=now_s, x_m=x_m, y_m=y_m, robot=robot))
            case Explore(for_s, robot):
                self._follower(robot).order(Goal(explore_s=for_s), now_s)
            case CallOff(robot):
                self._happens(Cancel(do="cancel", at_s=now_s, robot=robot))
            case StopNow():
                for robot, follower in enumerate(self._loop.followers):
                    self._happens(
                        EmergencyStop(do="emergency_stop", at_s=now_s, for_s=STOP_S, robot=robot)
                    )
                    follower.waiting.clear()
                    self._happens(Cancel(do="cancel", at_s=now_s, robot=robot))
            case PutBox():
                self._put(command)
            case TakeBox(name):
                self._take(name)
            case Carry(x_m, y_m, heading, robot):
                self._carry(robot, x_m, y_m, heading)

    def _happens(self, event: scenarios.Event) -> None:
        """Let something happen to a robot, and keep it for the record."""
        self._follower(event.robot).happens(event, self._loop.time_s)
        self._events.append(event)

    def _put(self, command: PutBox) -> None:
        box = scenarios.Box(
            x_m=command.x_m,
            y_m=command.y_m,
            length_m=command.length_m,
            width_m=command.width_m,
            yaw_rad=command.heading,
            name=f"dropped {len(self._boxes) + 1}",
            from_s=self._loop.time_s,
        )
        for stage in self._stages():
            stage.put(body_of(box))
        self._boxes[box.name] = box

    def _take(self, name: str) -> None:
        box, now_s = self._boxes.get(name), self._loop.time_s
        if box is None:
            raise ValueError(f"there is no box `{name}` that was put down")
        for stage in self._stages():
            stage.take_away(name)
        # A box that came and went between two ticks never was.
        until_s = max(now_s, box.from_s + 1e-6)
        self._boxes[name] = box.model_copy(update={"until_s": until_s})

    def _stages(self) -> list[Any]:
        """What stands around the robots; several in one physics share one."""
        stages = [follower.agent.robot.stage for follower in self._loop.followers]
        return list({id(stage): stage for stage in stages}.values())

    def _carry(self, robot: int, x_m: float, y_m: float, heading: float | None) -> None:
        follower = self._follower(robot)
        x, y, now = follower.agent.robot.truth
        c, s = math.cos(now), math.sin(now)
        dx, dy = x_m - x, y_m - y
        turn = 0.0 if heading is None else math.remainder(heading - now, math.tau)
        shove = Shove(
            do="shove",
            at_s=self._loop.time_s,
            dx_m=c * dx + s * dy,
            dy_m=c * dy - s * dx,
            dheading_rad=turn,
            robot=robot,
        )
        self._happens(shove)

    def _begin_anew(self, start: tuple[float, float, float] | None) -> None:
        scenario = self._scenario
        if start is not None:
            where = Start(x_m=start[0], y_m=start[1], heading_rad=start[2])
            if scenario.start is not None:
                scenario = scenario.model_copy(update={"start": where})
            else:
                first, *others = scenario.robots
                moved = first.model_copy(update={"start": where})
                scenario = scenario.model_copy(update={"robots": (moved, *others)})
        built = self._built(scenario)  # refused before the run that is on is given up
        self._close_run()
        self._enter(scenario, *built)

    def _follower(self, robot: int) -> Any:
        followers = self._loop.followers
        if not 0 <= robot < len(followers):
            raise ValueError(f"there is no robot {robot}; there are {len(followers)}")
        return followers[robot]

    def _tell_ends(self) -> None:
        """Tell of goals that ended in this tick, but of those that a person ended."""
        for follower in self._loop.followers:
            for goal in follower.goals:
                if goal.ended_s == self._loop.time_s and goal.outcome not in (CANCELLED, REPLACED):
                    self._tell(goal.sentence, wrong=not goal.as_expected)

    def _tell(self, text: str, *, wrong: bool) -> None:
        self._note_count += 1
        self._notes.append(Note(self._note_count, self._loop.time_s, text, wrong))


def with_nothing_to_do(scenario: Scenario) -> Scenario:
    """The same place, robots and boxes, without goals, events and expectations."""
    robots = tuple(entry.model_copy(update={"goals": ()}) for entry in scenario.robots)
    return scenario.model_copy(
        update={"goals": (), "events": (), "expect": Expect(), "robots": robots}
    )


def _speed(factor: float) -> float:
    if not factor > 0:
        raise ValueError(f"the speed is {factor}: it must be above 0")
    return factor if math.isinf(factor) else min(max(factor, SLOWEST), FASTEST)
