"""Draws the worlds that come with Cairn: `python examples/draw_worlds.py [FOLDER]`.

Metres, x right, y up. Walls and furniture are drawn on the grid's lines, so doors of 1.0 m are
1.0 m. Writes map_server files with their goals, and one ARIA map.
"""

import sys
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

import cairn
from cairn.world import FREE, OCCUPIED, UNKNOWN

WORLDS = Path(cairn.__file__).parent / "data" / "worlds"
RESOLUTION_M = 0.05


@dataclass
class Drawing:
    """A rectangle of floor, from `least` to `greatest` (x, y) [m], and what is put on it."""

    least: tuple[float, float]
    greatest: tuple[float, float]
    doors: dict[str, tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self):
        size = np.subtract(self.greatest, self.least) / RESOLUTION_M
        cols, rows = np.rint(size).astype(int)
        self.cells = np.full((rows, cols), FREE, np.uint8)
        self.x = self.least[0] + (np.arange(cols) + 0.5) * RESOLUTION_M
        self.y = (self.least[1] + (np.arange(rows) + 0.5) * RESOLUTION_M)[:, None]

    def box(self, x0, y0, x1, y1, kind=OCCUPIED):
        """Everything between two corners."""
        self.cells[(self.x > x0) & (self.x < x1) & (self.y > y0) & (self.y < y1)] = kind

    def disc(self, x, y, radius):
        """Something round."""
        self.cells[np.hypot(self.x - x, self.y - y) <= radius] = OCCUPIED

    def boxes(self, *boxes):
        for box in boxes:
            self.box(*box)

    def door_across_x(self, name, x, y0, y1):
        """A door of 1 m about x in a wall that runs along x, between y0 and y1."""
        self.box(x - 0.5, y0, x + 0.5, y1, FREE)
        self.doors[name] = (x, (y0 + y1) / 2, np.pi / 2)

    def door_across_y(self, name, y, x0, x1):
        """A door of 1 m about y in a wall that runs along y, between x0 and x1."""
        self.box(x0, y - 0.5, x1, y + 0.5, FREE)
        self.doors[name] = ((x0 + x1) / 2, y, 0.0)

    def save(self, name, goals, folder):
        x, y = (float(v) for v in self.least)
        world = cairn.World(self.cells, RESOLUTION_M, (x, y, 0.0), name=name, goals=goals)
        path = folder / f"{name}.yaml"
        cairn.maps.save(world, path)
        if self.doors:
            with path.with_suffix(".goals.toml").open("a", encoding="utf-8") as file:
                file.write(
                    "\n# Centres of the doors and a heading through them; all are 1 m wide.\n"
                )
                file.write("[doors]\n")
                for door, (x, y, heading) in self.doors.items():
                    place = f"x = {x:.3f}, y = {y:.3f}, heading = {heading:.6f}"
                    file.write(f'"{door}" = {{ {place} }}\n')


# ---- furniture -----------------------------------------------------------------------------------


def table_with_chairs(d, x, y, length, width, chairs):
    """A meeting table about (x, y) along x, chairs pushed in on both long sides."""
    d.box(x - length / 2, y - width / 2, x + length / 2, y + width / 2)
    for i in range(chairs):
        at = x - length / 2 + (i + 0.5) * length / chairs
        for side in (-1, 1):
            edge = y + side * (width / 2 + 0.05)
            d.box(at - 0.2, min(edge, edge + side * 0.35), at + 0.2, max(edge, edge + side * 0.35))


def round_table(d, x, y):
    """A café table with three chairs."""
    d.disc(x, y, 0.45)
    for angle in (0.5, 2.6, 4.7):
        d.disc(x + 0.68 * np.cos(angle), y + 0.68 * np.sin(angle), 0.22)


def desk_below(d, x, y):
    """A desk 1.6 × 0.8 with its far side at y, worked at from below."""
    d.box(x - 0.8, y - 0.8, x + 0.8, y)
    d.disc(x, y - 1.0, 0.25)


