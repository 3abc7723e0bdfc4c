"""The console in a real browser: a person clicks, and the robot goes."""

import math
import time

import numpy as np
import pytest
from PIL import Image

import chromium
from cairn.missions import Scenario
from cairn.missions.live import Live, with_nothing_to_do
from cairn.view.console import commands as ask
from cairn.view.console.server import Console

pytestmark = pytest.mark.skipif(
    chromium.installed() is None,
    reason="no Chromium: install Debian's `chromium`, or name one by CAIRN_CHROMIUM",
)
# The room is 8 by 6 metres; its middle is (4, 3), and so is the screen's.
ROOM = with_nothing_to_do(Scenario.load("quick"))
PATIENCE_S = 120.0


def waiting(holds, what):
    began = time.monotonic()
    while time.monotonic() - began < PATIENCE_S:
        if found := holds():
            return found
        time.sleep(0.1)
    raise AssertionError(f"never came: {what}")


@pytest.fixture(scope="module")
def browser():
    with chromium.Chromium() as found:
        yield found


@pytest.fixture
def seen(browser):
    """A paused run of the room with the browser before it: (run, page, browser)."""
    live = Live(ROOM, speed=4.0, open_end=True, paused=True).start()
    page = Console(live, port=0)
    browser.goto(page.url)
    waiting(lambda: "time has not begun" in browser.text, "the words")
    waiting(lambda: page.visitors and page.drawn, "the drawing")
    sizes = []

    def settled():
        sizes.append(browser.canvas())
        return len(sizes) > 10 and sizes[-10:].count(sizes[-1]) == 10

    waiting(settled, "rest")
    yield live, page, browser
    browser.goto("about:blank")
    page.stop()
    if not live.ended:
        live.end()


def middle(browser):
    x, y, width, height = browser.canvas()
    return x + width / 2, y + height / 2


def test_a_click_in_the_middle_of_the_map_brings_the_robot_there_and_the_page_says_so(
    seen, tmp_path
):
    live, _, browser = seen
    browser.click(*middle(browser))
    goal = waiting(lambda: live.snapshot().robots[0].goal, "a goal")
    assert goal == pytest.approx((4.0, 3.0), abs=0.1)
    live.do(ask.Pause(False))
    waiting(lambda: live.snapshot().robots[0].driven_m > 0.5, "a drive")
    live.do(ask.Pause())  # for as long as this browser takes to draw
    waiting(lambda: "Path tracking" in browser.text, "the mode")
    waiting(lambda: "Rules for V" in browser.text, "the rules")
    shot = Image.open(browser.screenshot(tmp_path / "driving.png")).convert("RGB")
    live.do(ask.Pause(False))
    waiting(lambda: live.snapshot().robots[0].goals, "the arrival")
    assert math.dist(live.snapshot().robots[0].truth[:2], goal) < 0.3
    waiting(lambda: "reached (4.0" in browser.text, "the arrival in words")
    assert live.end().exit_code == 0
    # The picture of the drive shows walls, floor, the plan and the robot in its mode's colour.
    x, y, width, height = (int(v) for v in browser.canvas())
    pixels = np.asarray(shot.crop((x, y, x + width, y + height))).reshape(-1, 3).astype(int)
    for colour, least in (((61, 74, 87), 2000), ((251, 250, 246), 20_000), ((63, 111, 181), 100)):
        near = np.abs(pixels - colour).max(axis=1) < 12
        assert near.sum() > least, f"{colour} is missing"


@pytest.mark.slow
def test_a_box_dropped_with_shift_stands_in_the_simulation(seen):
    live, _, browser = seen
    before = live.snapshot().robots[0].clearance_m
    x, y = middle(browser)
    browser.click(x, y, modifiers=chromium.SHIFT)
    box = waiting(lambda: live.snapshot().boxes, "a box")[0]
    assert (box.x, box.y) == pytest.approx((4.0, 3.0), abs=0.1)
    live.do(ask.Step())
    waiting(lambda: live.snapshot().boxes[0].standing, "a body")
    assert live.snapshot().robots[0].goal is None
    assert live.snapshot().robots[0].clearance_m <= before


@pytest.mark.slow
def test_the_stop_button_and_pause_are_within_reach(seen):
    live, _, browser = seen
    live.do(ask.Pause(False))
    live.do(ask.DriveTo(7.0, 5.0))
    live.do(ask.Speed(0.5))
    waiting(lambda: live.snapshot().robots[0].driven_m > 0.3, "a drive")
    browser.click(*browser.middle_of("STOP"))
    ended = waiting(lambda: live.snapshot().robots[0].goals, "the stop")
    assert ended[0]["outcome"] == "cancelled"
    browser.click(*browser.middle_of("Pause"))
    stopped = waiting(lambda: live.snapshot().paused and live.snapshot(), "the pause")
    browser.click(*browser.middle_of("One tick"))
    later = waiting(lambda: live.snapshot().time_s > stopped.time_s and live.snapshot(), "a tick")
    assert later.time_s == pytest.approx(stopped.time_s + 0.1)
