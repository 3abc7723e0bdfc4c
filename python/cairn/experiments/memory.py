"""Peak memory of one plan, measured in a process of its own.

Run as `python -m cairn.experiments.memory MAP.npz SOLVER`; prints bytes as JSON.
The peak is what the process held at most while solving, above what it held just before, plus the
map itself. On Linux the kernel's high-water mark is reset just before; elsewhere nothing
is measured.
"""

from __future__ import annotations

import gc
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from cairn.experiments.contenders import InRust, Task
from cairn.experiments.grids import Terrain

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def peak_share(task: Task, solver: str = "cairn") -> float | None:
    """Peak of one plan as a share of (input + output); None where it cannot be told."""
    if not _RESET.exists():
        return None
    ground = task.grid
    arrays = (
        {"elevation": ground.elevation, "roughness": ground.roughness, "size": ground.cell_size_m}
        if isinstance(ground, Terrain)
        else {"cells": task.cells()}
    )
    rule = {"goal": task.goal, "cutting": task.corner_cutting}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.npz"
        np.savez(path, **arrays, **rule)
        command = [sys.executable, "-m", __name__, str(path), solver]
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


def _measure(path: str, solver: str) -> dict[str, int]:
    with np.load(path) as told:
        given = dict(told)
    goal, cutting = tuple(map(int, given["goal"])), bool(given["cutting"])
    if "cells" in given:
        grid = given["cells"]
    else:
        grid = Terrain(given["elevation"], given["roughness"], float(given["size"]))
    timed = InRust(solver, Task(grid, (goal[0], goal[1]), cutting))
    taken = sum(each.nbytes for name, each in given.items() if each.ndim == 2)
    del grid, given
    gc.collect()
    before = _held("VmRSS")
    _RESET.write_text("5")
    timed.run()
    peak = _held("VmHWM") - before
    native, codes = timed.values(), timed.next_node()
    assert codes is not None
    return {"input": taken, "output": native.nbytes + codes.nbytes, "peak": peak + taken}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(_measure(*sys.argv[1:3])))
