"""Structs and enums of the brain as their source has them: fields, types and what is said of them.

The source is the truth for the configuration reference: `cargo fmt` keeps it regular enough to be
read line by line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

ITEM = re.compile(r"pub (struct|enum) (\w+)(?:<[^>]*>)? \{$")
FIELD = re.compile(r"    pub (?:\([^)]*\) )?(\w+): (.*),$")
VARIANT = re.compile(r"    (\w+)(?:\(.*\))?,?(?: \{)?$")
RENAME = re.compile(r'#\[serde\(.*?rename = "([^"]+)"')
RENAME_ALL = re.compile(r'#\[serde\(.*?rename_all = "(\w+)"')


@dataclass
class Part:
    """A field of a struct or a variant of an enum."""

    name: str
    """As a file or record has it."""
    type: str
    """As Rust has it; empty for a variant."""
    text: str
    """What its documentation says, Markdown; empty if there is none."""
    has_default: bool = False


@dataclass
class Item:
    """A struct or an enum."""

    kind: str
    name: str
    text: str
    path: Path
    parts: list[Part] = field(default_factory=list)


def read_items(folder: Path) -> dict[str, Item]:
    """Every public struct and enum in a folder of Rust, by name; the first of a name wins."""
    items: dict[str, Item] = {}
    for path in sorted(folder.rglob("*.rs")):
        for item in _items(path):
            items.setdefault(item.name, item)
    return items


def _items(path: Path) -> list[Item]:
    found: list[Item] = []
    docs: list[str] = []
    attributes: list[str] = []
    item: Item | None = None
    style = ""
    depth = 0
    for line in path.read_text(encoding="utf-8").splitlines():
        bare = line.strip()
        if item is None:
            if match := ITEM.match(line):
                item = Item(match.group(1), match.group(2), _markdown(docs), path)
                style = _first(RENAME_ALL, attributes)
                docs, attributes, depth = [], [], 0
                continue
        elif line == "}":
            found.append(item)
            item, docs, attributes = None, [], []
            continue
        if bare.startswith("///"):
            docs.append(bare[3:].removeprefix(" "))
        elif bare.startswith("#["):
            attributes.append(bare)
        elif (
            item is not None and depth == 0 and (part := _part(item.kind, line, attributes, style))
        ):
            part.text = _markdown(docs)
            item.parts.append(part)
            depth += line.count("{") - line.count("}")
            docs, attributes = [], []
        else:
            depth = max(0, depth + line.count("{") - line.count("}")) if item else 0
            if bare:
                docs, attributes = [], []
    return found


def _part(kind: str, line: str, attributes: list[str], style: str) -> Part | None:
    match = (FIELD if kind == "struct" else VARIANT).match(line)
    if match is None:
        return None
    name = _first(RENAME, attributes)
    if not name:
        name = _styled(match.group(1), style) if kind == "enum" else match.group(1)
    default = any("default" in each for each in attributes)
    return Part(name, match.group(2) if kind == "struct" else "", "", default)


def _styled(variant: str, style: str) -> str:
    if style == "snake_case":
        return re.sub(r"(?<!^)(?=[A-Z])", "_", variant).lower()
    return variant.lower() if style == "lowercase" else variant


def _first(pattern: re.Pattern[str], lines: list[str]) -> str:
    return next((match.group(1) for line in lines if (match := pattern.search(line))), "")


def _markdown(lines: list[str]) -> str:
    r"""Rustdoc as Markdown: `\[m\]` is [m], and links to items are their names as code."""
    text = "\n".join(lines).strip()
    text = text.replace("\\[", "[").replace("\\]", "]")
    return re.sub(r"\[`([^`\]]+)`\](?:\([^)]*\))?", r"`\1`", text)
