"""The controls beside the map, and what they ask of the run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from cairn.view.console import commands as ask
from cairn.view.console import words
from cairn.view.console.scene import LAYERS, Drawing
from cairn.view.console.shapes import BLUE, RED
from cairn.view.console.snapshot import Floats, Snapshot

SPEEDS = {"¼×": 0.25, "1×": 1.0, "2×": 2.0, "5×": 5.0, "10×": 10.0, "max": math.inf}
GOAL, BOX, TAKE, CARRY, START = (
    "drive there",
    "put a box down",
    "take a box away",
    "carry the robot there",
    "begin anew there",
)
CLICKS = (GOAL, BOX, TAKE, CARRY, START)
HINTS = {
    GOAL: "Click on the map: the robot drives there. With Shift held, a click puts a box down.",
    BOX: "Click on the map: a box stands there that no map shows.",
    TAKE: "Click on a box that you put down.",
    CARRY: "Click on the map: the robot is lifted and set down there. Nobody tells it.",
    START: "Click on the map: a new run begins with the robot there, and it knows where it is.",
}
_TIME: dict[str, ask.Command] = {
    "Pause": ask.Pause(),
    "Go on": ask.Pause(False),
    "One tick": ask.Step(),
}
_PLOT_POINTS = 300
_PANEL_PX = 400


class Panel:
    """Buttons, words and plots of the console.

    Args:
        server: a `viser.ViserServer`.
        drawing: whose layers the boxes to tick switch.
        do: where commands go.
        interactive: whether goals and start poses can be given; otherwise the run is only watched,
            paused, hindered and stopped.
        title: over the panel.
    """

    def __init__(
        self,
        server: Any,
        drawing: Drawing,
        do: Callable[[ask.Command], None],
        *,
        interactive: bool,
        title: str,
    ) -> None:
        self._gui, self._drawing, self._do = server.gui, drawing, do
        self._server = server
        self._interactive = interactive
        self._snapshot: Snapshot | None = None
        self._html: dict[str, tuple[Any, str]] = {}
        self._robot = self._places = self._plots = None
        self._notes = 0
        self._gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            control_width="large",
            brand_color=(30, 66, 92),
        )
        self._gui.set_panel_label(title)
        self._gui.main_panel.dock_right()
        self._gui.main_panel.set_width(_PANEL_PX)
        self._build()

    @property
    def robot(self) -> int:
        """Number of the robot that is looked at and commanded."""
        if self._robot is None or self._snapshot is None:
            return 0
        names = [state.name for state in self._snapshot.robots]
        return names.index(self._robot.value) if self._robot.value in names else 0

    def clicked(self, x: float, y: float, *, box: bool = False) -> None:
        """Do what a click on the map at (x, y) [m] is to do; `box`: put a box down whatever."""
        what = BOX if box else self._click.value
        heading = math.radians(self._heading.value)
        if what == GOAL:
            self._do(ask.DriveTo(x, y, self.robot))
        elif what == BOX:
            length, width = self._length.value, self._width.value
            self._do(ask.PutBox(x, y, length, width, heading))
        elif what == TAKE:
            self._take(x, y)
        elif what == CARRY:
            self._do(ask.Carry(x, y, heading, self.robot))
        elif what == START:
            self._do(ask.Begin((x, y, heading)))

    def show(self, snapshot: Snapshot) -> None:
        """Tell what a snapshot says."""
        first = self._snapshot is None
        self._snapshot = snapshot
        if first:
            self._build_for(snapshot)
        robot = self.robot
        state = snapshot.robots[robot]
        self._write("status", words.status(snapshot, robot))
        self._write("why", words.why(state))
        self._write("log", words.log(snapshot, robot))
        self._plot(state.history)
        for note in snapshot.notes:
            if note.number > self._notes:
                self._notes = note.number
                self._notify(note.text, note.wrong)

    # ---- building --------------------------------------------------------------------------------

    def _build(self) -> None:
        gui = self._gui
        self._html["status"] = (gui.add_html(""), "")
        stop = gui.add_button("STOP", color="red", hint="Presses the robot's emergency stop.")
        stop.on_click(lambda _: self._do(ask.StopNow()))
        self._time = gui.add_button_group("Time", ("Pause", "Go on", "One tick"))
        self._time.on_click(lambda event: self._do(_TIME[event.target.value]))
        speed = gui.add_button_group("Speed", tuple(SPEEDS), hint="Simulated time per real time.")
        speed.on_click(lambda event: self._do(ask.Speed(SPEEDS[event.target.value])))
        self._build_clicks()
        tabs = gui.add_tab_group()
        with tabs.add_tab("Why"):
            self._html["why"] = (gui.add_html(""), "")
        with tabs.add_tab("Plots"):
            self._plots_at = gui.add_folder("V and ω of the last minute")
        with tabs.add_tab("Log"):
            self._html["log"] = (gui.add_html(""), "")
        with tabs.add_tab("Map"):
            self._build_layers()

    def _build_clicks(self) -> None:
        gui = self._gui
        choices = CLICKS if self._interactive else (BOX, TAKE, CARRY)
        self._click = gui.add_dropdown("A click is to", choices, initial_value=choices[0])
        self._hint = gui.add_html("")
        self._length = gui.add_slider("Length [m]", 0.1, 2.0, 0.1, 0.5, visible=False)
        self._width = gui.add_slider("Width [m]", 0.1, 2.0, 0.1, 0.5, visible=False)
        self._heading = gui.add_slider("Heading [°]", -180, 180, 5, 0, visible=False)

        def chosen(_: Any) -> None:
            what = self._click.value
            self._length.visible = self._width.visible = what == BOX
            self._heading.visible = what in (BOX, CARRY, START)
            self._hint.content = words.hint(HINTS[what])

        self._click.on_update(chosen)
        chosen(None)

    def _build_layers(self) -> None:
        gui = self._gui
        above = gui.add_button("Look from above")
        above.on_click(lambda event: self._look(event.client))
        style = gui.add_dropdown("Field as", ("contours", "arrows"))

        @style.on_update
        def _(_: Any) -> None:
            self._drawing.style = style.value

        for key, (name, on) in LAYERS.items():
            box = gui.add_checkbox(name, on)
            box.on_update(lambda event, key=key: self._drawing.on.update({key: event.target.value}))
        gui.add_html(words.legend())

    def _build_for(self, snapshot: Snapshot) -> None:
        """Controls that depend on the scenario."""
        gui = self._gui
        names = tuple(state.name for state in snapshot.robots)
        if len(names) > 1:
            self._robot = gui.add_dropdown("Robot", names, order=-1.0)
            self._robot.on_update(lambda _: self._do(ask.Show(self.robot)))
        if self._interactive:
            self._build_tasks(snapshot)
        with self._plots_at:
            limit = snapshot.robots[0].body.linear_mps
            self._plots = [
                self._new_plot("V", "m/s", limit, BLUE),
                self._new_plot("ω", "rad/s", None, RED),
            ]

    def _build_tasks(self, snapshot: Snapshot) -> None:
        gui = self._gui
        with gui.add_folder("Tasks", expand_by_default=True, order=self._hint.order + 0.5):
            if snapshot.places:
                self._places = gui.add_dropdown("Drive to", ("choose a place", *snapshot.places))

                @self._places.on_update
                def _(event: Any) -> None:
                    at = snapshot.places.get(event.target.value)
                    if at is not None:
                        self._do(ask.DriveTo(at[0], at[1], self.robot))

            buttons = gui.add_button_group("Task", ("Explore", "Call off", "Start over"))

            @buttons.on_click
            def _(event: Any) -> None:
                command = {
                    "Explore": ask.Explore(robot=self.robot),
                    "Call off": ask.CallOff(self.robot),
                    "Start over": ask.Begin(),
                }[event.target.value]
                self._do(command)

    def _new_plot(self, name: str, unit: str, limit: float | None, colour: Any) -> Any:
        span = {"range": [0.0, limit * 1.05]} if limit else {"auto": True}
        return self._gui.add_uplot(
            data=(np.array([0.0, 1.0]), np.array([0.0, 0.0])),
            series=(
                {"label": "t [s]"},
                {"label": f"{name} [{unit}]", "stroke": words.css(colour), "width": 1.6},
            ),
            scales={"x": {"time": False}, "y": span},
            axes=({"size": 30}, {"size": 44}),
            legend={"show": True},
            height=150,
        )  # type: ignore[arg-type]

    # ---- telling ---------------------------------------------------------------------------------

    def _write(self, name: str, content: str) -> None:
        handle, before = self._html[name]
        if content != before:
            handle.content = content
            self._html[name] = (handle, content)

    def _plot(self, history: Floats) -> None:
        if self._plots is None or len(history) < 2:
            return
        thinned = history[:: max(1, len(history) // _PLOT_POINTS)]
        for column, plot in enumerate(self._plots, start=1):
            plot.data = (thinned[:, 0].copy(), thinned[:, column].copy())

    def _notify(self, text: str, wrong: bool) -> None:
        for client in self._server.get_clients().values():
            client.add_notification(
                title="Refused" if wrong else "Cairn",
                body=text,
                auto_close_seconds=8.0,
                color="red" if wrong else "teal",
            )

    # ---- doing -----------------------------------------------------------------------------------

    def _take(self, x: float, y: float) -> None:
        """Take away the box under a click, or the nearest within half a metre."""
        if self._snapshot is None:
            return
        boxes = [(math.hypot(box.x - x, box.y - y), box) for box in self._snapshot.boxes]
        near = [
            pair for pair in boxes if pair[0] < 0.5 + max(pair[1].length_m, pair[1].width_m) / 2
        ]
        if near:
            self._do(ask.TakeBox(min(near, key=lambda pair: pair[0])[1].name))

    def _look(self, client: Any) -> None:
        if client is not None and self._snapshot is not None:
            camera = client.camera
            aspect = camera.image_width / max(camera.image_height, 1)
            self._drawing.look_from_above(camera, self._snapshot.world, aspect)
