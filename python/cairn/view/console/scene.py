"""The map and what moves on it, drawn into a viser scene from above."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cairn.view.console import shapes
from cairn.view.console.shapes import AMBER, BLUE, GREEN, INK, PALE, RED, Colour
from cairn.view.console.snapshot import BoxState, Floats, Grid, RobotState, Snapshot

FOV_RAD = 0.3  # narrow: nearly a plan, as if seen from far above
MARGIN = 1.06
_BELOW_M = 0.35  # names of places stand below them

# Heights [m]: what lies on what. Far enough apart for a camera 100 m above.
_Z = {
    "world": 0.0, "map": 0.01, "costs": 0.03, "heard": 0.046, "silent": 0.035, "near": 0.06,
    "middling": 0.061, "far": 0.062, "trail": 0.085, "path": 0.08, "waypoints": 0.09, "goal": 0.1,
    "scan": 0.1, "estimate": 0.12, "chosen": 0.3,
}  # fmt: skip

_APART_M = 0.0006  # of what overlaps within one layer: 16 sonars fit below the next

LAYERS = {  # what a person may switch off: key, name, on at first
    "costs": ("cost-to-go field", True),
    "sonar": ("sonar and lidar", True),
    "arcs": ("curvature intervals", True),
    "path": ("plan and waypoints", True),
    "trail": ("way driven", True),
    "world": ("what the map does not show", False),
    "places": ("names of places", True),
}


class Drawing:
    """A viser scene that follows snapshots. Sends only what changed."""

    def __init__(self, server: Any) -> None:
        """Draw into `server`, a `viser.ViserServer`."""
        self._scene = server.scene
        self._server = server
        self._scene.configure_environment_map(None)
        self._scene.configure_default_lights(enabled=False)
        # Together they give a colour seen from above as it is meant, and sides in shade.
        self._scene.add_light_ambient("/light", intensity=2.3)
        self._scene.add_light_directional("/sun", intensity=0.9, position=(-3.0, -5.0, 12.0))
        self._handles: dict[str, Any] = {}
        self._drawn: dict[str, Any] = {}
        self.on = {key: on for key, (_, on) in LAYERS.items()}
        self.style = "contours"
        self.ghost: tuple[float, float, float] | None = None

    def show(self, snapshot: Snapshot, robot: int) -> None:
        """Draw a snapshot; `robot` is the one looked at."""
        if self._drawn.get("run") != snapshot.run:
            self._forget()
            self._drawn["run"] = snapshot.run
        with self._server.atomic():
            self._draw_grids(snapshot)
            self._draw_boxes(snapshot.boxes)
            self._draw_places(snapshot)
            for number, state in enumerate(snapshot.robots):
                self._draw_robot(state, number == robot)
            self._draw_senses(snapshot.robots[robot])
            self._draw_ways(snapshot.robots[robot])

    def look_from_above(self, camera: Any, grid: Grid, aspect: float) -> None:
        """Put a camera (viser's initial one, or a client's) straight above a map."""
        x0, x1, y0, y1 = shapes.view(grid)
        half = math.tan(FOV_RAD / 2)
        away = MARGIN * max((y1 - y0) / 2, (x1 - x0) / 2 / max(aspect, 0.1)) / half
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        camera.fov = FOV_RAD
        camera.near, camera.far = max(away * 0.02, 0.1), away * 20
        # Not quite straight down: up on the screen stays +y, and dragging tilts from there.
        camera.position = (x, y - away * 1e-3, away)
        camera.look_at = (x, y, 0.0)

    # ---- layers ----------------------------------------------------------------------------------

    def _draw_grids(self, snapshot: Snapshot) -> None:
        self._image(
            "map", snapshot.grid, snapshot.grid.number, lambda: shapes.map_pixels(snapshot.grid)
        )
        world = snapshot.world
        shown = world.number if self.on["world"] else None
        self._image(
            "world", world, shown, lambda: shapes.missing_pixels(world, snapshot.grid), z=0.02
        )
        costs = snapshot.costs if self.on["costs"] else None
        key = (None if costs is None else costs.number, self.style)
        if self._drawn.get("costs") != key:
            self._drawn["costs"] = key
            self._draw_costs(costs)

    def _draw_costs(self, costs: Grid | None) -> None:
        if costs is None:
            self._remove("costs")
            self._remove("heads")
            return
        if self.style == "arrows":
            segments, shares = shapes.arrows(costs)
            colours = shapes.shaded(shares)
            self._segments("costs", segments, colours, 1.4)
            tip = segments[:, 1] + (segments[:, 1] - segments[:, 0]) * 0.02
            back = segments[:, 1] - segments[:, 0]
            side = np.stack([-back[:, 1], back[:, 0]], axis=-1)
            wings = [tip - back * 0.34 + side * 0.17, tip - back * 0.34 - side * 0.17]
            heads = np.concatenate([np.stack([tip, wing], axis=1) for wing in wings])
            self._segments("heads", heads, np.concatenate([colours, colours]), 1.4, z=_Z["costs"])
        else:
            segments, shares = shapes.contours(costs)
            self._remove("heads")
            self._segments("costs", segments, shapes.shaded(shares), 1.3)

    def _draw_boxes(self, boxes: Iterable[BoxState]) -> None:
        wanted = {f"/boxes/{box.name} {i}": box for i, box in enumerate(boxes)}
        for name in [name for name in self._handles if name.startswith("/boxes/")]:
            if self._drawn.get(name) != wanted.get(name):
                self._remove(name)
        for name, box in wanted.items():
            if name not in self._handles:
                self._drawn[name] = box
                self._handles[name] = self._scene.add_box(
                    name,
                    color=AMBER,
                    dimensions=(box.length_m, box.width_m, box.height_m),
                    opacity=1.0 if box.standing else 0.35,
                    position=(box.x, box.y, box.height_m / 2),
                    wxyz=_turn(box.heading),
                    cast_shadow=False,
                    receive_shadow=False,
                )

    def _draw_places(self, snapshot: Snapshot) -> None:
        if self._drawn.get("places") == self.on["places"]:
            return
        self._drawn["places"] = self.on["places"]
        for name, at in snapshot.places.items():
            if self.on["places"]:
                self._handles[f"/places/{name}"] = self._scene.add_label(
                    f"/places/{name}",
                    name,
                    position=(at[0], at[1] - _BELOW_M, 0.05),
                    anchor="top-center",
                    font_screen_scale=0.75,
                )
            else:
                self._remove(f"/places/{name}")

    def _draw_robot(self, state: RobotState, chosen: bool) -> None:
        name, body = f"/robots/{state.name}", state.body
        colour = shapes.mode_of(state.decision["mode"])[1]
        if f"{name}/body" not in self._handles:
            self._handles[name] = self._scene.add_frame(name, show_axes=False)
            self._handles[f"{name}/nose"] = self._mesh_of_nose(f"{name}/nose", body)
        if self._drawn.get(name) != colour:
            self._drawn[name] = colour
            self._handles[f"{name}/body"] = self._scene.add_box(
                f"{name}/body",
                color=colour,
                dimensions=(body.length_m, body.width_m, body.height_m),
                position=(0.0, 0.0, body.height_m / 2 + 0.1),
                cast_shadow=False,
                receive_shadow=False,
            )
        frame = self._handles[name]
        frame.position = (state.truth[0], state.truth[1], 0.0)
        frame.wxyz = _turn(state.truth[2])
        corners = shapes.placed(shapes.outline(body.length_m, body.width_m), state.estimate)
        self._segments(f"{name} believed", shapes.closed(corners), INK if chosen else PALE, 2.0,
                       z=_Z["estimate"])  # fmt: skip

    def _mesh_of_nose(self, name: str, body: Any) -> Any:
        """A bright wedge on top that points ahead."""
        x, y = body.length_m / 2, body.width_m / 2
        z = body.height_m + 0.12
        corners = [
            (0.8 * x, 0, z),
            (-0.35 * x, 0.6 * y, z),
            (-0.1 * x, 0, z),
            (-0.35 * x, -0.6 * y, z),
        ]
        return self._scene.add_mesh_simple(
            name,
            np.array(corners),
            np.array([(0, 1, 2), (0, 2, 3)]),
            color=(255, 255, 255),
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _draw_senses(self, state: RobotState) -> None:
        on = self.on["sonar"]
        empty = (np.empty((0, 2)), np.empty((0, 3), dtype=int))
        heard, silent = (
            shapes.cones(state.body, state.ranges_m, state.truth) if on else (empty, empty)
        )
        self._mesh("heard", heard, (226, 160, 63), 0.30, each=shapes.CONE_POINTS)
        self._mesh("silent", silent, (120, 170, 214), 0.14, each=shapes.CONE_POINTS)
        points = shapes.scan_points(state.body, state.ranges_m, state.truth) if on else empty[0]
        cross = np.array([[-0.03, 0.0], [0.03, 0.0]])
        self._segments("scan", points[:, None] + cross, AMBER, 4.0)
        avoidance = state.decision.get("avoidance") if self.on["arcs"] else None
        kinds = (empty, empty, empty)
        if avoidance:
            kinds = shapes.free_arcs(avoidance, state.estimate)
        for name, mesh, colour in zip(
            ("near", "middling", "far"), kinds, (RED, AMBER, GREEN), strict=True
        ):
            self._mesh(name, mesh, colour, 0.34)
        ahead = (
            shapes.chosen_arc(state.decision["twist"], state.estimate)
            if self.on["arcs"]
            else empty[0]
        )
        self._segments(
            "chosen", shapes.strip(ahead) if len(ahead) else np.empty((0, 2, 2)), INK, 4.0
        )

    def _draw_ways(self, state: RobotState) -> None:
        none = np.empty((0, 2, 2))
        path, points = (
            (state.path, state.waypoints) if self.on["path"] else (none[:, 0], none[:, 0])
        )
        going = state.goal is not None and len(path) > 1
        key = (len(path), float(path.sum()) if going else 0.0, going, self.on["path"])
        if self._drawn.get("path") != key:
            self._drawn["path"] = key
            self._segments("path", shapes.strip(path) if going else none, BLUE, 3.0)
        index = int(state.decision.get("waypoint_index") or 0)
        key = (len(points), float(points.sum()), index, going)
        if self._drawn.get("waypoints") != key:
            self._drawn["waypoints"] = key
            self._draw_waypoints(points if going else none[:, 0], index)
        if state.goal != self._drawn.get("goal"):
            self._drawn["goal"] = state.goal
            self._draw_goal(state.goal)
        trail = state.trail if self.on["trail"] else none[:, 0]
        key = (len(trail), tuple(trail[-1].round(2)) if len(trail) else None)
        if self._drawn.get("trail") != key:
            self._drawn["trail"] = key
            self._draw_trail(trail, state.trail_modes)

    def _draw_waypoints(self, points: Floats, index: int) -> None:
        if not len(points):
            self._remove("waypoints")
            return
        left = points[index:]
        dots = left[:, None] + np.array([[-0.03, 0.0], [0.03, 0.0]])
        colours = np.full((len(left), 3), BLUE, dtype=np.uint8)
        colours[1:4] = RED  # those looked at
        self._segments("waypoints", dots, colours, 5.5)

    def _draw_trail(self, trail: Floats, modes: tuple[str, ...]) -> None:
        if len(trail) < 2:
            self._remove("trail")
            return
        segments = shapes.strip(trail)
        length = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
        keep = (length > 1e-4) & (length < 0.5)
        colours = np.array([shapes.mode_of(mode)[1] for mode in modes[1:]], dtype=np.uint8)
        self._segments("trail", segments[keep], colours[keep], 3.5)

    def _draw_goal(self, goal: tuple[float, float] | None) -> None:
        if goal is None:
            self._remove("goal")
            return
        turn = np.linspace(0.0, math.tau, 41)
        ring = np.column_stack([np.cos(turn), np.sin(turn)])
        cross = np.array([[[-1.35, 0], [-0.5, 0]], [[0.5, 0], [1.35, 0]]])
        pieces = [shapes.strip(0.3 * ring), shapes.strip(0.06 * ring), 0.3 * cross,
                  0.3 * cross[..., ::-1]]  # fmt: skip
        self._segments("goal", np.concatenate(pieces) + np.array(goal), RED, 3.5)

    # ---- viser -----------------------------------------------------------------------------------

    def _image(self, name: str, grid: Grid, key: Any, pixels: Any, z: float | None = None) -> None:
        if self._drawn.get(name) == key:
            return
        self._drawn[name] = key
        if key is None:
            self._remove(name)
            return
        picture = pixels()
        width, height = shapes.size_m(grid)
        x, y = shapes.centre(grid)
        # viser's images hang with their top at -y: a half turn about x faces them up.
        self._handles[name] = self._scene.add_image(
            f"/{name}",
            picture,
            width,
            height,
            format="png",
            position=(x, y, _Z[name] if z is None else z),
            wxyz=_turn(grid.origin[2], flipped=True),
            cast_shadow=False,
            receive_shadow=False,
        )

    def _mesh(
        self, name: str, mesh: shapes.Mesh, colour: Colour, opacity: float, each: int = 0
    ) -> None:
        """Draw a mesh; made of parts of `each` points that overlap, every part lies a bit higher.

        Otherwise a browser could not tell which of two is on top, and would show them in shreds.
        """
        vertices, faces = mesh
        if not len(faces):
            self._remove(name)
            return
        part = np.arange(len(vertices)) // each if each else 0
        lifted = _lifted(vertices, _Z[name] + _APART_M * part)
        handle = self._handles.get(name)
        if handle is not None:
            handle.vertices, handle.faces = lifted, faces.astype(np.uint32)
            return
        self._handles[name] = self._scene.add_mesh_simple(
            f"/{name}",
            lifted,
            faces,
            color=colour,
            opacity=opacity,
            side="double",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def _segments(
        self, name: str, segments: Floats, colours: Any, pixels: float, z: float | None = None
    ) -> None:
        """Lines (n, 2, 2) of one colour, or of one each (n, 3)."""
        if not len(segments):
            self._remove(name)
            return
        points = _lifted(segments.reshape(-1, 2), _Z[name] if z is None else z).reshape(-1, 2, 3)
        colours = np.asarray(colours, dtype=np.uint8)
        if colours.ndim == 2:
            colours = np.repeat(shapes.in_linear_light(colours)[:, None], 2, axis=1)
        self._handles[name] = self._scene.add_line_segments(
            f"/{name}" if not name.startswith("/") else name,
            points,
            colours,
            thickness=pixels,
            thickness_units="screen",
        )

    def _remove(self, name: str) -> None:
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()

    def _forget(self) -> None:
        for name in list(self._handles):
            self._remove(name)
        self._drawn.clear()


def _lifted(points: Floats, z: Any) -> NDArray[np.float32]:
    return np.column_stack([points, np.broadcast_to(z, len(points))]).astype(np.float32)


def _turn(heading: float, *, flipped: bool = False) -> tuple[float, float, float, float]:
    """Quaternion (w, x, y, z) of a heading; flipped: after a half turn about x."""
    c, s = math.cos(heading / 2), math.sin(heading / 2)
    return (0.0, c, s, 0.0) if flipped else (c, 0.0, 0.0, s)
