"""Peak memory of one plan, measured in a process of its own.

Run as `python -m cairn.experiments.memory MAP.npy ROW COL CUTTING SOLVER`; prints bytes as JSON.
The peak is what the process held at most while solving, above what it held just before, plus the
map itself. On Linux the kernel's high-water mark is reset just before; elsewhere nothing
is measured.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def peak_share(
    grid: np.ndarray, goal: tuple[int, int], corner_cutting: bool, solver: str = "cairn"
) -> float | None:
    """Return the peak of one plan as a share of (input + output), or None where it cannot be told.

    Args:
        grid: as the solver takes it: bool, or float32 costs.
        goal: (row, col).
        corner_cutting: whether diagonals may pass between blocked cells.
        solver: name of a solver of the brain.
    """
    if not _RESET.exists():
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.npy"
        np.save(path, grid)
        row, col = (str(int(part)) for part in goal)
        command = [sys.executable, "-m", __name__, str(path), row, col, str(corner_cutting), solver]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        return None
    told = json.loads(done.stdout)
    return told["peak"] / (told["input"] + told["output"])


def _held(key: str) -> int:
    """Return a line of the process's status in bytes."""
    for line in _STATUS.read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024
    raise OSError(f"{_STATUS} has no {key}")


def _measure(path: str, row: str, col: str, cutting: str, solver: str) -> dict[str, int]:
    from cairn import _brain

    grid = np.load(path)
    taken = grid.nbytes
    goal = (int(row), int(col))
    timed = _brain.TimedSolver(solver, grid, [goal], cutting == "True", 1)
    del grid
    before = _held("VmRSS")
    _RESET.write_text("5")
    timed.run()
    peak = _held("VmHWM") - before
    native, codes = timed.native(), timed.next_node()
    return {"input": taken, "output": native.nbytes + codes.nbytes, "peak": peak + taken}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(_measure(*sys.argv[1:6])))
