"""In which order and under which headings `cairn --help` lists the commands."""

from __future__ import annotations

import inspect

import typer

HEADINGS = {
    "Drive": ("run", "scenarios", "console", "drive"),
    "Understand a run": ("explain", "replay", "report"),
    "Plan and track": ("plan", "track", "tune"),
    "Measure": ("bench", "reproduce", "spin-test"),
    "Set up": ("doctor",),
}


def put_in_order(app: typer.Typer) -> None:
    """Give every command its heading and its place; one that is named nowhere comes last."""
    places = {
        name: (place, heading)
        for place, (heading, name) in enumerate(
            (heading, name) for heading, names in HEADINGS.items() for name in names
        )
    }
    last = len(places)
    for command in app.registered_commands:
        command.help = command.help or _paragraphs(command.callback)
    for command in [*app.registered_commands, *app.registered_groups]:
        heading = places.get(_name(command), (last, "Others"))[1]
        command.rich_help_panel = heading
    app.registered_commands.sort(key=lambda each: places.get(_name(each), (last, ""))[0])


def _paragraphs(callback: object) -> str:
    """The docstring with each paragraph in one line, to be wrapped to the terminal."""
    text = inspect.getdoc(callback) or ""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.split("\n\n"))


def _name(command: object) -> str:
    name = getattr(command, "name", None)
    callback = getattr(command, "callback", None)
    return name or getattr(callback, "__name__", "")
