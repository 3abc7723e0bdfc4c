"""Values as strict JSON has them: what is not finite becomes null, arrays become lists."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def plain(value: Any, decimals: int | None = None) -> Any:
    """`value` as dicts, lists, strings and numbers; floats rounded to `decimals` if given."""
    if isinstance(value, dict):
        return {str(key): plain(item, decimals) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist(), decimals)
    if isinstance(value, list | tuple):
        return [plain(item, decimals) for item in value]
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        return value if decimals is None else round(value, decimals)
    return value
