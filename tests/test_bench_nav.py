"""The navigation benchmark: its command and what comes out of it."""

import json

import pytest
from typer.testing import CliRunner

from cairn import errors
from cairn.cli import app
from cairn.experiments.nav import bench
from cairn.experiments.nav.generator import generated


def straight_on(task):
    """A stack: full speed ahead, whatever comes."""
    return lambda seen: (1.0, 0.0)


def run(*options, stack="cairn"):
    """The record that the command prints."""
    given = ["bench", "nav", "--stack", stack, "--trials", "2", "--processes", "1", "--json"]
    result = CliRunner().invoke(app, [*given, *options])
    assert result.exit_code == 0, result.output
    return json.loads(result.output)


def test_the_command_prints_a_summary_with_every_share_and_both_scores(tmp_path):
    record = run("--indices", "3,5", "--out", str(tmp_path), stack="test_bench_nav:straight_on")
    summary = record["summary"]
    shares = [summary[key] for key in ("success", "collision", "timeout", "error")]
    assert sum(shares) == pytest.approx(1.0)
    assert 0 <= summary["score_old_cap"] <= summary["score"] <= 0.5
    assert "not rankable" in summary["caveat"]
    assert [row["world"] for row in record["worlds"]] == ["generated_3", "generated_5"]
    assert json.loads((tmp_path / "summary.json").read_text()) == record


@pytest.mark.parametrize("name", ["nothing", "no_such_module:f", "math:no_such", "math:pi"])
def test_a_stack_that_is_none_is_refused_by_name(name):
    with pytest.raises(errors.StackNotFound) as caught:
        bench.Settings(name, [generated(0)]).check()
    assert caught.value.name == name
