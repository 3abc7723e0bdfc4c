"""Map files and worlds: `load` any of them, `save` as ROS map_server files.

Readable: ROS map_server (`.yaml` beside a PGM or PNG), MovingAI `.map` (with `.scen` queries),
ARIA `.map`, numpy `.npy`. The two kinds of `.map` are told apart by their first line.
"""

from pathlib import Path

from cairn import errors
from cairn.maps import aria, arrays, map_server, movingai
from cairn.maps.arrays import from_array
from cairn.maps.map_server import save
from cairn.maps.movingai import Query, load_scen
from cairn.maps.source import read_text, refuse
from cairn.world import World

__all__ = ["Query", "from_array", "load", "load_scen", "save", "shipped", "shipped_path"]

_WORLDS = Path(__file__).parent.parent / "data" / "worlds"
_READABLE = ".yaml or .yml (ROS map_server), .map (MovingAI or ARIA), .npy (numpy)"


def load(path: str | Path, *, resolution_m: float | None = None) -> World:
    """Read a world from a file.

    Args:
        path: a file, or the name of a world that comes with Cairn (`shipped()` lists them).
        resolution_m: side of a cell [m], for files that do not say it: MovingAI and numpy (1.0 if
            not given), ARIA (0.05).

    Raises:
        MapError: one subclass per cause, each naming the file, the line where there is one, and
            the reason.
    """
    path = Path(path)
    # Nothing without a suffix can be read: a file or folder of that name hides no shipped world.
    if str(path) in shipped():
        path = shipped_path(path.name)
    if not path.is_file():
        hint = f"; worlds that come with Cairn: {', '.join(shipped())}" if not path.suffix else ""
        refuse(errors.MapNotFound, path, f"no such file{hint}")
    match path.suffix.lower():
        case ".yaml" | ".yml":
            if resolution_m is not None:
                reason = "resolution_m was given, but a map_server file says its own"
                refuse(errors.MapKeyInvalid, path, reason, key="resolution", value=resolution_m)
            return map_server.load(path)
        case ".npy":
            return arrays.load(path, resolution_m=1.0 if resolution_m is None else resolution_m)
        case ".map":
            lines = read_text(path).splitlines()
            if not any(line.strip() for line in lines):
                refuse(errors.MapEmpty, path, "the file is empty")
            if lines[0].strip().startswith("2D-Map"):
                return aria.load(path, resolution_m=0.05 if resolution_m is None else resolution_m)
            if lines[0].split()[:1] == ["type"]:
                return movingai.load(
                    path, resolution_m=1.0 if resolution_m is None else resolution_m
                )
            reason = "neither `2D-Map` (ARIA) nor `type octile` (MovingAI)"
            refuse(errors.MapFormatUnknown, path, reason, line=1)
        case suffix:
            reason = f"cannot read `{suffix or path.name}`; readable are {_READABLE}"
            refuse(errors.MapFormatUnknown, path, reason)


def shipped() -> list[str]:
    """Names of the worlds that come with Cairn."""
    return sorted(p.stem for p in _WORLDS.iterdir() if p.suffix in (".yaml", ".map"))


def shipped_path(name: str) -> Path:
    """The file of a world that comes with Cairn.

    Raises:
        MapNotFound: there is none of that name.
    """
    for suffix in (".yaml", ".map"):
        if (path := _WORLDS / f"{name}{suffix}").is_file():
            return path
    refuse(errors.MapNotFound, Path(name), f"no such world; there are {', '.join(shipped())}")
