"""Profiles, controllers and scenarios that come with the package, found by name."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from cairn.errors import ControllerUnreadable, ProfileUnreadable

Kind = Literal["controllers", "profiles", "scenarios"]

_DATA = Path(__file__).parent / "data"


def folder(kind: Kind) -> Path:
    """Where the files of a kind are."""
    return _DATA / kind


def names(kind: Kind) -> list[str]:
    """Their names, in alphabetical order."""
    return sorted(path.stem for path in folder(kind).glob("*.toml"))


def find(kind: Kind, name_or_path: str | Path) -> Path | None:
    """The shipped file of that name, else the file at that path; None if there is neither."""
    if isinstance(name_or_path, str) and name_or_path in names(kind):
        return folder(kind) / f"{name_or_path}.toml"
    path = Path(name_or_path)
    return path if path.is_file() else None


def read(path: Path, unreadable: type[ControllerUnreadable | ProfileUnreadable]) -> str:
    """The text of a file; `unreadable` is raised if it is not UTF-8."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        reason = f"{path}: not UTF-8 text (byte {error.start})"
        raise unreadable(reason, reason=reason) from error
