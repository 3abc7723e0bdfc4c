"""How every command behaves, whoever wrote it: help, JSON, headings, completion, endings."""

import json
import re
import subprocess
import sys

import pytest
import typer

from cairn.cli import app, main, root
from cairn.cli.order import HEADINGS

GROUP = typer.main.get_command(app)
CAIRN = [sys.executable, "-c", "from cairn.cli import main; main()"]
# Commands with nothing to print for a machine: they open a window on something that goes on.
WITHOUT_JSON = {("console",)}


def leaves(group=GROUP, names=()):
    """(names, command) of every command that does something."""
    for name, each in group.commands.items():
        if hasattr(each, "commands"):
            yield from leaves(each, (*names, name))
        else:
            yield (*names, name), each


COMMANDS = dict(leaves())


def ids(names):
    return " ".join(names)


@pytest.mark.parametrize("names", COMMANDS, ids=ids)
def test_help_says_what_it_does_and_what_each_option_means(command, names):
    code, said, _ = command(*names, "-h")
    assert code == 0
    assert COMMANDS[names].help
    for each in COMMANDS[names].params:
        assert each.help, f"{names}: {each.opts} has no help"
        assert not re.search(r"\[\w[^\]]*\]", each.help), (
            "rich takes [..] for a colour and drops it"
        )
        assert each.opts[0] in said or (each.metavar or each.name).strip("[].") in said


@pytest.mark.parametrize("names", COMMANDS, ids=ids)
def test_every_argument_is_shown_in_capitals(names):
    for each in COMMANDS[names].params:
        if not each.opts[0].startswith("-"):
            assert each.metavar, f"{names}: {each.name}"
            assert each.metavar == each.metavar.upper()


@pytest.mark.parametrize("names", COMMANDS, ids=ids)
def test_every_command_has_json_for_machines(names):
    options = {option for each in COMMANDS[names].params for option in each.opts}
    assert "--json" in options or names in WITHOUT_JSON


def test_every_command_stands_under_a_heading():
    listed = {name for names in HEADINGS.values() for name in names}
    assert set(GROUP.commands) <= listed


@pytest.mark.parametrize(
    "arguments",
    [
        ["doctor"],
        ["scenarios"],
        ["reproduce", "--list"],
        ["plan", "room", "--goal", "goal"],
        ["run", "quick", "--no-picture"],
    ],
    ids=ids,
)
def test_json_is_all_that_is_printed_and_has_a_summary(command, arguments):
    code, said, complaints = command(*arguments, "--json")
    assert (code, complaints) == (0, "")
    assert json.loads(said)["summary"]


def test_a_bug_of_ours_is_code_1_and_one_line_with_the_traceback_in_a_file(
    monkeypatch, capsys, tmp_path
):
    def fails(**_):
        raise ZeroDivisionError("once in a million")

    monkeypatch.setattr(root, "app", fails)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(SystemExit) as left:
        main()
    said = capsys.readouterr()
    assert left.value.code == 1
    assert "once in a million" in said.err
    assert "bug in cairn" in said.err
    assert "Traceback" not in said.out + said.err
    assert "in fails" in (tmp_path / "cairn-error.txt").read_text()


def test_a_reader_that_has_had_enough_is_no_error():
    with subprocess.Popen(
        [*CAIRN, "scenarios"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as program:
        program.stdout.close()
        assert program.stderr.read() == b""


def test_an_interrupt_ends_with_code_130(monkeypatch, capsys):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("cairn.cli.run.Scenario.load", interrupted)
    monkeypatch.setattr(sys, "argv", ["cairn", "run", "quick"])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 130
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_can_be_shown_for_the_shells_people_use(monkeypatch, command, shell):
    monkeypatch.setenv("_CAIRN_COMPLETE", f"source_{shell}")
    code, said, _ = command()
    assert code == 0
    assert "_CAIRN_COMPLETE" in said


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("cairn sc", "scenarios"),
        ("cairn run off", "office"),
        ("cairn plan ware", "warehouse"),
        ("cairn plan room --robot p3", "p3at"),
        ("cairn bench n", "nav"),
        ("cairn run quick --rec", "--record"),
    ],
)
def test_a_shell_completes_commands_options_and_shipped_names(monkeypatch, capsys, typed, offered):
    monkeypatch.setenv("_CAIRN_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", str(len(typed.split()) - 1))
    monkeypatch.setattr(sys, "argv", ["cairn"])
    with pytest.raises(SystemExit):
        main()
    assert offered in capsys.readouterr().out.split()
