"""Reading text files with the line of every complaint at hand."""

import math
from pathlib import Path
from typing import Any, NoReturn

from cairn import errors


def refuse(
    error: type[errors.MapError], path: Path, reason: str, *, line: int | None = None, **fields: Any
) -> NoReturn:
    """Raise `error` with the file, the line if there is one, and the reason."""
    where = str(path) if line is None else f"{path}:{line}"
    raise error(f"{where}: {reason}", path=str(path), line=line, **fields)


def read_text(path: Path) -> str:
    """The text of a file, UTF-8.

    Raises:
        MapNotFound, MapTextInvalid
    """
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        refuse(errors.MapNotFound, path, "no such file")
    except UnicodeDecodeError as error:
        refuse(errors.MapTextInvalid, path, f"not a text file: byte {error.start} is not UTF-8")


def numbers(path: Path, line: int, text: str, count: int, what: str) -> list[float]:
    """The `count` finite numbers of a line that should be `what`.

    Raises:
        MapLineInvalid
    """
    words = text.split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != count or not all(math.isfinite(v) for v in values):
        reason = f"`{text.strip()}` is not {what}, {count} finite numbers"
        refuse(errors.MapLineInvalid, path, reason, line=line)
    return values


def whole(path: Path, line: int, key: str, text: str, least: int = 0) -> int:
    """The whole number that `key` of a header is.

    Raises:
        MapKeyInvalid
    """
    try:
        value = int(text)
    except ValueError:
        value = None
    if value is None or value < least:
        reason = f"{key} is `{text.strip()}`, must be a whole number of at least {least}"
        refuse(errors.MapKeyInvalid, path, reason, line=line, key=key, value=text.strip())
    return value
