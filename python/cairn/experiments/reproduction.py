"""What a reproduction is: a study is measured, drawn, told as tables, and said what to make of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Advance = Callable[[str], None]


@dataclass(frozen=True)
class TableOf:
    """A table to print: a title, column names, and rows of text."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple[str, ...]]


@dataclass(frozen=True)
class Caption:
    """What a person must know beside a picture.

    Args:
        source: where in the paper, and what it shows there.
        made_from: what ours is made from, with its parameters.
        agrees, differs: what does and what does not, in sentences; nothing is left out of these.
    """

    source: str
    made_from: str
    agrees: tuple[str, ...] = ()
    differs: tuple[str, ...] = ()

    def markdown(self, title: str) -> str:
        """Return it as a text to put beside the picture."""
        lines = [f"# {title}", "", self.source, "", f"Made from: {self.made_from}"]
        for name, sentences in (("Agrees", self.agrees), ("Differs", self.differs)):
            if sentences:
                lines += ["", f"{name}:", "", *(f"- {sentence}" for sentence in sentences)]
        return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class Reproduction:
    """A figure or study of the paper, or one it leaves to be done.

    Args:
        title: what it shows, in a line.
        steps: how often `measure` calls what it is given.
        measure: (seed, advance) → the record, with a top-level `summary`.
        draw: (record, folder) → the pictures drawn.
        tables: record → what to print.
        caption: record → what to say beside the pictures.
    """

    title: str
    steps: Callable[[], int]
    measure: Callable[[int, Advance], dict[str, Any]]
    draw: Callable[[dict[str, Any], Path], list[Path]]
    tables: Callable[[dict[str, Any]], list[TableOf]]
    caption: Callable[[dict[str, Any]], Caption]
