"""The configuration reference: every key of every file, from the code that reads it.

Rust says what the brain's keys mean (its documentation), the brain itself what their defaults are
(`default_config`), and the models of the body the rest.
"""

from __future__ import annotations

import json
import re
import tomllib
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

import cairn
from cairn import shipped
from cairn.missions import scenario
from cairn.profile import Noise, Physics
from sitegen.rust_source import Item, read_items

UNIT = re.compile(r"\s*\[([^\]\[]{1,24})\]([.,;:]?)")
# What is written as a table of numbers, not as keys of its own.
POSE = "x, y [m] and heading [rad] in the robot frame"


class Undocumented(LookupError):
    """A key that nothing is said of, or a struct that is not found."""


def pages(root: Path) -> Iterator[tuple[str, str]]:
    """(name, Markdown) of each page of the reference."""
    items = read_items(root / "crates" / "cairn" / "src")
    yield "navigator", _navigator(items)
    yield "profile", _profile(items)
    yield "controller", _controller(items)
    yield "scenario", _scenario()


def navigator_keys(items: Mapping[str, Item]) -> Iterator[tuple[str, Any, str]]:
    """(dotted key, default, meaning) of every setting of the navigator, tables among them."""

    def walk(values: Mapping[str, Any], kind: str, before: str) -> Iterator[tuple[str, Any, str]]:
        parts = {part.name: part for part in _item(items, kind).parts}
        plain_first = sorted(values, key=lambda name: isinstance(values[name], dict))
        for name in plain_first:
            key, value = f"{before}{name}", values[name]
            if name not in parts or not parts[name].text:
                raise Undocumented(f"nothing is said of `{key}` ({kind} in the brain)")
            text = parts[name].text
            if parts[name].type in items and items[parts[name].type].kind == "enum":
                text += "\n\n" + _choices(items[parts[name].type])
            yield key, value, text
            if isinstance(value, dict):
                yield from walk(value, parts[name].type, f"{key}.")

    return walk(cairn.Navigator.default_config(), "NavigatorConfig", "")


def _navigator(items: Mapping[str, Item]) -> str:
    lines = [
        "# Settings of the navigator",
        "",
        "What `cairn.Navigator(profile, config={...})` takes, and `[navigator]` in a scenario.",
        "Give what differs; a key that does not exist is refused by name. Defaults are those of",
        "`cairn.Navigator.default_config()`; meanings are the documentation of the Rust structs.",
    ]
    lines += ["", *HEAD]
    for key, value, text in navigator_keys(items):
        if isinstance(value, dict):
            lines += ["", f"## `[{key}]`", "", _sentence(text)]
            if not all(isinstance(each, dict) for each in value.values()):
                lines += ["", *HEAD]
        else:
            lines.append(_row(key.rpartition(".")[2], _toml(value), text))
    return "\n".join(lines) + "\n"


HEAD = ["| key | default | unit | meaning |", "|---|---|---|---|"]


def _profile(items: Mapping[str, Item]) -> str:
    shown = tomllib.loads((shipped.folder("profiles") / "p3at.toml").read_text())
    lines = [
        "# Robot profiles",
        "",
        'What `cairn.Profile.load("p3at")`, `profile = ` in a scenario and `--robot` read: a',
        "shipped name or a TOML file. Start from `python/cairn/data/profiles/p3at.toml`, whose",
        "values stand beside the keys. The brain reads the first tables;",
        "`[physics]` and `[noise]` are for simulations.",
    ]

    def table(title: str, kind: str, values: Mapping[str, Any]) -> None:
        item = _item(items, kind)
        lines.extend(["", f"## {_titled(title)}", "", _sentence(item.text), "", *HEAD_SHOWN])
        for part in item.parts:
            if part.type.removeprefix("Option<").removeprefix("Vec<").rstrip(">") in nested:
                continue
            text = part.text if part.type != "Pose2" else f"{part.text} {POSE}"
            lines.append(_row(part.name, _toml(values[part.name]), text))

    nested = {"Footprint", "Limits", "Drive", "Sonar", "Lidar"}
    table("On top", "RobotProfile", shown)
    for key, kind in (("footprint", "Footprint"), ("limits", "Limits"), ("drive", "Drive")):
        table(f"[{key}]", kind, shown[key])
    table("[[sonars]]", "Sonar", shown["sonars"][3])
    lidar = tomllib.loads((shipped.folder("profiles") / "jackal.toml").read_text())["lidar"]
    table("[lidar]", "Lidar", lidar)
    for key, model in (("physics", Physics), ("noise", Noise)):
        lines += ["", f"## `[{key}]`", "", _sentence(model.__doc__ or ""), "", *HEAD_SHOWN]
        for name, info in model.model_fields.items():
            if not info.description:
                raise Undocumented(f"nothing is said of `{key}.{name}`")
            value = shown[key].get(name, info.default)
            lines.append(_row(name, _toml(value), info.description))
    return "\n".join(lines) + "\n"


HEAD_SHOWN = ["| key | for example | unit | meaning |", "|---|---|---|---|"]


