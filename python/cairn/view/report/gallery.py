"""One page of all that `cairn reproduce` made."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cairn.view.report.pages import rendered, written


def write_gallery(
    shown: Sequence[Mapping[str, Any]], not_made: Mapping[str, str], path: Path
) -> Path:
    """Write what was made as one HTML file, pictures within it.

    Args:
        shown: {name, title, caption, pictures}, of which `caption` has `source`, `made_from`,
            `agrees`, `differs`, and `pictures` are PNG files.
        not_made: why, by name.
        path: the file.
    """
    entries = [{**one, "pictures": [_data(Path(p)) for p in one["pictures"]]} for one in shown]
    return written(rendered("gallery.html", shown=entries, not_made=not_made), path)


def _data(picture: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()