def desk_above(d, x, y):
    """A desk 1.6 × 0.8 with its far side at y, worked at from above."""
    d.box(x - 0.8, y, x + 0.8, y + 0.8)
    d.disc(x, y + 1.0, 0.25)


def desk_island(d, x, y):
    """Four desks face to face about (x, y), 3.2 × 1.6, with their chairs."""
    d.box(x - 1.6, y - 0.8, x + 1.6, y + 0.8)
    for side in (-1, 1):
        for along in (-0.8, 0.8):
            d.disc(x + along, y + side * 1.0, 0.25)


def plant(d, x, y):
    d.disc(x, y, 0.25)


# ---- the office ----------------------------------------------------------------------------------


def office(folder):
    """36 × 24 m: two corridors along the building, two across it, four fire doors, 17 rooms."""
    d = Drawing((-0.5, -0.5), (36.5, 24.5))
    d.cells[:] = UNKNOWN
    d.box(0.0, 0.0, 36.0, 24.0)
    d.box(0.2, 0.2, 35.8, 23.8, FREE)

    # South corridor y 6.10..8.10, north 15.90..17.70, west x 9.00..10.60, east x 25.40..27.40.
    d.boxes((0, 5.95, 36, 6.1), (0, 17.7, 36, 17.85))
    d.boxes((0, 8.1, 9.0, 8.25), (10.6, 8.1, 25.4, 8.25), (27.4, 8.1, 36, 8.25))
    d.boxes((0, 15.75, 9.0, 15.9), (10.6, 15.75, 25.4, 15.9), (27.4, 15.75, 36, 15.9))
    d.boxes((8.85, 8.1, 9.0, 15.9), (10.6, 8.1, 10.75, 15.9))
    d.boxes((25.25, 8.1, 25.4, 15.9), (27.4, 8.1, 27.55, 15.9))
    for name, y0, y1 in (("fire door south", 6.1, 8.1), ("fire door north", 15.9, 17.7)):
        d.box(18.0, y0, 18.15, y1)
        d.door_across_y(name, (y0 + y1) / 2, 18.0, 18.15)
    for name, x0, x1 in (("fire door west", 9.0, 10.6), ("fire door east", 25.4, 27.4)):
        d.box(x0, 12.0, x1, 12.15)
        d.door_across_x(name, (x0 + x1) / 2, 12.0, 12.15)

    office_south(d)
    office_middle(d)
    office_north(d)
    goals = {
        "reception": (6.5, 3.9, 1.5708),
        "meeting ash": (14.0, 4.9, 3.1416),
        "office 1": (17.3, 3.3, -1.5708),
        "office 2": (21.6, 3.3, -1.5708),
        "canteen": (25.0, 3.2, 0.0),
        "storage": (33.2, 4.8, -1.5708),
        "copy room": (6.4, 10.0, 3.1416),
        "office 3": (4.5, 14.4, 1.5708),
        "open plan": (14.7, 12.1, 0.0),
        "wc east": (23.7, 9.4, 1.5708),
        "wc west": (20.6, 9.4, 1.5708),
        "server room": (20.5, 14.3, 0.0),
        "lab": (29.0, 11.0, 0.0),
        "meeting birch": (5.0, 19.0, 1.5708),
        "office 4": (8.6, 20.6, 1.5708),
        "office 5": (12.7, 20.6, 1.5708),
        "lounge": (18.5, 19.2, 1.5708),
        "secretary": (23.5, 20.0, 0.0),
        "director": (28.5, 19.5, 0.0),
        "electronics": (33.0, 19.6, 1.5708),
        "corridor south west": (1.4, 7.1, 0.0),
        "corridor south east": (34.6, 7.1, 3.1416),
        "corridor north west": (1.4, 16.8, 0.0),
        "corridor north east": (34.6, 16.8, 3.1416),
    }
    d.save("office", goals, folder)


