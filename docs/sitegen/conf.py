"""Sphinx's settings; `sitegen.build` runs it on the pages that `sitegen.stage` has put together."""

from __future__ import annotations

import re
from typing import Any

import cairn

project = "Cairn"
version = release = cairn.__version__
html_title = "Cairn"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["cairn.css"]
templates_path: list[str] = []

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
# Roles in backticks are not ours: `[Maalouf06 (5)]` is a citation, and Markdown is what we write.
default_role = "code"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_default_options = {"show-inheritance": False}
autodoc_preserve_defaults = True
# Attributes of one name in several classes, `time_s`: no single one is meant.
suppress_warnings = ["ref.python"]
python_use_unqualified_type_names = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_preprocess_types = False
add_module_names = False

FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^ *```$", re.M | re.S)
CODE = re.compile(r"(?<!`)`([^`\n]+(?:\n[^`\n]+)?)`(?!`|_)")


def restructured(text: str) -> str:
    """Our docstrings are Markdown in a small way: fenced code and `code`; as Sphinx wants them."""

    def block(match: re.Match[str]) -> str:
        space, language, code = match.groups()
        inside = "\n".join(f"    {line}".rstrip() for line in code.splitlines())
        return f"{space}.. code-block:: {language or 'text'}\n\n{inside}\n"

    blocks: list[str] = []

    def keep(match: re.Match[str]) -> str:
        blocks.append(block(match))
        return f"\x00{len(blocks) - 1}\x00"

    text = FENCE.sub(keep, text)
    pieces = CODE.split(text)
    for i, piece in enumerate(pieces):
        if i % 2:
            pieces[i] = f"``{' '.join(piece.split())}``"
        else:
            pieces[i] = re.sub(r"([*|]|(?<=\w)_(?=\W|$))", r"\\\1", piece)
    text = "".join(pieces)
    return re.sub("\x00(\\d+)\x00", lambda match: blocks[int(match.group(1))], text)


# What the aliases of numpy.typing spell out to.
ARRAY_LIKE = re.compile(
    r"_Buffer \| _SupportsArray\[dtype\[Any\]\] "
    r"\| _NestedSequence\[_SupportsArray\[dtype\[Any\]\]\] \| complex "
    r"\| bytes \| str \| _NestedSequence\[complex \| bytes \| str\]"
)
NDARRAY = re.compile(r"ndarray\[tuple\[Any, \.\.\.\], dtype\[((?:[^\[\]]|\[[^\]]*\])*)\]\]")


def _shortened(
    app: Any, what: str, name: str, value: Any, options: Any, taken: str | None, given: str | None
) -> tuple[str | None, str | None]:
    """A signature as it is written."""
    both = []
    for each in (taken, given):
        text = None if each is None else each.replace("~", "")
        if text is not None:
            text = re.sub(
                r"\b(?:numpy\._typing\.\w+\.|numpy\.|collections\.abc\.|typing\.)", "", text
            )
            text = NDARRAY.sub(r"NDArray[\1]", ARRAY_LIKE.sub("ArrayLike", text))
        both.append(text)
    return both[0], both[1]


def _process(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    lines[:] = restructured("\n".join(lines)).split("\n")


def setup(app: Any) -> None:
    """Called by Sphinx; before napoleon, which reads what this leaves."""
    app.connect("autodoc-process-docstring", _process, priority=100)
    app.connect("autodoc-process-signature", _shortened)
