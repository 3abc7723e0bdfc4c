"""`summary.json`, what came out of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def write_summary(record: dict[str, Any], folder: Path) -> Path:
    """Write the record of a run as `summary.json` into `folder`, made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "summary.json"
    path.write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return path