def office_south(d):
    for x in (9.0, 15.0, 19.4, 23.8, 30.5):
        d.box(x, 0, x + 0.15, 6.0)
    # Reception: the desk, sofas about a low table, pillars, plants.
    d.door_across_x("reception", 6.5, 5.95, 6.1)
    d.boxes((2.6, 3.8, 4.8, 4.4), (2.6, 4.4, 3.2, 5.0))
    d.disc(3.8, 4.75, 0.25)
    d.boxes((0.2, 0.6, 1.0, 2.6), (1.6, 0.2, 3.6, 1.0), (1.8, 1.5, 2.8, 2.1))
    d.boxes((5.6, 1.6, 6.0, 2.0), (7.6, 1.6, 8.0, 2.0))
    plant(d, 8.6, 5.5)
    plant(d, 0.6, 5.5)
    plant(d, 4.6, 0.6)
    # Meeting room Ash: a long table, a sideboard, a screen.
    d.door_across_x("meeting ash", 13.8, 5.95, 6.1)
    table_with_chairs(d, 11.9, 2.9, 3.0, 1.2, 4)
    d.boxes((9.15, 5.5, 11.4, 5.95), (14.85, 1.8, 15.0, 4.0))
    plant(d, 9.5, 0.6)
    # Offices 1 and 2: desks at the windows, cupboards.
    for i, x in enumerate((15.15, 19.55)):
        d.door_across_x(f"office {i + 1}", (16.2, 20.6)[i], 5.95, 6.1)
        desk_above(d, x + 0.95, 0.2)
        desk_above(d, x + 3.3, 0.2)
        d.boxes((x + 2.4, 5.5, x + 4.25, 5.95), (x, 2.6, x + 0.45, 4.2))
    # Canteen: a kitchen along the wall, round tables, a pillar.
    d.door_across_x("canteen", 25.0, 5.95, 6.1)
    d.boxes((25.8, 0.2, 30.5, 0.85), (29.85, 0.85, 30.5, 2.2), (26.4, 5.5, 28.4, 5.95))
    round_table(d, 27.0, 3.4)
    round_table(d, 29.4, 4.4)
    d.boxes((23.95, 0.2, 24.7, 0.9))
    # Storage: shelves in rows.
    d.door_across_x("storage", 33.2, 5.95, 6.1)
    d.boxes((30.65, 1.2, 31.15, 5.2), (32.3, 0.2, 32.8, 3.6), (33.9, 0.2, 34.3, 3.6))
    d.box(35.4, 1.2, 35.8, 5.2)


