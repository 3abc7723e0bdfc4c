"""The benchmark's own world files: SDF of Gazebo, posts and walls as static models."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from cairn.experiments.nav import worlds
from cairn.experiments.nav.generator import GOAL, START, shortest_way
from cairn.experiments.nav.worlds import NavWorld, refuse

_CELL_M, _X_SHIFT_M, _Y_SHIFT_M = 0.15, -4.575, 5.075
"""From a cell of a BARN path to metres, as the challenge's `run.py` has it."""
_MOVES = re.compile(r"<plugin[^>]*\bfilename\s*=\s*['\"][^'\"]*libobs")


def load_gazebo(path: Path) -> NavWorld:
    """Read a .world file of BARN: start and goal are those of the challenge.

    The length for the score comes from `path_N.npy` beside the file or in `path_files` beside it;
    without that file, from the shortest way of a disc of 0.375 m, which is within a few per cent.

    Raises:
        NavWorldInvalid: not XML, no cylinder or box in it, no way through without a path file, or
            obstacles that move (DynaBARN), which the file does not describe.
    """
    try:
        text = path.read_text(encoding="utf-8")
        if _MOVES.search(text):
            refuse(
                path,
                "plugin",
                "its obstacles move by plugins compiled apart, and no key frame is in the file: "
                "such worlds are read as JSON",
            )
        root = ET.fromstring(text)
    except (OSError, UnicodeDecodeError, ET.ParseError) as error:
        refuse(path, "", str(error))
    circles: list[tuple[float, ...]] = []
    boxes: list[tuple[float, ...]] = []
    for model in root.iter("model"):
        pose = _numbers(path, model.findtext("pose") or "0 0 0 0 0 0", 6)
        for collision in model.iter("collision"):
            radius = collision.findtext("geometry/cylinder/radius")
            size = collision.findtext("geometry/box/size")
            if radius is not None:
                circles.append((pose[0], pose[1], *_numbers(path, radius, 1)))
            elif size is not None:
                length, width, _ = _numbers(path, size, 3)
                boxes.append((pose[0], pose[1], pose[5], length, width))
    if not circles and not boxes:
        refuse(path, "", "no cylinder or box in it")
    posts = np.asarray(circles, float).reshape(-1, 3)
    number = path.stem.rpartition("_")[2]
    way = _path_file(path, number)
    if way is None:
        way = shortest_way(posts)
        if way is None:
            refuse(path, "", f"no way through it, and no path_{number}.npy beside it")
    way = np.vstack([START[:2], way, GOAL])
    return worlds.checked(
        path,
        NavWorld(
            name=path.stem,
            circles=posts,
            boxes=np.asarray(boxes, float).reshape(-1, 5),
            start=START,
            goal=GOAL,
            path_length_m=float(np.hypot(*np.diff(way, axis=0).T).sum()),
            reference_path=way,
        ),
    )


def _path_file(path: Path, number: str) -> np.ndarray | None:
    for candidate in (path.parent, path.parent / "path_files", path.parent.parent / "path_files"):
        file = candidate / f"path_{number}.npy"
        if not file.is_file():
            continue
        try:
            cells = np.load(file, allow_pickle=False).astype(float)
        except (OSError, ValueError) as error:
            refuse(file, "", str(error))
        if cells.ndim != 2 or cells.shape[1] != 2 or not len(cells):
            refuse(file, "", f"an array of shape {cells.shape}, must be (n, 2) cells")
        return cells * _CELL_M + np.array([_X_SHIFT_M, _Y_SHIFT_M])
    return None


def _numbers(path: Path, text: str, count: int) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, text.split()))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        refuse(path, "", f"`{text.strip()}`: {count} finite numbers were expected")
    return numbers
