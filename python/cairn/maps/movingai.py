"""MovingAI grid maps and their queries [Sturtevant12].

`.`, `G` and `S` (swamp, passable from ordinary ground) are free; `@`, `O`, `T` (trees) and `W`
(water, which nothing can enter from the ground) are blocked. Cells of 1 m; row = the file's y.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cairn import errors
from cairn.maps.source import numbers, read_text, refuse, whole
from cairn.world import FREE, OCCUPIED, Cell, World

_KINDS = {".": FREE, "G": FREE, "S": FREE, "@": OCCUPIED, "O": OCCUPIED, "T": OCCUPIED}
_KINDS["W"] = OCCUPIED


@dataclass(frozen=True)
class Query:
    """One line of a `.scen` file."""

    bucket: int
    map_name: str
    shape: tuple[int, int]
    """(rows, cols) of the map that it is meant for."""
    start: Cell
    goal: Cell
    optimal_length: float
    """Octile length of the shortest path without corner cutting, in cells."""


def load(path: str | Path, *, resolution_m: float = 1.0) -> World:
    """Read a MovingAI `.map`.

    Raises:
        MapError: one subclass per cause.
    """
    path = Path(path)
    lines = read_text(path).splitlines()
    found: dict[str, int] = {}
    body = None
    for number, line in enumerate(lines, start=1):
        words = line.split()
        match words:
            case ["type", kind]:
                if kind != "octile":
                    reason = f"type is `{kind}`, must be octile"
                    refuse(errors.MapKeyInvalid, path, reason, line=number, key="type", value=kind)
                found["type"] = 0
            case ["height" | "width" as key, value]:
                found[key] = whole(path, number, key, value)
            case ["map"]:
                body = number
                break
            case []:
                continue
            case _:
                reason = f"`{line.strip()}` is not type, height, width or map"
                refuse(errors.MapLineInvalid, path, reason, line=number)
    for key in ("type", "height", "width"):
        if key not in found:
            refuse(errors.MapKeyMissing, path, f"key `{key}` is missing", key=key)
    if body is None:
        refuse(errors.MapKeyMissing, path, "the line `map` is missing", key="map")
    rows, cols = found["height"], found["width"]
    if rows * cols == 0:
        refuse(errors.MapEmpty, path, f"the map is {rows} × {cols} cells")

    cells = lines[body:]
    while len(cells) > rows and not cells[-1].strip():
        cells.pop()
    if len(cells) < rows:
        reason = f"the file ends after {len(cells)} of {rows} rows"
        refuse(errors.MapTruncated, path, reason, line=len(lines))
    if len(cells) > rows:
        reason = f"a row too many: the height is {rows}"
        refuse(
            errors.MapCountMismatch,
            path,
            reason,
            line=body + rows + 1,
            expected=rows,
            found=len(cells),
        )
    for row, line in enumerate(cells):
        if len(line) != cols:
            reason = f"the row has {len(line)} characters, the width is {cols}"
            at = body + row + 1
            refuse(errors.MapCountMismatch, path, reason, line=at, expected=cols, found=len(line))
    occupancy = np.empty((rows, cols), np.uint8)
    for row, line in enumerate(cells):
        try:
            occupancy[row] = [_KINDS[character] for character in line]
        except KeyError as error:
            character = error.args[0]
            col = line.index(character) + 1
            reason = f"`{character}` in column {col} is none of {' '.join(_KINDS)}"
            refuse(
                errors.MapCharacterInvalid,
                path,
                reason,
                line=body + row + 1,
                column=col,
                character=character,
            )
    return World(occupancy, resolution_m, name=path.stem)


def load_scen(path: str | Path) -> list[Query]:
    """Read a `.scen` file of version 1.

    Raises:
        MapError: one subclass per cause.
    """
    path = Path(path)
    lines = read_text(path).splitlines()
    if not lines:
        refuse(errors.MapEmpty, path, "the file is empty")
    if lines[0].split() not in (["version", "1"], ["version", "1.0"]):
        reason = f"begins with `{lines[0].strip()}`, must be `version 1`"
        value = lines[0].strip()
        refuse(errors.MapKeyInvalid, path, reason, line=1, key="version", value=value)
    return [_query(path, i, line) for i, line in enumerate(lines[1:], start=2) if line.strip()]


def _query(path: Path, number: int, line: str) -> Query:
    words = line.strip().split("\t") if "\t" in line else line.split()
    if len(words) != 9:
        reason = f"{len(words)} fields, must be 9: bucket map width height x y x y length"
        refuse(errors.MapLineInvalid, path, reason, line=number)
    bucket = whole(path, number, "bucket", words[0])
    keys = ("width", "height", "start x", "start y", "goal x", "goal y")
    width, height, sx, sy, gx, gy = (
        whole(path, number, key, word) for key, word in zip(keys, words[2:8], strict=True)
    )
    (length,) = numbers(path, number, words[8], 1, "an optimal length")
    for key, value, size in (
        ("start x", sx, width),
        ("start y", sy, height),
        ("goal x", gx, width),
        ("goal y", gy, height),
    ):
        if value >= size:
            reason = f"{key} is {value}, outside a map of {width} × {height}"
            refuse(errors.MapKeyInvalid, path, reason, line=number, key=key, value=value)
    if length < 0:
        refuse(errors.MapLineInvalid, path, f"the length is {length:g}", line=number)
    return Query(bucket, words[1], (height, width), (sy, sx), (gy, gx), length)