def office_middle(d):
    d.boxes((0, 11.9, 9.0, 12.05), (19.0, 8.1, 19.15, 15.9), (19.0, 11.9, 25.4, 12.05))
    d.box(22.1, 8.1, 22.25, 12.0)
    # Copy room: machines along the wall, a table to sort on, paper.
    d.door_across_y("copy room", 10.0, 8.85, 9.0)
    d.boxes((0.8, 11.1, 2.0, 11.9), (2.6, 11.1, 3.8, 11.9), (4.4, 11.2, 6.6, 11.9))
    d.boxes((2.2, 9.3, 4.6, 10.2), (0.2, 8.25, 0.7, 10.2), (5.6, 8.25, 7.8, 8.7))
    # Office 3: three desks, shelves.
    d.door_across_x("office 3", 6.9, 15.75, 15.9)
    for x in (1.4, 4.2, 7.0):
        desk_above(d, x, 12.05)
    d.boxes((0.2, 14.2, 0.65, 15.75), (2.2, 15.3, 5.0, 15.75))
    plant(d, 8.45, 15.35)
    # Open plan: islands of desks about two pillars, a door to each of three corridors.
    d.door_across_x("open plan south", 14.7, 8.1, 8.25)
    d.door_across_x("open plan north", 14.7, 15.75, 15.9)
    d.door_across_y("open plan west", 10.7, 10.6, 10.75)
    desk_island(d, 12.35, 13.4)
    desk_island(d, 17.4, 13.4)
    desk_island(d, 17.4, 10.2)
    d.boxes((12.0, 9.2, 12.4, 9.6), (10.75, 15.3, 13.2, 15.75), (12.4, 8.25, 13.6, 8.7))
    plant(d, 18.65, 15.4)
    plant(d, 11.1, 8.6)
    # WCs: basins beside the door, cabins behind.
    for i, x in enumerate((19.15, 22.25)):
        d.door_across_x(("wc west", "wc east")[i], (20.6, 23.7)[i], 8.1, 8.25)
        end = (22.1, 25.25)[i]
        d.boxes((x, 8.9, x + 0.5, 10.0), (x, 10.4, end, 11.9))
    # Server room: two rows of racks, cooling.
    d.door_across_x("server room", 20.5, 15.75, 15.9)
    d.boxes((21.7, 12.05, 24.1, 12.85), (21.7, 14.2, 24.1, 15.0), (19.15, 12.05, 19.85, 13.2))
    # Lab: benches, a fume cupboard, two doors.
    d.door_across_y("lab west", 10.0, 27.4, 27.55)
    d.door_across_x("lab north", 34.0, 15.75, 15.9)
    d.boxes((30.2, 9.8, 32.4, 10.9), (30.2, 12.6, 32.4, 13.7), (29.0, 8.25, 34.6, 8.9))
    d.boxes((35.1, 9.6, 35.8, 13.4), (27.55, 14.9, 31.2, 15.75), (27.55, 12.4, 28.2, 14.4))
    d.disc(31.3, 11.15, 0.22)
    d.disc(30.8, 12.3, 0.22)
    d.disc(31.9, 12.3, 0.22)


def office_north(d):
    for x in (6.0, 10.4, 14.8, 22.0, 27.0, 31.0):
        d.box(x, 17.8, x + 0.15, 24)
    # Meeting room Birch.
    d.door_across_x("meeting birch", 5.0, 17.7, 17.85)
    table_with_chairs(d, 2.9, 21.3, 2.6, 1.2, 3)
    d.boxes((0.2, 17.85, 2.4, 18.3), (0.2, 20.2, 0.35, 22.4))
    plant(d, 5.6, 23.4)
    # Offices 4 and 5.
    for i, x in enumerate((6.15, 10.55)):
        d.door_across_x(f"office {i + 4}", (7.3, 11.7)[i], 17.7, 17.85)
        desk_below(d, x + 0.95, 23.8)
        desk_below(d, x + 3.3, 23.8)
        d.boxes((x + 2.4, 17.85, x + 4.25, 18.3), (x, 19.6, x + 0.45, 21.2))
    # Lounge: sofas about tables, book shelves, a pillar; two doors.
    d.door_across_x("lounge west", 16.2, 17.7, 17.85)
    d.door_across_x("lounge east", 20.8, 17.7, 17.85)
    d.boxes((14.95, 20.2, 15.4, 23.4), (17.4, 23.0, 19.6, 23.8), (16.6, 21.2, 17.4, 22.6))
    d.boxes((18.0, 21.6, 19.2, 22.2), (18.3, 20.1, 18.7, 20.5), (21.2, 20.0, 22.0, 22.2))
    plant(d, 21.6, 23.4)
    plant(d, 15.4, 18.3)
    # The secretary's room, and through it the director's.
    d.door_across_x("secretary", 23.5, 17.7, 17.85)
    desk_below(d, 24.8, 23.0)
    d.boxes((22.15, 21.6, 22.6, 23.8), (25.2, 17.85, 27.0, 18.3), (24.0, 23.35, 25.6, 23.8))
    d.door_across_y("director", 20.0, 27.0, 27.15)
    d.boxes((28.4, 21.6, 30.2, 22.5), (27.15, 23.3, 31.0, 23.8), (30.5, 17.85, 31.0, 20.2))
    d.disc(29.3, 22.75, 0.28)
    plant(d, 27.55, 18.3)
    # Electronics: benches along the walls, an island.
    d.door_across_x("electronics", 33.0, 17.7, 17.85)
    d.boxes((31.15, 19.4, 31.85, 23.8), (35.1, 18.6, 35.8, 23.8), (33.1, 21.2, 33.9, 22.6))


