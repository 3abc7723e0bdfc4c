import itertools
import json
import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from cairn import errors
from cairn.cli import app
from cairn.missions import Scenario, retelling, run
from cairn.record import Recorder, open_run, write_summary
from cairn.view import animation
from cairn.view.report import bench, heat, svg, write_bench, write_run
from cairn.view.report import run as run_page
from cairn.view.report.gallery import write_gallery
from cairn.view.story import tell

HOSTILE = '<script>alert("1")</script> & "quotes" \']]> </script>'
ROOM = {
    "name": "told",
    "description": HOSTILE,
    "map": "room",
    "robot": "kinematic",
    "timeout_s": 14.0,
    "start": {"place": "start"},
    "goals": [{"place": "goal"}],
    "boxes": [
        {"x_m": 3.6, "y_m": 2.6, "length_m": 0.5, "width_m": 0.5, "name": HOSTILE},
    ],
    "events": [{"do": "shove", "at_s": 9.0, "dy_m": 0.6}],
}
NAV = {
    "summary": {
        "worlds": 2, "trials": 4, "success": 0.75, "collision": 0.25, "timeout": 0.0, "error": 0.0,
        "score": 0.4, "score_old_cap": 0.2, "time_s": 7.0, "success_95": [0.3, 0.9],
        "score_95": [0.3, 0.45], "score_old_cap_95": [0.1, 0.2], "caveat": HOSTILE,
    },
    "by_difficulty": {}, "stack": "cairn", "robot": "jackal", "source": "made up", "seed": 1,
    "trials_per_world": 2, "wall": {"tick_mean_ms": 1.0, "tick_p99_ms": 2.0},
    "worlds": [
        {"world": "one", "success": 2, "collision": 0, "timeout": 0, "error": 0, "time_s": 7.0,
         "score": 0.5},
        {"world": HOSTILE, "success": 1, "collision": 1, "timeout": 0, "error": 0, "time_s": 7.0,
         "score": 0.3},
    ],
    "trials": [
        {"world": "two", "trial": 1, "outcome": "collision", "reason": HOSTILE, "time_s": 3.0},
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A recorded run: (result, ticks, story)."""
    folder = tmp_path_factory.mktemp("told")
    with Recorder(folder) as recorder:
        result = run(Scenario.model_validate(ROOM), observers=[recorder])
    write_summary(result.to_dict(), folder)
    return result, list(open_run(folder).ticks()), retelling.of_record(folder)


@pytest.fixture(scope="module")
def page(told, tmp_path_factory):
    return write_run(told[2], tmp_path_factory.mktemp("page") / "new" / "report.html")


def parsed(page):
    """The page as a tree: it is well-formed, also for readers stricter than browsers."""
    text = page.read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    return ElementTree.fromstring(text.removeprefix("<!DOCTYPE html>"))


def named(tree, tag):
    return [one for one in tree.iter() if one.tag.rpartition("}")[2] == tag]


def words_of(tree):
    return " ".join(" ".join(tree.itertext()).split())


def is_self_contained(page):
    tree = parsed(page)
    for one in tree.iter():
        for key in ("src", "href", "data", "srcset", "action", "poster"):
            assert (one.get(key) or "data:").startswith(("data:", "#")), one.attrib
    assert not named(tree, "link")
    assert not named(tree, "iframe")
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r"@import|url\((?!#)", text)
    assert set(re.findall(r"https?://[^\s\"<']+", text)) <= {"http://www.w3.org/1999/xhtml"}
    return tree


def test_a_report_is_one_valid_page_that_refers_to_nothing_outside(page):
    is_self_contained(page)


def test_a_report_says_every_transition_and_every_recovery(told, page):
    result, _, _ = told
    text = words_of(parsed(page))
    robot = result.robots[0]
    assert len(robot.transitions) > 2
    for transition in robot.transitions:
        assert " ".join(transition.sentence.split()) in text
    for recovered in robot.recoveries:
        assert recovered.cause.replace("_", " ") in text
        assert recovered.remedy.replace("_", " ") in text
    assert result.sentence[1:] in text


def test_text_of_a_scenario_stays_text(page):
    tree = parsed(page)
    assert HOSTILE in words_of(tree)
    assert len(named(tree, "script")) == 3  # data, player and theme: none from outside
    assert not any("alert" in (one.text or "") for one in named(tree, "script"))


def test_the_way_is_in_as_many_pieces_as_there_were_modes(told, page):
    robot = told[2].robots[0]
    modes = [mode for mode, _ in robot.pieces()]
    ways = [one.get("class") for one in named(parsed(page), "path") if one.get("class")]
    ways = [kind.split()[1] for kind in ways if kind.startswith("way ")]
    assert ways == modes
    assert all(before != after for before, after in itertools.pairwise(modes))
    assert len(modes) == len(robot.transitions) + 1


def test_a_shove_tears_the_way(told, page):
    ways = [o.get("d") for o in named(parsed(page), "path") if (o.get("class") or "") in TORN]
    pieces = told[2].robots[0].pieces()
    assert sum(way.count("M") for way in ways) == len(pieces) + 1


TORN = {f"way {mode}" for mode in ("stop", "path_planning", "path_tracking", "obstacle_avoidance")}


def test_the_player_knows_every_tick(told, page):
    data = next(o for o in named(parsed(page), "script") if o.get("id") == "run")
    robot = json.loads(data.text)["robots"][0]
    story = told[2].robots[0]
    assert {len(column) for column in robot.values() if column} == {len(story.time_s)}
    np.testing.assert_allclose(robot["x"], story.truth[:, 0], atol=6e-4)


def test_a_run_that_was_cut_off_is_told_from_its_ticks(told, tmp_path):
    result, ticks, _ = told
    story = tell(None, {"name": "torn"}, ticks[:-20])
    own = story.robots[0]
    wanted = [t.to_dict() for t in result.robots[0].transitions if t.time_s <= own.time_s[-1]]
    for transition, want in zip(own.transitions, wanted, strict=True):
        assert transition["sentence"] == want["sentence"]
        assert transition["event"] == want["event"]
    text = words_of(is_self_contained(write_run(story, tmp_path / "torn.html")))
    assert "cut off" in text


def test_numbers_of_a_cause_are_told_with_their_units():
    told = {"time_s": 1.0, "cause": "c", "remedy": "r", "ahead_m": 1.234, "detour": None}
    assert run_page._detail(told | {"at": {"x": 1.0, "y": -2.0}}) == (
        "ahead 1.23 m, detour none, at (1.00, -2.00) m"
    )


def test_a_story_has_every_plan_and_every_echo_of_the_log(told):
    result, ticks, story = told
    robot = story.robots[0]
    assert robot.echoes_m.shape == (len(ticks), len(story.sonars)) == (len(ticks), 16)
    assert np.isfinite(robot.echoes_m).any()
    walked = [points for _, points in robot.plans if len(points)]
    found = [
        plan for plan in result.robots[0].trace.plans if len(plan)
    ]  # a refused one leads nowhere
    assert len(found) > 0
    for plan in found:
        assert any(np.array_equal(points, plan) for points in walked)


def test_a_story_needs_a_tick():
    with pytest.raises(ValueError, match="one tick"):
        tell(None, {}, [])


def test_heats_have_a_row_for_every_rule_named(told):
    robot = told[2].robots[0]
    heats = heat.rule_heats(robot, told[2].duration_s)
    assert len(heats) == 3
    fired = {rule for t in robot.tracking if t for rule in t["look_ahead"]["rules"]}
    assert set(heats[0].names) == {heat.spoken(rule) for rule in fired}
    for one in heats:
        assert 0 < len(one.names) <= heat.RULES_AT_MOST
        assert 0 < sum(one.shares) <= 1 + 1e-9
        assert one.picture.startswith("data:image/png;base64,")


def test_a_long_line_is_thinned_without_losing_its_extremes():
    rng = np.random.default_rng(1)
    values = rng.normal(size=20_000)
    values[777], values[12_345] = -50.0, 50.0
    values[500:510] = math.nan
    times, kept = svg.thinned(np.arange(20_000.0), values)
    assert len(kept) <= svg.POINTS_AT_MOST
    assert (np.nanmin(kept), np.nanmax(kept)) == (-50.0, 50.0)
    assert (np.diff(times) > 0).all()


def test_a_report_of_navigation_names_every_trial_that_did_not_arrive(tmp_path):
    tree = is_self_contained(write_bench(NAV, tmp_path / "nav.html", source="somewhere"))
    text = words_of(tree)
    assert "3 of 4 arrived" in text
    assert HOSTILE in text
    assert not any("alert" in (one.text or "") for one in named(tree, "script"))


def test_bars_are_as_long_as_their_parts():
    (whole,) = [bench.stacked([("a", [("track", 3), ("box", 1)], ""), ("b", [("track", 2)], "")])]
    widths = [float(one.get("width")) for one in named(ElementTree.fromstring(whole), "rect")]
    assert widths[0] == pytest.approx(3 * widths[1], abs=0.2)
    assert widths[2] == pytest.approx(2 * widths[1], abs=0.2)


def test_any_other_benchmark_is_told_as_tables(tmp_path):
    record = {
        "summary": {"agree": True},
        "maps": [{"map": "m", "ms": 1.5}, {"map": "n", "ms": None}],
    }
    tree = is_self_contained(write_bench(record, tmp_path / "other.html"))
    assert [cell.text for cell in named(tree, "td")] == ["m", "1.5", "n", "–"]


def test_a_gallery_holds_its_pictures(tmp_path):
    Image.new("RGB", (4, 3)).save(tmp_path / "one.png")
    caption = {"source": HOSTILE, "made_from": "this", "agrees": ["yes"], "differs": ["no"]}
    entry = {"name": "one", "title": "One", "caption": caption, "pictures": [tmp_path / "one.png"]}
    tree = is_self_contained(write_gallery([entry], {"fig13": "a photograph"}, tmp_path / "i.html"))
    assert len(named(tree, "img")) == 1
    assert "a photograph" in words_of(tree)


@pytest.mark.parametrize("suffix", [".gif", ".webp", ".png"])
def test_an_animation_plays_the_run_and_holds_its_end(told, suffix, tmp_path):
    path = animation.animate(told[2], tmp_path / f"run{suffix}", seconds=1.0, rate=8, width_px=320)
    with Image.open(path) as moving:
        assert 4 <= moving.n_frames <= 8  # pictures that are equal may be one
        first = np.asarray(moving.convert("RGB")).astype(int)
        moving.seek(moving.n_frames - 1)
        last = np.asarray(moving.convert("RGB")).astype(int)
        assert moving.info["duration"] >= 1000 * animation.HOLD_S
    assert np.abs(first - last).max() > 60
    assert path.stat().st_size < 1.5e6


def test_an_animation_of_another_kind_is_refused(told, tmp_path):
    with pytest.raises(errors.AnimationFormatUnknown) as refused:
        animation.animate(told[2], tmp_path / "run.mp4")
    assert refused.value.known == animation.FORMATS


def test_a_recorded_run_is_reported_and_animated_again(tmp_path):
    scenario = tmp_path / "told.toml"
    scenario.write_text(
        'name = "told"\nmap = "room"\nrobot = "kinematic"\ntimeout_s = 3.0\n'
        'start = { place = "start" }\n[[goals]]\nplace = "goal"\n'
    )
    folder = tmp_path / "run"
    done = CliRunner().invoke(app, ["run", str(scenario), "--record", str(folder)])
    assert done.exit_code == 3, done.output
    first = words_of(is_self_contained(folder / "report.html"))
    again = CliRunner().invoke(app, ["report", str(folder), "--out", str(tmp_path / "again.html")])
    assert again.exit_code == 0, again.output
    assert words_of(is_self_contained(tmp_path / "again.html")).split()[:30] == first.split()[:30]
    moved = CliRunner().invoke(app, ["report", str(folder), "--animate", str(tmp_path / "a.gif")])
    assert moved.exit_code == 0, moved.output
    assert (tmp_path / "a.gif").exists()


def test_what_is_no_record_is_refused_by_name(tmp_path):
    for name, content in (("a.json", "{"), ("b.json", "{}"), ("c.json", '{"scenario": {}}')):
        (tmp_path / name).write_text(content)
        refused = CliRunner().invoke(app, ["report", str(tmp_path / name)])
        assert isinstance(refused.exception, errors.NothingToReport)
    refused = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert isinstance(refused.exception, errors.NothingToReport)


def test_what_stands_between_backticks_is_code_and_still_escaped(tmp_path):
    said = {"source": "from `a<b`", "made_from": "one ` alone", "agrees": ["<i>"], "differs": []}
    entry = {"name": "fig1", "title": "t", "caption": said, "pictures": []}
    page = write_gallery([entry], {}, tmp_path / "i.html").read_text()
    assert "from <code>a&lt;b</code>" in page
    assert "one ` alone" in page
    assert "&lt;i&gt;" in page
