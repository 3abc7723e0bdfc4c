"""ROS map_server: a YAML file beside an image.

With x a pixel's shade in 0..1 (0 black; the mean of its colours), p = 1 − x, or x when `negate`:

- trinary (default): p > occupied_thresh is occupied, p < free_thresh free, all else unknown;
- scale: the same ends; in between, the occupancy is 99·(p − free_thresh)/(occupied_thresh −
  free_thresh) percent; a pixel that is not opaque is unknown;
- raw: the shade in 0..255 is the occupancy in percent, above 100 unknown.

An occupancy of q percent between 0 and 100 is kept as a free cell whose metre costs 1/(1 − q/100).
The image's first row is the highest y; `load` turns it, so that row 0 is the lowest. Transparency
counts in scale mode alone. Keys that map_server does not know are left to others, as it does.
"""

import json
import re
import sys
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from cairn import errors
from cairn.maps.pgm import read_pgm
from cairn.maps.source import read_text, refuse
from cairn.world import FREE, OCCUPIED, UNKNOWN, Place, World

_SHADES = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}


def load(path: str | Path) -> World:
    """Read a map_server YAML file, its image, and `<name>.goals.toml` beside it if there is one.

    Raises:
        MapError: one subclass per cause.
    """
    path = Path(path)
    header = _Header(path)
    image = path.parent / header.text("image")
    resolution_m = header.number("resolution", least=0.0)
    origin = header.origin()
    negate = header.flag("negate")
    occupied = header.number("occupied_thresh", least=0.0)
    free = header.number("free_thresh", least=0.0)
    if occupied > 1.0:
        header.refuse("occupied_thresh", "must be at most 1: no cell could be occupied")
    if free > occupied:
        header.refuse("free_thresh", f"greater than occupied_thresh, {occupied:g}")
    mode = header.text("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        header.refuse("mode", "not trinary, scale or raw")

    shade, opaque = _shades(path, header.line("image"), image)
    shade, opaque = shade[::-1], opaque[::-1]
    p = shade if negate else 1.0 - shade
    if mode == "raw":
        percent = np.rint((1.0 - shade if negate else shade) * 255.0)
        known = percent <= 100
    else:
        known = (p > occupied) | (p < free) | ((mode == "scale") & opaque)
        span = max(occupied - free, np.finfo(float).tiny)
        percent = np.clip(99.0 * (p - free) / span, 0.0, 99.0)
        percent = np.where(p > occupied, 100, np.where(p < free, 0, percent))
        if mode == "scale":
            known &= opaque
    occupancy = np.where(percent == 100, OCCUPIED, FREE)
    occupancy = np.where(known, occupancy, UNKNOWN).astype(np.uint8)
    between = known & (percent > 0) & (percent < 100)
    costs = None
    if between.any():
        costs = np.where(between, 1.0 / (1.0 - np.where(between, percent, 0) / 100.0), 1.0)
        costs = costs.astype(np.float32)
    return World(
        occupancy,
        resolution_m,
        origin,
        costs=costs,
        name=path.stem,
        goals=load_goals(path.with_suffix(".goals.toml")),
    )


def save(world: World, path: str | Path) -> None:
    """Write a world as map_server files: `path` (.yaml), a PNG, and its goals if it has any.

    `load` gives back the same occupancy, resolution, origin and goals, to the bit.

    Raises:
        MapFormatUnknown: `path` does not end in .yaml.
        MapNotRepresentable: the world has costs; drop them with `dataclasses.replace`.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml"):
        refuse(errors.MapFormatUnknown, path, "can write .yaml (ROS map_server) alone")
    if world.costs is not None:
        refuse(errors.MapNotRepresentable, path, "map_server files hold no costs per metre")
    shades = np.array([_SHADES[kind] for kind in (FREE, OCCUPIED, UNKNOWN)], np.uint8)
    image = path.with_suffix(".png")
    Image.fromarray(shades[world.occupancy][::-1]).save(image, optimize=True)
    usual = re.fullmatch(r"\w[\w.-]*", image.name)
    plain = image.name if usual else json.dumps(image.name, ensure_ascii=False)
    x, y, yaw = world.origin
    path.write_text(
        f"image: {plain}\n"
        "mode: trinary\n"
        f"resolution: {world.resolution_m!r}\n"
        f"origin: [{x!r}, {y!r}, {yaw!r}]\n"
        "negate: 0\n"
        "occupied_thresh: 0.65\n"
        "free_thresh: 0.196\n",
        encoding="utf-8",
    )
    if world.goals:
        table = "".join(_goal_line(name, place) for name, place in world.goals.items())
        path.with_suffix(".goals.toml").write_text(f"[goals]\n{table}", encoding="utf-8")


def load_goals(path: Path) -> dict[str, Place]:
    """Read the table `[goals]`, name = {x, y[, heading]} in metres and radians; {} without a file.

    Raises:
        MapLineInvalid: not TOML, or a goal is not such a table.
    """
    if not path.is_file():
        return {}
    text = read_text(path)
    try:
        table = tomllib.loads(text).get("goals", {})
    except (ValueError, RecursionError) as error:
        refuse(errors.MapLineInvalid, path, f"not TOML: {error}")
    if not isinstance(table, dict):
        refuse(errors.MapLineInvalid, path, f"goals is {table!r}, must be a table")
    goals: dict[str, Place] = {}
    for name, at in table.items():
        usual = isinstance(at, dict) and {"x", "y"} <= at.keys() <= {"x", "y", "heading"}
        if not usual or not all(_is_number(v) for v in at.values()):
            reason = f"goal `{name}` is {at!r}, must be {{ x, y }} or {{ x, y, heading }}, finite"
            refuse(errors.MapLineInvalid, path, reason)
        place = (float(at["x"]), float(at["y"]))
        goals[name] = (*place, float(at["heading"])) if "heading" in at else place
    return goals


def _goal_line(name: str, place: Place) -> str:
    quoted = json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f")
    values = zip(("x", "y", "heading"), place, strict=False)
    return f"{quoted} = {{ {', '.join(f'{key} = {value!r}' for key, value in values)} }}\n"


def _is_number(value: Any) -> bool:
    usual = isinstance(value, (int, float)) and not isinstance(value, bool)
    return usual and abs(value) <= sys.float_info.max


class _Header:
    """The YAML mapping, with the line of every key."""

    def __init__(self, path: Path) -> None:
        self.path = path
        text = read_text(path)
        try:
            node = yaml.compose(text, Loader=yaml.SafeLoader)
            values = yaml.safe_load(text)
        except (yaml.YAMLError, ValueError, RecursionError) as error:  # ValueError: such as dates
            mark = getattr(error, "problem_mark", None)
            line = None if mark is None else mark.line + 1
            reason = getattr(error, "problem", None) or str(error)
            refuse(errors.MapYamlInvalid, path, f"not YAML: {reason}", line=line)
        if node is None:
            refuse(errors.MapEmpty, path, "the file is empty")
        if not isinstance(node, yaml.MappingNode) or not isinstance(values, dict):
            refuse(errors.MapYamlInvalid, path, "must be keys and values (`image: map.pgm` ...)")
        self.values = values
        self.lines = {key.value: key.start_mark.line + 1 for key, _ in node.value}

    def line(self, key: str) -> int | None:
        return self.lines.get(key)

    def refuse(self, key: str, rule: str) -> Any:
        value = self.values[key]
        reason = f"{key} is {value!r}, {rule}"
        refuse(errors.MapKeyInvalid, self.path, reason, line=self.line(key), key=key, value=value)

    def get(self, key: str) -> Any:
        if key not in self.values:
            refuse(errors.MapKeyMissing, self.path, f"key `{key}` is missing", key=key)
        return self.values[key]

    def text(self, key: str, otherwise: str | None = None) -> str:
        if otherwise is not None and key not in self.values:
            return otherwise
        value = self.get(key)
        if not isinstance(value, str) or not value:
            self.refuse(key, "must be text")
        return value

    def number(self, key: str, least: float) -> float:
        value = _as_number(self.get(key))
        if value is None or value <= least:
            self.refuse(key, f"must be a finite number greater than {least:g}")
        return float(value)  # pyright: ignore[reportArgumentType]

    def flag(self, key: str) -> bool:
        if self.get(key) not in (0, 1):
            self.refuse(key, "must be 0 or 1")
        return bool(self.values[key])

    def origin(self) -> tuple[float, float, float]:
        given = self.get("origin")
        values = [_as_number(v) for v in given] if isinstance(given, list) else []
        if len(values) != 3 or None in values:
            self.refuse("origin", "must be [x, y, yaw], finite numbers")
        x, y, yaw = values
        return x, y, yaw  # pyright: ignore[reportReturnType]


def _as_number(value: Any) -> float | None:
    """YAML 1.1 reads `5e-2` as text; map files in the wild hold such numbers."""
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            return None
    return float(value) if _is_number(value) else None


def _shades(
    path: Path, line: int | None, image: Path
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Shade 0..1 and opacity of every pixel, rows as in the image."""
    if not image.is_file():
        reason = f"image {image} is not there"
        refuse(errors.MapImageMissing, path, reason, line=line, image=str(image))
    with image.open("rb") as file:
        magic = file.read(2)
    if magic in (b"P2", b"P5"):
        shade = read_pgm(image)
        return shade, np.ones(shade.shape, bool)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(image)
        with picture:
            picture.load()
            if picture.mode.startswith("I"):  # 16-bit grey
                shade = np.asarray(picture, np.float64) / 65535.0
                return shade, np.ones(shade.shape, bool)
            pixels = np.asarray(picture.convert("RGBA"), np.float64)
    except Exception as error:  # Pillow lets whatever its decoders raise through
        if "truncated" in str(error):
            reason = f"image ends before its last pixel: {error}"
            refuse(errors.MapImageTruncated, image, reason, image=str(image))
        reason = f"cannot be read as an image: {error}"
        refuse(errors.MapImageInvalid, image, reason, image=str(image))
    return pixels[..., :3].mean(axis=-1) / 255.0, pixels[..., 3] == 255
