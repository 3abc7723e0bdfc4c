"""The two files of a run: `summary.json`, and `decisions.jsonl` with one line per tick."""

from __future__ import annotations

import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self


def write_summary(record: dict[str, Any], folder: Path) -> Path:
    """Write the record of a run as `summary.json` into `folder`, made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "summary.json"
    path.write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return path


class DecisionLog:
    """Writes every decision of a run as JSON Lines: `{"time_s": …, "robot": …, "truth": …, …}`.

    An observer of `cairn.missions.run` and a context manager.
    """

    def __init__(self, folder: Path) -> None:
        """Begin `decisions.jsonl` in `folder`, made if need be."""
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / "decisions.jsonl"
        self._file = self.path.open("w", encoding="utf-8")

    def __call__(self, tick: Any) -> None:
        """Write one robot's decision."""
        line = {
            "time_s": tick.time_s,
            "robot": tick.robot,
            "truth": list(tick.truth),
            "clearance_m": tick.clearance_m,
            "decision": tick.decision.to_dict(),
        }
        self._file.write(json.dumps(_finite(line), separators=(",", ":")) + "\n")

    def __enter__(self) -> Self:
        """Open already; returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._file.close()


def _finite(value: Any) -> Any:
    """Return `value` with null for the non-finite numbers, which JSON does not have."""
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    return value if isinstance(value, str | int | bool | None) else str(value)
