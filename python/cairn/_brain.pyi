"""Types of the compiled brain; the public names are re-exported by `cairn`."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

__version__: str

class Profile:
    """A robot profile, checked: outline, limits, wheels and sensors."""

    def __new__(cls, text: str) -> Self:
        """Read a profile from TOML text."""

    @staticmethod
    def from_toml(text: str) -> Profile:
        """Read a profile from TOML text."""

    def to_dict(self) -> dict[str, Any]:
        """Return the profile as plain dicts and lists, keyed as in the file."""

# ---- grids and cost maps -------------------------------------------------------------------------

def distance_to_occupied(
    occupied: NDArray[np.bool_], resolution_m: float, *, surface: bool
) -> NDArray[np.float32]:
    """Distance from cell centres to the nearest occupied cell's centre, or surface [m]."""

def costmap(
    occupancy: NDArray[np.uint8],
    resolution_m: float,
    footprint: tuple[float, float],
    config: dict[str, Any],
    ground: NDArray[np.float32] | None,
    layers: list[tuple[str, NDArray[np.float32], float]],
) -> NDArray[np.float32]:
    """Cost per metre of every cell for a robot of this outline, inf blocked."""