def _controller(items: Mapping[str, Item]) -> str:
    shown = tomllib.loads((shipped.folder("controllers") / "p3at.toml").read_text())
    lines = [
        "# Controllers of the tracker",
        "",
        'What `cairn.Tracker("p3at", profile)` and `cairn track --controller` read: a shipped',
        "name, a TOML file, or its text. The values are those of",
        "`python/cairn/data/controllers/p3at.toml`. `cairn tune` writes such files.",
        "",
        "## On top",
        "",
        _sentence(_item(items, "TrackerConfig").text),
        "",
        *HEAD_SHOWN,
    ]
    for part in _documented("TrackerConfig", items):
        value = shown[part.name]
        told = f"the table `[{part.name}]`" if isinstance(value, dict) else _toml(value)
        lines.append(_row(part.name, told, part.text))
    lines += [
        "",
        "## `[look_ahead]` and `[tracker]`",
        "",
        "Both are fuzzy systems; so is what `cairn.FuzzySystem` reads.",
        "",
        "| key | if not given | meaning |",
        "|---|---|---|",
    ]
    places = (
        ("FuzzyConfig", ""), ("FuzzyInput", "inputs.NAME."), ("FuzzyRule", "rules[]."),
        ("FuzzyTable", "tables[]."),
    )  # fmt: skip
    for kind, before in places:
        for part in _documented(kind, items):
            text = part.text + ("\n\n" + _choices(items["And"]) if part.type == "And" else "")
            absent = "" if part.has_default else "required"
            lines.append(f"| `{before}{part.name}` | {absent} | {_cell(text)} |")
    lines += [
        "",
        "Sets of an input, in the unit of the input:",
        "",
        "| set | what it is |",
        "|---|---|",
    ]
    lines += [f"| `{part.name}` | {_cell(part.text)} |" for part in _item(items, "FuzzySet").parts]
    return "\n".join(lines) + "\n"


def _documented(kind: str, items: Mapping[str, Item]) -> list[Any]:
    parts = _item(items, kind).parts
    for part in parts:
        if not part.text:
            raise Undocumented(f"nothing is said of `{part.name}` of {kind}")
    return parts


def _scenario() -> str:
    lines = [
        "# Scenario files",
        "",
        "Every key that `cairn run FILE.toml` and `cairn.missions.Scenario.load` read, from their",
        "models. What scenarios are for, and how to write one: [scenarios](/scenarios.md).",
    ]
    tables: list[tuple[str, type[BaseModel]]] = [
        ("On top", scenario.Scenario),
        ("[start]", scenario.Start),
        ("[[robots]]", scenario.RobotEntry),
        ("[[goals]]", scenario.Goal),
        ("[[boxes]]", scenario.Box),
        ("[world]", scenario.WorldEntry),
        ("[expect]", scenario.Expect),
        ("[[events]]", scenario._Event),
    ]
    events = typing.get_args(typing.get_args(scenario.Event)[0])
    for event in events:
        do = typing.get_args(event.model_fields["do"].annotation)[0]
        tables.append((f'[[events]] do = "{do}"', event))
    common = set(scenario._Event.model_fields)
    for title, model in tables:
        own = title.startswith("[[events]] do")
        lines += [
            "",
            f"## {_titled(title)}",
            "",
            (model.__doc__ or "").strip().replace("\n    ", "\n"),
        ]
        rows = []
        for name, info in model.model_fields.items():
            if not info.description:
                raise Undocumented(f"nothing is said of `{name}` of {model.__name__}")
            if (own and name in common) or name == "do":
                continue
            told = "required" if info.is_required() else _default(info.default)
            rows.append(
                f"| `{name}` | {_kind(info.annotation)} | {told} | {_cell(info.description)} |"
            )
        if rows:
            lines += ["", "| key | kind | if not given | meaning |", "|---|---|---|---|", *rows]
    return "\n".join(lines) + "\n"


def _titled(table: str) -> str:
    return f"`{table}`" if table.startswith("[") else table


def _default(value: Any) -> str:
    if value is None or value is PydanticUndefined or value in ((), {}):
        return ""
    return "" if isinstance(value, BaseModel) or value == "" else _toml(value)


def _kind(annotation: Any) -> str:
    """How a person says what may stand there."""
    origin = typing.get_origin(annotation)
    if origin is typing.Annotated:
        return _kind(typing.get_args(annotation)[0])
    if origin is Literal:
        return " or ".join(f'`"{choice}"`' for choice in typing.get_args(annotation))
    if origin in (UnionType, typing.Union):
        kinds = [_kind(each) for each in typing.get_args(annotation) if each is not NoneType]
        return " or ".join(dict.fromkeys(kinds))
    if origin is tuple:
        inside = typing.get_args(annotation)
        if inside[-1] is not Ellipsis:
            return f"{len(inside)} numbers"
        return f"list of {_kind(inside[0])}"
    if origin is dict:
        return "table"
    names = {float: "number", int: "whole number", bool: "`true` or `false`", str: "text"}
    return names.get(annotation, "table")


def _item(items: Mapping[str, Item], kind: str) -> Item:
    if kind not in items:
        raise Undocumented(f"the brain has no public `{kind}`")
    return items[kind]


def _choices(item: Item) -> str:
    for part in item.parts:
        if not part.text:
            raise Undocumented(f"nothing is said of `{part.name}` of {item.name}")
    return "; ".join(f'`"{part.name}"`: {_sentence(part.text).rstrip(".")}' for part in item.parts)


def _row(name: str, value: str, text: str) -> str:
    unit = ""
    if found := UNIT.findall(text):
        unit = " and ".join(dict.fromkeys(each for each, _ in found)) if text.count("[") < 3 else ""
        if unit:
            text = UNIT.sub(r"\2", text)
    return f"| `{name}` | {value} | {unit} | {_cell(text)} |"


def _cell(text: str) -> str:
    told = " ".join(text.split()).replace("|", "\\|")
    return told[:1].upper() + told[1:]


def _sentence(text: str) -> str:
    """The first paragraph."""
    return " ".join(text.strip().split("\n\n")[0].split())


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "`{ " + ", ".join(f"{key} = {each}" for key, each in value.items()) + " }`"
    if isinstance(value, float):
        return f"`{value:.6g}`" if value % 1 else f"`{value}`"
    return f"`{json.dumps(value, ensure_ascii=False)}`"
