"""A run as a short animation: GIF, WebP or PNG by the name of the file."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.font_manager import FontProperties, findfont
from PIL import Image, ImageDraw, ImageFont

from cairn import errors
from cairn.view.story import RobotStory, Story
from cairn.view.style import AMBER, BLUE, FREE, INK, OCCUPIED, PALE, PAPER, RED, TEAL, UNKNOWN
from cairn.world import World

FORMATS = (".gif", ".webp", ".png")
SMOOTH = 2  # drawn so many times larger, then scaled down
BAR_PX = 64
BOX = "#f3d9ad"
HOLD_S = 1.6  # the last picture stays
MODES = {
    "path_tracking": ("Path tracking", TEAL),
    "obstacle_avoidance": ("Obstacle avoidance", RED),
    "path_planning": ("Path planning", "#7c5cbf"),
    "stop": ("Stop", "#66727e"),
}
Point = tuple[float, float]


def animate(
    story: Story,
    path: Path,
    *,
    seconds: float = 9.0,
    rate: int = 11,
    width_px: int = 800,
    observer: Callable[[int, int], None] = lambda drawn, total: None,
) -> Path:
    """Write a run as an animation.

    Args:
        story: of the run.
        path: .gif, .webp or .png (animated).
        seconds: how long it plays, whatever the run took.
        rate: pictures per second.
        width_px: of the picture; a tall map is made narrower.
        observer: told (pictures drawn, pictures in all).

    Returns:
        `path`.

    Raises:
        AnimationFormatUnknown: a file name with another ending.
    """
    check_format(path)
    count, frames = max(round(seconds * rate), 2), []
    for frame in _frames(story, count, width_px):
        frames.append(frame)
        observer(len(frames), count)
    durations = [round(1000 / rate)] * (len(frames) - 1) + [round(1000 * HOLD_S)]
    path.parent.mkdir(parents=True, exist_ok=True)
    how: dict[str, Any] = {"save_all": True, "duration": durations, "loop": 0}
    if path.suffix.lower() == ".gif":
        palette = _palette()
        frames = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in frames]
        how["optimize"] = False
    elif path.suffix.lower() == ".webp":
        how |= {"quality": 82, "method": 4}
    frames[0].save(path, append_images=frames[1:], **how)
    return path


def check_format(path: Path) -> None:
    """Refuse what `animate` cannot write.

    Raises:
        AnimationFormatUnknown: a file name with another ending.
    """
    if path.suffix.lower() not in FORMATS:
        known = ", ".join(FORMATS)
        raise errors.AnimationFormatUnknown(
            f"{path.name}: an animation is one of {known}", path=str(path), known=FORMATS
        )


def _frames(story: Story, count: int, width_px: int) -> Iterator[Image.Image]:
    canvas = _Canvas(story, width_px)
    ground = canvas.ground()
    under, plans, ticks = ground, -1, [0] * len(story.robots)
    for time_s in np.linspace(0.0, story.duration_s, count):
        made = sum(begun <= time_s for robot in story.robots for begun, _ in robot.plans)
        if made != plans:  # another plan: what lies over it is drawn anew
            under, plans, ticks = ground.copy(), made, [0] * len(story.robots)
            for robot in story.robots:
                canvas.draw_plan(ImageDraw.Draw(under), robot, time_s)
        for number, robot in enumerate(story.robots):
            tick = robot.at(time_s)
            canvas.draw_way(ImageDraw.Draw(under), robot, ticks[number], tick)
            ticks[number] = tick
        picture = under.copy()
        draw = ImageDraw.Draw(picture)
        for robot in story.robots:
            canvas.draw_echoes(draw, robot, robot.at(time_s))
            canvas.draw_robot(draw, robot, robot.at(time_s))
        canvas.draw_bar(draw, time_s)
        yield picture.reduce(SMOOTH)


def _palette() -> Image.Image:
    """The colours that are drawn with, and what lies between them and what they are drawn on."""
    grounds = [FREE, OCCUPIED, UNKNOWN, PAPER]
    inks = [INK, PALE, TEAL, RED, AMBER, BLUE, BOX, *(colour for _, colour in MODES.values())]
    colours = [_rgb(colour) for colour in (*grounds, *inks)]
    for a, b in [(ink, on) for ink in inks for on in (FREE, PAPER)] + [
        (OCCUPIED, FREE), (OCCUPIED, UNKNOWN), (FREE, UNKNOWN), (TEAL, OCCUPIED), (RED, OCCUPIED),
    ]:  # fmt: skip
        one, other = np.array(_rgb(a)), np.array(_rgb(b))
        colours += [tuple(int(v) for v in one + k * (other - one)) for k in (0.25, 0.5, 0.75)]
    flat = [v for colour in dict.fromkeys(colours) for v in colour][: 3 * 256]
    palette = Image.new("P", (1, 1))
    palette.putpalette(flat)
    return palette


class _Canvas:
    """Where things of a story stand in a picture, and how they are drawn."""

    def __init__(self, story: Story, width_px: int) -> None:
        self.story = story
        x0, x1, y0, y1 = story.view
        tallest = 0.8 * width_px
        self.scale = SMOOTH * min(width_px / (x1 - x0), tallest / (y1 - y0))
        self.left, self.top = x0, y1
        width, height = (math.ceil(self.scale * side) for side in (x1 - x0, y1 - y0))
        self.map_size = (width, height)
        self.whole = (width + width % SMOOTH, height + height % SMOOTH + SMOOTH * BAR_PX)
        self.font = ImageFont.truetype(findfont(FontProperties()), 13 * SMOOTH)
        bold = FontProperties(weight="bold")
        self.bold = ImageFont.truetype(findfont(bold), 15 * SMOOTH)

    def at(self, point: Any) -> Point:
        """Pixel of a point of the world."""
        return (
            (float(point[0]) - self.left) * self.scale,
            (self.top - float(point[1])) * self.scale,
        )

    def ground(self) -> Image.Image:
        """The map, what it does not show, starts and goals."""
        story = self.story
        picture = Image.new("RGB", self.whole, UNKNOWN)
        if story.world is not None and story.world is not story.known:
            self._paste(picture, story.world, 0.45 if story.known is None else 0.35)
        if story.known is not None:
            self._paste(picture, story.known, 1.0)
        draw = ImageDraw.Draw(picture)
        for box in story.scenario.get("boxes", ()):
            pose = (box["x_m"], box["y_m"], box.get("yaw_rad", 0.0))
            corners = self._outline(pose, box["length_m"], box["width_m"])
            draw.polygon(corners, fill=BOX, outline=AMBER, width=SMOOTH)
        for robot in story.robots:
            self._disc(draw, robot.truth[0], 6, PAPER, INK)
            for goal in robot.goals:
                if goal.get("goal_m") is not None:
                    self._star(draw, goal["goal_m"])
        return picture

    def _paste(self, picture: Image.Image, world: World, strength: float) -> None:
        """Lay a map into the picture, turned as it stands in the world."""
        colours = np.array([_rgb(FREE), _rgb(OCCUPIED), _rgb(UNKNOWN)], float)
        colours = strength * colours + (1 - strength) * np.array(_rgb(UNKNOWN), float)
        cells = Image.fromarray(colours.astype(np.uint8)[np.asarray(world.occupancy)])
        x, y, yaw = world.origin
        c, s, r = math.cos(yaw), math.sin(yaw), world.resolution_m
        step = 1.0 / (self.scale * r)  # cells per pixel
        dx, dy = (self.left - x) / r, (self.top - y) / r
        where = (
            c * step, -s * step, c * dx + s * dy,
            -s * step, -c * step, -s * dx + c * dy,
        )  # fmt: skip
        laid = cells.transform(self.map_size, Image.Transform.AFFINE, where)
        there = Image.new("L", cells.size, 255)
        mask = there.transform(self.map_size, Image.Transform.AFFINE, where)
        picture.paste(laid, (0, 0), mask)

    def draw_plan(self, draw: ImageDraw.ImageDraw, robot: RobotStory, time_s: float) -> None:
        """Draw the plan of the moment, dashed."""
        plans = [points for begun, points in robot.plans if begun <= time_s and len(points) > 1]
        if not plans:
            return
        points = [self.at(point) for point in plans[-1]]
        dash, left, on = 7.0 * SMOOTH, 7.0 * SMOOTH, True
        for begin, end in itertools.pairwise(points):
            length, gone = math.dist(begin, end), 0.0
            while gone < length:
                step = min(left, length - gone)
                if on:
                    draw.line(
                        [_between(begin, end, gone / length),
                         _between(begin, end, (gone + step) / length)],
                        fill=BLUE, width=SMOOTH,
                    )  # fmt: skip
                gone, left = gone + step, left - step
                if left <= 1e-9:
                    on, left = not on, dash

    def draw_way(self, draw: ImageDraw.ImageDraw, robot: RobotStory, begin: int, end: int) -> None:
        """Draw the way driven from one tick to another, by mode."""
        for mode, ticks in robot.pieces():
            rows = robot.truth[max(ticks.start - 1, begin, 0) : min(ticks.stop, end + 1)]
            steps = np.hypot(*np.diff(rows[:, :2], axis=0).T)
            for part in np.split(rows, np.flatnonzero(steps > 0.3) + 1):
                if len(part) > 1:
                    way = [self.at(point) for point in part]
                    draw.line(way, fill=_mode(mode)[1], width=3 * SMOOTH, joint="curve")

    def draw_robot(self, draw: ImageDraw.ImageDraw, robot: RobotStory, tick: int) -> None:
        """Draw the outline where it is, its nose ahead, and what it has touched."""
        for contact in robot.contacts:
            if contact["time_s"] <= robot.time_s[tick] + 1e-9:
                self._disc(draw, robot.truth[robot.at(contact["time_s"])], 5, RED, PAPER)
        pose = robot.truth[tick]
        corners = self._outline(pose, *self.story.outline_m)
        draw.polygon(corners, fill=_mode(robot.mode[tick])[1], outline=PAPER, width=SMOOTH)
        nose = np.array([math.cos(pose[2]), math.sin(pose[2])]) * self.story.outline_m[0] / 2
        draw.line([self.at(pose), self.at(pose[:2] + nose)], fill=PAPER, width=2 * SMOOTH)

    def draw_echoes(self, draw: ImageDraw.ImageDraw, robot: RobotStory, tick: int) -> None:
        """Draw an arc where each sonar heard an echo."""
        if robot.echoes_m is None:
            return
        x, y, heading = robot.truth[tick]
        c, s = math.cos(heading), math.sin(heading)
        sonars = zip(self.story.sonars, robot.echoes_m[tick], strict=True)
        for (sx, sy, looks, beam), echo_m in sonars:
            if not math.isfinite(echo_m):
                continue
            u, v = self.at((x + c * sx - s * sy, y + s * sx + c * sy))
            r = self.scale * echo_m
            ends = (-math.degrees(heading + looks + side * beam / 2) for side in (1, -1))
            draw.arc((u - r, v - r, u + r, v + r), *ends, fill=BLUE, width=SMOOTH)

    def draw_bar(self, draw: ImageDraw.ImageDraw, time_s: float) -> None:
        """Say below the map what the first robot does, and why."""
        robot = self.story.robots[0]
        tick = robot.at(time_s)
        name, colour = _mode(robot.mode[tick])
        top, margin = self.map_size[1], 12 * SMOOTH
        draw.rectangle((0, top, *self.whole), fill=PAPER)
        draw.rectangle((0, top, 5 * SMOOTH, self.whole[1]), fill=colour)
        draw.text((margin, top + 8 * SMOOTH), name, font=self.bold, fill=colour)
        told = f"{time_s:.0f} s   {robot.command[tick, 0]:.2f} m/s"
        place = (self.whole[0] - margin, top + 9 * SMOOTH)
        draw.text(place, told, font=self.font, fill=PALE, anchor="ra")
        said = self._said(robot, tick)
        draw.text((margin, top + 35 * SMOOTH), said, font=self.font, fill=INK)

    def _said(self, robot: RobotStory, tick: int) -> str:
        """Why it is in this mode, as far as one line holds it."""
        changes = [t for t in robot.transitions if t["time_s"] <= robot.time_s[tick] + 1e-9]
        sentence = changes[-1]["sentence"] if changes else robot.sentence[tick]
        _, colon, why = sentence.partition(": ")
        words = (why if colon else sentence).rstrip(".").split()
        room = self.whole[0] - 24 * SMOOTH
        while words and self.font.getlength(" ".join(words) + " …") > room:
            words.pop()
        text = " ".join(words)
        whole = text == (why if colon else sentence).rstrip(".")
        return text if whole else text + " …"

    def _outline(self, pose: Any, length: float, width: float) -> list[Point]:
        x, y, heading = (float(v) for v in pose)
        half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length / 2, width / 2)
        c, s = math.cos(heading), math.sin(heading)
        return [self.at(corner) for corner in half @ np.array([[c, s], [-s, c]]) + (x, y)]

    def _disc(self, draw: Any, at: Any, radius: int, fill: str, edge: str) -> None:
        x, y = self.at(at)
        r = radius * SMOOTH
        draw.ellipse((x - r, y - r, x + r, y + r), fill=fill, outline=edge, width=2 * SMOOTH)

    def _star(self, draw: Any, at: Any) -> None:
        x, y = self.at(at)
        angles = -math.pi / 2 + np.arange(10) * math.pi / 5
        radii = np.where(np.arange(10) % 2, 4.6, 11.0) * SMOOTH
        points = np.stack([x + radii * np.cos(angles), y + radii * np.sin(angles)], axis=1)
        draw.polygon([tuple(point) for point in points], fill=TEAL, outline=PAPER)


def _between(begin: Point, end: Point, share: float) -> Point:
    return (begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1]))


def _mode(name: str) -> tuple[str, str]:
    return MODES.get(name, (name.replace("_", " ").capitalize(), INK))


def _rgb(colour: str) -> tuple[int, int, int]:
    return tuple(int(colour[n : n + 2], 16) for n in (1, 3, 5))  # type: ignore[return-value]
