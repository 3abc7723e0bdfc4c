"""The ROS 2 messages that are read back here: maps and paths. Everything else we read is JSON."""

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


def path_points(message: bytes) -> NDArray[np.float64]:
    """Read `nav_msgs/Path` from CDR: its points (n, 2) [m, frame of the path]."""
    body = memoryview(message)[4:]
    at = _after_header(body, 0)
    at = _aligned(at, 4)
    (count,) = struct.unpack_from("<I", body, at)
    at += 4
    points = np.empty((count, 2))
    for number in range(count):
        at = _aligned(_after_header(body, at), 8)
        points[number] = struct.unpack_from("<2d", body, at)
        at += 56  # a position and a quaternion
    return points


def _after_header(body: memoryview, at: int) -> int:
    """Where a `std_msgs/Header` ends: a stamp, then the name of a frame."""
    at = _aligned(at, 4) + 8
    (length,) = struct.unpack_from("<I", body, at)
    return at + 4 + length


def _aligned(offset: int, size: int) -> int:
    return -(-offset // size) * size