# ---- smaller worlds ------------------------------------------------------------------------------


def walled(width, height):
    """An empty room with walls of 0.15 m about (0, 0) .. (width, height)."""
    d = Drawing((-0.15, -0.15), (width + 0.15, height + 0.15))
    d.cells[:] = OCCUPIED
    d.box(0, 0, width, height, FREE)
    return d


def room(folder):
    """8 × 6 m with a few boxes: for quick tests."""
    d = walled(8, 6)
    d.boxes((3.0, 0.0, 3.4, 2.4), (4.6, 3.6, 5.0, 6.0), (6.2, 1.4, 7.0, 2.2))
    d.disc(1.6, 4.4, 0.3)
    goals = {
        "start": (1.0, 1.0, 0.0),
        "middle": (4.0, 3.0),
        "goal": (7.0, 5.0),
        "corner": (7.2, 0.7),
        "north west": (0.8, 5.3),
    }
    d.save("room", goals, folder)


def hall(folder):
    """12 × 12 m with nothing in it."""
    goals = {
        "centre": (6.0, 6.0, 0.0),
        "south west": (1.5, 1.5, 0.7854),
        "south east": (10.5, 1.5, 2.3562),
        "north east": (10.5, 10.5, -2.3562),
        "north west": (1.5, 10.5, -0.7854),
    }
    walled(12, 12).save("hall", goals, folder)


def dead_end(folder):
    """14 × 10 m: between start and goal a bay that opens towards the start."""
    d = walled(14, 10)
    d.boxes((5.5, 2.6, 9.2, 2.8), (5.5, 7.0, 9.2, 7.2), (9.0, 2.6, 9.2, 7.2))
    d.boxes((11.2, 0.0, 11.5, 1.6), (2.6, 8.4, 3.4, 9.2))
    goals = {
        "start": (2.0, 4.9, 0.0),
        "bay": (7.6, 4.9, 0.0),
        "goal": (12.2, 4.9, 0.0),
        "south": (7.0, 1.2, 0.0),
        "north": (7.0, 8.6, 0.0),
    }
    d.save("dead_end", goals, folder)


