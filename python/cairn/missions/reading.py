"""Scenario files: found by name or path, read, and refused with file, line, key and reason."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from pydantic import ValidationError

from cairn.errors import ScenarioInvalid, ScenarioNotFound
from cairn.missions.scenario import Scenario
from cairn.shipped import find, names

Key = tuple[str | int, ...]
# What pydantic puts into the place of an error besides the keys.
_EVENTS = ("shove", "new_goal", "cancel", "emergency_stop", "hold")


def shipped() -> list[str]:
    """Return the names of the shipped scenarios, in alphabetical order."""
    return names("scenarios")


def load(name_or_path: str | Path) -> Scenario:
    """See `Scenario.load`."""
    path = find("scenarios", name_or_path)
    if path is None:
        raise ScenarioNotFound(
            f"no scenario `{name_or_path}`: give a .toml file or one of {', '.join(shipped())}",
            name=str(name_or_path),
        )
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ScenarioInvalid(
            f"{path}: not UTF-8 text (byte {error.start})",
            path=str(path),
            line=None,
            key="",
            reason="not UTF-8 text",
        ) from error
    return parse(text, path)


def parse(text: str, path: Path) -> Scenario:
    """Read a scenario from TOML `text`; `path` names it in errors and anchors relative paths."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        where = re.search(r"\(at line (\d+)", str(error))
        reason = re.sub(r" \(at .*\)$", "", str(error))
        line = int(where.group(1)) if where else text.count("\n") + 1
        raise _invalid(path, line, "", reason) from error
    try:
        scenario = Scenario.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        key = tuple(part for part in first["loc"] if part not in _EVENTS)
        line = _line_of(key, text)
        raise _invalid(path, line, _dotted(key), _reason(first["type"], first["msg"])) from error
    scenario._folder = path.resolve().parent
    return scenario


def _invalid(path: Path, line: int | None, key: str, reason: str) -> ScenarioInvalid:
    at = f"{path}:{line}" if line else str(path)
    about = f"`{key}`: " if key else ""
    message = f"{at}: {about}{reason}"
    return ScenarioInvalid(message, path=str(path), line=line, key=key, reason=reason)


def _reason(kind: str, message: str) -> str:
    if kind == "extra_forbidden":
        return "unknown key"
    if kind == "missing":
        return "missing"
    if kind == "finite_number":
        return "must be a finite number"
    reason = message.removeprefix("Value error, ")
    return reason[:1].lower() + reason[1:]


def _dotted(key: Key) -> str:
    text = ""
    for part in key:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _line_of(key: Key, text: str) -> int | None:
    """Return the line of `key`, or of the nearest table around it that the text names."""
    lines = _lines_of_keys(text)
    while key:
        if key in lines:
            return lines[key]
        key = key[:-1]
    return None


def _lines_of_keys(text: str) -> dict[Key, int]:
    """Map every key path that stands at the start of a line to its line number."""
    found: dict[Key, int] = {}
    counts: dict[str, int] = {}
    table: Key = ()
    in_string = False
    for number, line in enumerate(text.splitlines(), start=1):
        if (line.count('"""') + line.count("'''")) % 2 == 1:
            in_string = not in_string
            if not in_string:
                continue
        elif in_string:
            continue
        if header := re.match(r"\s*\[(\[?)\s*([\w.\-\" ]+?)\s*\]", line):
            name = header.group(2).replace('"', "").replace(" ", "")
            if header.group(1):
                counts[name] = counts.get(name, -1) + 1
                table = (*name.split("."), counts[name])
                found.setdefault(table[:-1], number)
            else:
                table = tuple(name.split("."))
            found.setdefault(table, number)
        elif entry := re.match(r"\s*([\w\-\".]+)\s*=", line):
            key = (*table, *entry.group(1).replace('"', "").split("."))
            found.setdefault(key, number)
    return found
