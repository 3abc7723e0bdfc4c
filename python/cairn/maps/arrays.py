"""Worlds from numpy arrays and `.npy` files."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cairn import errors
from cairn.maps.source import refuse
from cairn.world import FREE, OCCUPIED, World


def from_array(array: ArrayLike, resolution_m: float = 1.0, **fields: Any) -> World:
    """Make a world of a 2-D array [row, col], row 0 the lowest y.

    Args:
        array: bool: True free. Float: cost per metre > 0, inf blocked. Integer: 0 free,
            1 occupied, 2 unknown.
        resolution_m: side of a cell [m].
        fields: `origin`, `name`, `goals`, as of `World`.

    Raises:
        WorldShapeInvalid, WorldCellInvalid, WorldValueOutOfRange: as `World` does.
    """
    array = np.asarray(array)
    if array.dtype.kind != "f":
        return World(array, resolution_m, **fields)
    occupancy = np.where(np.isinf(array), np.uint8(OCCUPIED), np.uint8(FREE))
    return World(occupancy, resolution_m, costs=array, **fields)


def load(path: str | Path, *, resolution_m: float = 1.0) -> World:
    """Read a `.npy` file as `from_array` would.

    Raises:
        MapLineInvalid: not such a file, or the array is none that a world can be made of.
        MapEmpty: the array has no element.
    """
    path = Path(path)
    array = _read(path, "bool, integer or float", "biuf")
    try:
        return from_array(array, resolution_m, name=path.stem)
    except errors.WorldCellInvalid as error:
        refuse(errors.MapLineInvalid, path, str(error))


def load_elevation(path: str | Path) -> NDArray[Any]:
    """Read heights [m] (rows, cols) from a `.npy` file; row 0 the lowest y, NaN no data.

    Raises:
        MapNotFound: there is no such file.
        MapLineInvalid: not such a file, or no array of two dimensions of integers or floats.
        MapEmpty: the array has no element.
    """
    path = Path(path)
    if not path.is_file():
        refuse(errors.MapNotFound, path, "no such file")
    return _read(path, "integer or float", "iuf")


def _read(path: Path, kinds: str, letters: str) -> NDArray[Any]:
    try:
        array = np.load(path, allow_pickle=False)
    except Exception as error:  # numpy lets whatever its parsers raise through
        refuse(errors.MapLineInvalid, path, f"not a numpy array: {error}")
    if not isinstance(array, np.ndarray) or array.dtype.kind not in letters or array.ndim != 2:
        kind = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else type(array)
        reason = f"holds {kind}, must be a {kinds} array (rows, cols)"
        refuse(errors.MapLineInvalid, path, reason)
    if array.size == 0:
        refuse(errors.MapEmpty, path, f"the array is {array.shape[0]} × {array.shape[1]}")
    return array
