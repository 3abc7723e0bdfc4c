"""A report in a real browser: it plays, and it asks for nothing from outside."""

import re
import time

import pytest

import chromium
from cairn.missions import Scenario, retelling, run
from cairn.record import Recorder
from cairn.view.report import write_run

pytestmark = pytest.mark.skipif(
    chromium.installed() is None,
    reason="no Chromium: `make test-browser` brings one, or install Debian's `chromium`",
)
ROOM = {
    "name": "played",
    "map": "room",
    "robot": "kinematic",
    "timeout_s": 8.0,
    "start": {"place": "start"},
    "goals": [{"place": "goal"}],
}
SLIDER = "+document.querySelector('.player input').value"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    with Recorder(folder) as recorder:
        run(Scenario.model_validate(ROOM), observers=[recorder])
    story = retelling.of_record(folder)
    path = write_run(story, folder / "report.html")
    text = path.read_text(encoding="utf-8")  # errors of scripts are kept for the tests to read
    catch = "<head><script>wrong = []; onerror = (...e) => wrong.push(String(e))</script>"
    path.write_text(text.replace("<head>", catch, 1), encoding="utf-8")
    with chromium.Chromium() as browser:
        browser.goto(path.as_uri())
        waiting(lambda: browser.read("document.readyState") == "complete")
        yield browser, story
        assert browser.read("wrong.join()") == ""


def waiting(holds):
    began = time.monotonic()
    while time.monotonic() - began < 60.0:
        if found := holds():
            return found
        time.sleep(0.05)
    raise AssertionError("never came")


def robot_at(browser):
    moved = browser.read("document.querySelector('#map .robot').getAttribute('transform')")
    x, y, turned = re.match(r"translate\((\S+) (\S+)\) rotate\((\S+)\)", moved).groups()
    return float(x), -float(y), -float(turned)


def test_a_report_asks_for_nothing_from_outside(page):
    browser, _ = page
    assert browser.read("performance.getEntriesByType('resource').length") == 0
    assert browser.read("getComputedStyle(document.querySelector('.player')).display") == "grid"


def test_a_click_on_a_moment_shows_the_robot_there(page):
    browser, story = page
    robot = story.robots[0]
    for number, transition in enumerate(robot.transitions):
        browser.read(f"document.querySelectorAll('.events button')[{number}].click()")
        assert browser.read(SLIDER) == pytest.approx(transition["time_s"], abs=0.05)
        x, y, _ = robot.truth[robot.at(transition["time_s"])]
        assert robot_at(browser)[:2] == pytest.approx((x, y), abs=1e-3)
        assert robot.sentence[robot.at(transition["time_s"])] in browser.text


def test_it_plays_to_the_end(page):
    browser, story = page
    browser.read("document.querySelector('.pace').click()")  # faster
    browser.read("document.querySelector('.player .play').click()")
    waiting(lambda: browser.read(SLIDER) > 0.5 or None)
    waiting(lambda: browser.read(SLIDER) >= story.duration_s - 0.11)
    assert robot_at(browser)[:2] == pytest.approx(story.robots[0].truth[-1, :2], abs=1e-3)
    assert "play" in browser.read("document.querySelector('.player .play').innerText")


def test_the_mouse_over_a_chart_moves_the_robot_along(page):
    browser, story = page
    box = browser.read(
        "(() => { const c = document.querySelectorAll('.chart')[1]; c.scrollIntoView();"
        "const r = c.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()"
    )
    share = 0.5
    x = box[0] + box[2] * (62 + (986 - 62) * share) / 1000
    at = {"x": x, "y": box[1] + box[3] / 2}
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", **at)
    wanted = share * story.duration_s
    waiting(lambda: abs(browser.read(SLIDER) - wanted) < 0.1)


def test_the_theme_is_the_readers_choice(page):
    browser, _ = page
    colour = "getComputedStyle(document.body).backgroundColor"
    before = browser.read(colour)
    browser.read("document.querySelector('.theme').click()")
    assert browser.read(colour) != before
    browser.read("document.querySelector('.theme').click()")
    assert browser.read(colour) == before
