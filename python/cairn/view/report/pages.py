"""Pages from templates: one self-contained HTML file, every text in it escaped."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

import cairn

_FOLDER = Path(__file__).parent


def rendered(template: str, **values: Any) -> str:
    """Fill a template of this folder; style sheet and scripts are put into the page."""
    pages = Environment(
        loader=PackageLoader("cairn.view.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    pages.filters["code"] = _with_code
    return pages.get_template(template).render(
        version=cairn.__version__,
        style=_own("style.css"),
        theme=_own("theme.js"),
        player=_own("player.js"),
        **values,
    )


def written(page: str, path: Path) -> Path:
    """Write a page, its folder made if need be; returns `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")
    return path


def _with_code(text: str) -> Markup:
    """Text with what stands between backticks as code."""
    parts = str(text).split("`")
    if len(parts) % 2 == 0:
        return escape(text)
    pieces = (
        Markup("<code>{}</code>").format(part) if number % 2 else escape(part)
        for number, part in enumerate(parts)
    )
    return Markup("").join(pieces)


def _own(name: str) -> Markup:
    """Text of this folder that is code and not to be escaped."""
    return Markup((_FOLDER / name).read_text(encoding="utf-8"))
