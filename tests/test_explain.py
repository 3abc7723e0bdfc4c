"""What is told of a run: every key documented, every code worded, every refusal explained."""

import json
import math
import re
from pathlib import Path

import pytest

from cairn.missions import Scenario, run
from cairn.record import Recorder, open_run, tell_run, tell_tick, words, write_summary

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs/decision-record.md").read_text()
BRAIN = ROOT / "crates/cairn/src"
PLAIN = {"x", "y", "heading", "linear_mps", "angular_radps"}  # of points, poses and speeds
SCENARIOS = ("quick", "crate", "walled_in", "doorstep")
REFUSED = """
name = "refused"
map = "room"
robot = "kinematic"
pose = "odometry"
start = { place = "start" }
goals = [{ x_m = 3.25, y_m = 0.5, expect = "refused" }]
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Short runs of several kinds, by name."""
    folder = tmp_path_factory.mktemp("runs")
    refused = folder / "refused.toml"
    refused.write_text(REFUSED)
    made = {}
    for name in (*SCENARIOS, str(refused)):
        scenario = Scenario.load(name)
        short = {"robot": "kinematic", "timeout_s": min(scenario.timeout_s, 40.0)}
        scenario = scenario.model_copy(update=short)
        where = folder / scenario.name
        with Recorder(where) as recorder:
            result = run(scenario, observers=[recorder])
        write_summary(result.to_dict(), where)
        made[scenario.name] = open_run(where)
    return made


def leaves(value, path=""):
    if isinstance(value, dict) and value:
        for key, item in value.items():
            yield from leaves(item, f"{path}.{key}" if path else key)
    elif isinstance(value, list) and value:
        for item in value:
            yield from leaves(item, f"{path}[]")
    else:
        yield path


