"""The two files of a run: `summary.json`, and `decisions.jsonl` with one line per tick."""

from __future__ import annotations

import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from cairn.strict_json import plain


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
        self._file.write(json.dumps(plain(line), separators=(",", ":"), allow_nan=False) + "\n")

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
