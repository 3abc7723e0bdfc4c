"""What was measured on: told with every table."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

import cairn
from cairn import _brain
from cairn.experiments.contenders import PEERS


def describe() -> dict[str, Any]:
    """Processor, memory, system, versions and how the brain was built."""
    return {
        "processor": _processor(),
        "cores": cores(),
        "memory_gib": _gib("MemTotal"),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "load_average": _load(),
        "cairn": cairn.__version__,
        "build": _brain.build_info(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "peers": {name: peer.version for name, peer in PEERS.items()},
    }


def cores() -> int:
    """Cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_bytes() -> float:
    """Memory that is there to be used; infinite where that cannot be told."""
    gib = _gib("MemAvailable")
    return float("inf") if gib is None else gib * 2**30


def _load() -> float | None:
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _gib(key: str) -> float | None:
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith(key + ":"):
                return round(int(line.split()[1]) / 2**20, 1)
    except OSError:
        pass
    return None
