"""The one ROS 2 message that is read back here: a map. Everything else we read is JSON."""

from __future__ import annotations

import math
import struct

import numpy as np
from numpy.typing import NDArray

FREE, OCCUPIED, UNKNOWN = 0, 1, 2  # as in `World.occupancy`


def occupancy_grid(
    message: bytes,
) -> tuple[NDArray[np.uint8], float, tuple[float, float, float]]:
    """Read `nav_msgs/OccupancyGrid` from CDR: (rows, cols) cells, their side [m], the origin."""
    body = memoryview(message)[4:]
    (length,) = struct.unpack_from("<I", body, 8)  # of the frame's name, after a stamp
    at = _aligned(12 + length, 4) + 8  # after the time the map was loaded
    resolution, cols, rows = struct.unpack_from("<fII", body, at)
    at = _aligned(at + 12, 8)
    x, y, _, _, _, sin, cos = struct.unpack_from("<7d", body, at)
    cells = np.frombuffer(body, np.int8, offset=at + 56 + 4, count=rows * cols)
    occupancy = np.full(rows * cols, UNKNOWN, np.uint8)
    occupancy[cells == 0] = FREE
    occupancy[cells == 100] = OCCUPIED
    side = float(str(np.float32(resolution)))  # the shortest number that is this f32
    return occupancy.reshape(rows, cols), side, (x, y, 2.0 * math.atan2(sin, cos))


def _aligned(offset: int, size: int) -> int:
    return -(-offset // size) * size