def labyrinth(folder):
    """15 × 15 m, passages of 1.5 m, one way and no other between any two places."""
    n, pitch, wall = 9, 1.65, 0.15
    d = walled(n * pitch - wall, n * pitch - wall)
    d.box(0, 0, n * pitch - wall, n * pitch - wall)

    def corner(cell):
        return cell[0] * pitch, cell[1] * pitch

    # A depth-first walk that carves passages, its choices from a small generator of its own.
    state = 206

    def pick(count):
        nonlocal state
        state = (1103515245 * state + 12345) % 2**31
        return (state >> 16) % count

    seen, trail = {(0, 0)}, [(0, 0)]
    while trail:
        i, j = trail[-1]
        x, y = corner((i, j))
        d.box(x, y, x + pitch - wall, y + pitch - wall, FREE)
        ways = [(i + 1, j), (i, j + 1), (i - 1, j), (i, j - 1)]
        ways = [(a, b) for a, b in ways if 0 <= a < n and 0 <= b < n and (a, b) not in seen]
        if not ways:
            trail.pop()
            continue
        there = ways[pick(len(ways))]
        seen.add(there)
        trail.append(there)
        (x0, y0), (x1, y1) = corner(min((i, j), there)), corner(max((i, j), there))
        d.box(x0, y0, x1 + pitch - wall, y1 + pitch - wall, FREE)

    def middle(i, j):
        return i * pitch + 0.75, j * pitch + 0.75

    goals = {
        "start": (*middle(0, 0), np.pi / 2),
        "goal": middle(n - 1, n - 1),
        "north west": middle(0, n - 1),
        "south east": middle(n - 1, 0),
        "heart": middle(n // 2, n // 2),
    }
    goals = {name: tuple(round(float(v), 4) for v in place) for name, place in goals.items()}
    d.save("labyrinth", goals, folder)


def warehouse(folder):
    """20 × 14 m in ARIA's format: racks, aisles of 2 m, an office, forbidden stairs."""
    lines = []

    def chain(*corners):
        lines.extend((*a, *b) for a, b in pairwise(corners))

    chain((0, 0), (20, 0), (20, 14), (0, 14), (0, 0))
    for x in (4.0, 7.0, 10.0, 13.0):
        for y0, y1 in ((2.8, 6.0), (7.6, 10.8)):
            chain((x, y0), (x + 1, y0), (x + 1, y1), (x, y1), (x, y0))
    chain((16.5, 0), (16.5, 1.45))  # the office, door in its west wall
    chain((16.5, 2.55), (16.5, 4.5), (20, 4.5))
    chain((18.6, 0), (18.6, 0.8), (20, 0.8))
    chain((0, 12.6), (1.2, 12.6), (1.2, 14))
    chain((15.4, 14), (15.4, 12.2), (15.6, 12.2), (15.6, 14))  # loading bays
    chain((17.6, 14), (17.6, 12.2), (17.8, 12.2), (17.8, 14))
    angles = np.arange(0, 2 * np.pi, 0.1)
    points = [(17.0 + 0.25 * np.cos(a), 8.0 + 0.25 * np.sin(a)) for a in angles]
    goals = [
        ("GoalWithHeading", 2.0, 7.0, 0.0, "gate"),
        ("Goal", 6.0, 4.4, 0.0, "aisle 1"),
        ("Goal", 9.0, 9.2, 0.0, "aisle 2"),
        ("Goal", 12.0, 4.4, 0.0, "aisle 3"),
        ("GoalWithHeading", 16.5, 12.9, 90.0, "bay 1"),
        ("GoalWithHeading", 18.8, 12.9, 90.0, "bay 2"),
        ("Goal", 18.0, 2.4, 0.0, "office"),
        ("RobotHome", 1.2, 1.2, 0.0, "home"),
    ]

    def mm(*values):
        return " ".join(f"{round(v * 1000)}" for v in values)

    def bounds(prefix, corners):
        (x0, y0), (x1, y1) = np.min(corners, axis=0), np.max(corners, axis=0)
        return [f"{prefix}MinPos: {mm(x0, y0)}", f"{prefix}MaxPos: {mm(x1, y1)}"]

    text = ["2D-Map"]
    text += bounds("Line", [line[:2] for line in lines] + [line[2:] for line in lines])
    text += [f"NumLines: {len(lines)}", *bounds("", points), f"NumPoints: {len(points)}"]
    text += ["PointsAreSorted: false", "LinesAreSorted: false", "Resolution: 20"]
    for kind, x, y, degrees, name in goals:
        text.append(f'Cairn: {kind} {mm(x, y)} {degrees:.6f} "" ICON "{name}"')
    text.append(f'Cairn: ForbiddenArea 0 0 0.000000 "" ICON "stairs" {mm(18.6, 6.4, 20.0, 9.6)}')
    text.append(f'Cairn: ForbiddenLine 0 0 0.000000 "" ICON "ramp" {mm(0.0, 10.8, 1.2, 10.8)}')
    text += ["LINES", *(mm(*line) for line in lines), "DATA", *(mm(*p) for p in points)]
    (folder / "warehouse.map").write_text("\n".join(text) + "\n", encoding="utf-8")


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else WORLDS
    folder.mkdir(parents=True, exist_ok=True)
    for draw in (office, room, hall, dead_end, labyrinth, warehouse):
        draw(folder)


if __name__ == "__main__":
    main()
