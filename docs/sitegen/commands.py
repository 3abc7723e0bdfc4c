"""The command reference, from the commands themselves."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import typer

from cairn.cli import app
from cairn.cli.order import HEADINGS

INTRODUCTION = """\
# Commands

Every command has `--help`, and `--json` prints one JSON object with a `summary` and nothing else.
Progress goes to stderr, and only to a terminal. `cairn --install-completion` teaches your shell the
commands, their options and the names of shipped maps, scenarios and robots.

| exit code | meaning |
|---|---|
| 0 | done, or reached |
| 1 | a bug of ours: one line says so, the traceback is in a file that it names |
| 2 | usage or bad input; nothing was done |
| 3 | goal not reached or refused; for benchmarks: an answer was wrong; for `doctor`: not sound |
| 4 | contact: a robot touched something |
| 130 | interrupted |
"""


def leaves(group: Any = None, names: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """(names, command) of every command that does something."""
    group = group or typer.main.get_command(app)
    for name, each in group.commands.items():
        if hasattr(each, "commands"):
            yield from leaves(each, (*names, name))
        else:
            yield (*names, name), each


def page() -> str:
    """The page in Markdown."""
    order = [name for names in HEADINGS.values() for name in names]
    every = sorted(leaves(), key=lambda each: order.index(each[0][0]))
    lines = [INTRODUCTION]
    for names, command in every:
        arguments = [each for each in command.params if not each.opts[0].startswith("-")]
        options = [each for each in command.params if each.opts[0].startswith("-")]
        shown = " ".join(each.metavar or each.name.upper() for each in arguments)
        lines += [
            f"## `cairn {' '.join(names)}`",
            "",
            _escaped(command.help or ""),
            "",
            "```text",
            " ".join(f"cairn {' '.join(names)} {shown} [OPTIONS]".split()),
            "```",
            "",
            "| | if not given | |",
            "|---|---|---|",
        ]
        for each in [*arguments, *options]:
            spelled = "/".join([*each.opts, *each.secondary_opts])
            if each in arguments:
                spelled = each.metavar or each.name.upper()
            told = "required" if each.required else _default(each)
            lines.append(f"| `{spelled}` | {told} | {_cell(each.help or '')} |")
        lines.append("")
    return "\n".join(lines)


def _default(option: Any) -> str:
    value = option.default() if callable(option.default) else option.default
    if value is None or value is False or value == ():
        return ""
    return f"`{option.opts[0]}`" if value is True else f"`{value}`"


def _escaped(text: str) -> str:
    return re.sub(r"<(\w+)>", r"\\<\1>", text.strip())


def _cell(text: str) -> str:
    return _escaped(" ".join(text.split()).replace("|", "\\|"))