def documented_keys():
    rows = [line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `")]
    return {key for row in rows for key in re.findall(r"`([^`]+)`", row) if not key.startswith("/")}


def test_every_key_that_occurs_is_documented(runs):
    patterns = [
        re.compile(
            "".join("[^.]+" if part == "*" else re.escape(part) for part in re.split(r"(\*)", key))
        )
        for key in documented_keys()
    ]
    seen = {
        path for made in runs.values() for tick in made.ticks() for path in leaves(tick["decision"])
    }

    def is_documented(path):
        while path:
            if any(pattern.fullmatch(path) for pattern in patterns):
                return True
            path, _, last = path.rpartition(".") if not path.endswith("[]") else (path[:-2], "", "")
            if last and last not in PLAIN:
                return False
        return False

    # Rules are sentences with dots in their numbers.
    seen = {re.sub(r"(\.rules)\..*", r"\1.rule", path) for path in seen}
    containers = {key.split(".")[0] for key in documented_keys()}
    unknown = {path for path in seen if not is_documented(path) and path not in containers}
    # A part that is null in a tick is documented by what it holds in others.
    unknown = {
        path
        for path in unknown
        if not any(key.startswith((path + ".", path + "[]")) for key in documented_keys())
    }
    assert not unknown


def test_every_documented_part_of_a_decision_occurs(runs):
    seen = {key for tick in runs["quick"].ticks() for key in tick["decision"]}
    assert {re.split(r"[.\[]", key)[0] for key in documented_keys()} == seen


def codes(enum, file):
    """The codes of a Rust enum, as serde writes them."""
    text = (BRAIN / file).read_text()
    body = re.search(rf"pub enum {enum} \{{(.*?)\n\}}", text, re.DOTALL)[1]
    variants = re.findall(r"^    ([A-Z]\w*)", body, re.MULTILINE)
    return {re.sub(r"(?<!^)(?=[A-Z])", "_", variant).lower() for variant in variants}


@pytest.mark.parametrize(
    ("enum", "file", "table"),
    [
        ("Mode", "navigate/strategy.rs", words.MODES),
        ("Cap", "track/tracker.rs", words.CAPS),
        ("BrakeReason", "avoid/record.rs", words.BRAKES),
        ("Refusal", "avoid/record.rs", words.REFUSED),
        ("Cause", "navigate/recovery.rs", words.CAUSES),
        ("Remedy", "navigate/recovery.rs", words.REMEDIES),
        ("Refusal", "navigate/planning.rs", words.REFUSALS),
        ("TaskStatus", "navigate/record.rs", words.STATUS),
        ("LocaliseState", "locate/localiser.rs", words.STATES),
    ],
)
def test_every_code_has_its_words(enum, file, table):
    assert table.keys() == codes(enum, file)


@pytest.mark.parametrize("refusal", words.REFUSALS)
def test_every_refusal_is_documented_by_its_code(refusal):
    assert f"`{refusal}`" in PAGE


def test_every_tick_of_every_run_can_be_told(runs):
    for made in runs.values():
        for tick in made.ticks():
            told = tell_tick(tick)
            assert told[0].sentences[0] == tick["decision"]["sentence"]
            text = " ".join(sentence for paragraph in told for sentence in paragraph.sentences)
            assert not re.search(r"\b(nan|None|inf)\b", text), text


def test_the_fuzzy_rules_are_told_strongest_first(runs):
    tick = next(tick for tick in runs["quick"].ticks() if tick["decision"]["tracking"])
    rules = tick["decision"]["tracking"]["tracker"]["rules"]
    strongest = max(rules, key=rules.get)
    (told,) = [each for each in tell_tick(tick) if each.heading == "Fuzzy rules"]
    first = next(line for line in told.sentences if words.rule(strongest) in line)
    assert f"{rules[strongest]:.2f}" in first


def test_the_terms_told_of_the_chosen_arc_add_up_to_its_score(runs):
    ticks = [
        tick
        for tick in runs["walled_in"].ticks()
        if (tick["decision"]["avoidance"] or {}).get("chosen") is not None
        and not tick["decision"]["avoidance"]["guided"]
    ]
    assert ticks
    for tick in ticks:
        seen = tick["decision"]["avoidance"]
        one = seen["candidates"][seen["chosen"]]
        total = sum(seen["weights"][name] * one[name] for name in ("speed", "distance", "heading"))
        assert math.isclose(total, one["total"], rel_tol=1e-12)


def test_a_refused_goal_tells_its_code_what_it_means_and_what_would_help(runs):
    (story,) = tell_run(runs["refused"])
    assert (story.status, story.refusal["code"]) == ("refused", "goal_blocked")
    text = " ".join(story.ending)
    assert "`goal_blocked`" in text
    assert "would help" in text
    assert [each.kind for each in story.moments][-1] == "refusal"


def test_a_story_has_every_change_of_mode_and_how_it_ended(runs):
    made = runs["crate"]
    (story,) = tell_run(made)
    told = [(each.time_s, each.mode) for each in story.moments if each.kind == "mode"]
    changes = made.summary["robots"][0]["transitions"]
    assert set(told[1:]) >= {(each["time_s"], each["to"]) for each in changes[:3]}
    assert any("The judge" in line for line in story.ending)


def test_explain_prints_the_story_and_the_tick(command, runs):
    folder = runs["quick"].path.parent
    code, said, _ = command("explain", folder)
    assert code == 0
    assert "quick, seed" in said
    assert "arrived" in said
    code, said, _ = command("explain", folder, "--at", "3.05", "--robot", "robot")
    assert code == 0
    assert "Fuzzy rules" in said
    code, said, _ = command("explain", folder, "--at", "3.05", "--json")
    record = json.loads(said)
    assert record["summary"]["time_s"] == 3.0
    assert record["story"]["Mode"][0] == record["tick"]["decision"]["sentence"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["nowhere"], "LogUnreadable"),
        (["{}", "--at", "-1"], "TickNotRecorded"),
        (["{}", "--robot", "marvin"], "RobotUnknown"),
    ],
)
def test_explaining_what_is_not_there_is_exit_code_2(command, runs, arguments, complaint):
    folder = runs["quick"].path.parent
    code, _, complaints = command("explain", *(text.format(folder) for text in arguments))
    assert code == 2
    assert complaint in complaints
