"""`cairn explain` and `cairn replay`: what a recorded run says, and whether it still comes out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.padding import Padding
from rich.table import Table

from cairn import errors
from cairn.cli.progress import bar
from cairn.cli.root import app, console, print_json
from cairn.missions.result import EXIT_NOT_REACHED, EXIT_OK
from cairn.navigator import Navigator
from cairn.record import (
    Difference,
    Replay,
    RobotStory,
    Run,
    open_run,
    replay,
    tell_run,
    tell_tick,
    words,
)
from cairn.strict_json import plain

RunArgument = Annotated[
    Path, typer.Argument(metavar="RUN", help="The folder of a run, or its run.mcap.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON, nothing else.")]


@app.command("explain")
def explain(
    run: RunArgument,
    at: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Explain the tick at this time.")
    ] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of this robot; by default the first.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Tell why a recorded run went as it did, or why the robot did what it did at one moment."""
    recorded = open_run(run)
    if at is None:
        _tell_run(recorded, robot, as_json)
    else:
        _tell_tick(recorded, at, robot, as_json)


def _tell_tick(run: Run, at: float, robot: str | None, as_json: bool) -> None:
    tick = run.at(at, robot) if math.isfinite(at) else None
    if tick is None:
        raise errors.TickNotRecorded(
            f"{run.path} has no tick at {at:g} s: it begins at 0 s", path=str(run.path), time_s=at
        )
    told = tell_tick(tick)
    if as_json:
        decision = tick["decision"]
        summary = {
            "time_s": tick["time_s"],
            "robot": tick["robot"],
            "mode": decision["mode"],
            "reason": decision["reason"],
            "sentence": decision["sentence"],
        }
        story = {paragraph.heading: paragraph.sentences for paragraph in told}
        print_json(plain({"summary": summary, "story": story, "tick": tick}))
        return
    console.print(f"[bold]{tick['robot']}[/] at [bold]{tick['time_s']:g} s[/]")
    for paragraph in told:
        console.print(f"\n[cyan]{paragraph.heading}[/]")
        for sentence in paragraph.sentences:
            _say(sentence)


def _tell_run(run: Run, robot: str | None, as_json: bool) -> None:
    stories = tell_run(run, robot)
    summary = (run.summary or {}).get("summary", {})
    if as_json:
        head = {
            "scenario": run.scenario.get("name"),
            "seed": run.seed,
            "complete": run.complete,
            "sentence": summary.get("sentence"),
            "exit_code": summary.get("exit_code"),
        }
        print_json(plain({"summary": head, "robots": [story.to_dict() for story in stories]}))
        return
    name = run.scenario.get("name", run.path.parent.name)
    console.print(f"[bold]{name}[/], seed {run.seed}: ", end="")
    ending = summary.get("sentence") or "cut off: the log ends before the run did."
    console.print(ending, markup=False, highlight=False, soft_wrap=True)
    for story in stories:
        _print_story(story)
    moment = next((each.time_s for story in stories for each in story.moments[1:]), 0.0)
    console.print(f"\n[dim]cairn explain {run.path.parent} --at {moment:g}[/]")


def _print_story(story: RobotStory) -> None:
    console.print(f"\n[bold]{story.robot}[/]")
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(justify="right", style="dim", no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column(ratio=1)
    for moment in story.moments:
        colour = {"recovery": "yellow", "refusal": "red", "goal": "green"}.get(moment.kind, "cyan")
        what = words.MODES[moment.mode] if moment.kind == "mode" else moment.kind
        again = ""
        if moment.times > 1:
            again = f" [dim]({moment.times} times, the last at {moment.until_s:g} s)[/]"
        table.add_row(f"{moment.time_s:g} s", f"[{colour}]{what}[/]", f"{moment.sentence}.{again}")
    console.print(table)
    console.print()
    for sentence in story.ending:
        _say(sentence)


def _say(sentence: str) -> None:
    # Padded by rich, so that a sentence that wraps stays under itself.
    from rich.text import Text

    console.print(Padding(Text(sentence), (0, 0, 0, 2)))


@app.command("replay")
def replay_command(
    run: RunArgument,
    controller: Annotated[
        str | None,
        typer.Option(help="Replay with this fuzzy controller instead: a name or a file."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Drive the navigator with a run's inputs again: the same commands must come out, to the bit.

    Exit code 0: they do. 3: they do not, and it says where first and in what.
    """
    recorded = open_run(run)

    def other(name: str, recipe: dict[str, Any]) -> Navigator:
        from cairn.tracking import controller_text

        assert controller is not None
        changed = {**recipe, "controller": controller_text(controller)}
        return Navigator.from_recipe(changed, recorded.map(name))

    with bar() as shown:
        task = shown.add_task("replaying", total=None)
        played = replay(
            recorded,
            make=other if controller else None,
            observer=lambda done, total: shown.update(task, completed=done, total=total),
        )
    ticks = sum(played.ticks.values())
    sentence = _verdict(recorded, played, ticks)
    if as_json:
        summary = {"same": played.is_same, "ticks": ticks, "sentence": sentence}
        print_json(
            plain(
                {
                    "summary": summary,
                    "robots": played.ticks,
                    "differences": [vars(found) for found in played.differences],
                    "first_commands": [vars(found) for found in played.command_from.values()],
                }
            )
        )
    else:
        console.print(sentence, markup=False, highlight=False, soft_wrap=True)
        for found in played.differences:
            _print_difference(found, played.command_from.get(found.robot))
    raise typer.Exit(EXIT_OK if played.is_same else EXIT_NOT_REACHED)


def _verdict(run: Run, played: Replay, ticks: int) -> str:
    if played.is_same:
        whole = "" if run.complete else ", as far as the log goes"
        return f"{ticks} ticks, every decision the same to the bit{whole}."
    return f"{ticks} ticks; the replay differs from the log."


def _print_difference(found: Difference, command: Difference | None) -> None:
    console.print(f"\n[bold]{found.robot}[/]")
    _say(f"First at {found.time_s:g} s (tick {found.tick}), in {found.key}:")
    _say(f"  in the log {found.logged!r}, now {found.replayed!r}")
    if command is None:
        _say("No command differs.")
    else:
        _say(
            f"The first command that differs is that of {command.time_s:g} s (tick {command.tick})."
        )
