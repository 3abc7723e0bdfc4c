"""The console's server, spoken to through its websocket as a browser does, without one."""

import contextlib
import math
import sys
import threading
import time

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from cairn import errors
from cairn.missions import Scenario
from cairn.missions.live import Live, with_nothing_to_do
from cairn.view.console import commands as ask
from cairn.view.console.server import Console

ROOM = with_nothing_to_do(Scenario.load("quick"))
# Above the point (x, y) of the floor, looking down.
CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (0.0, 1.0, 0.0, 0.0), "position": (4.0, 3.0, 30.0),
    "fov": 0.3, "near": 0.1, "far": 100.0, "image_height": 800, "image_width": 1000,
    "look_at": (4.0, 3.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip


class Recorded:
    """A source that has one snapshot and notes what is asked of it."""

    def __init__(self):
        live = Live(ROOM, paused=True, open_end=True).start()
        self.snapshot = live.newer(0, 10.0)
        live.end()
        self.asked = []

    def newer(self, than, timeout_s):
        time.sleep(0.01)
        return self.snapshot if than < self.snapshot.number else None

    def do(self, command):
        self.asked.append(command)


@contextlib.contextmanager
def a_console(source, **options):
    page = Console(source, port=0, **options)
    try:
        yield page
    finally:
        page.stop()


@contextlib.contextmanager
def a_browser(page, cookie=None):
    """What a browser's page does: connect, tell its camera, take what comes."""
    port = page.url.rpartition(":")[2].partition("/")[0]
    wire = connect(
        f"ws://127.0.0.1:{port}/",
        subprotocols=[f"viser-v{viser.__version__}"],
        additional_headers={"Cookie": cookie} if cookie else None,
        max_size=None,
        close_timeout=0.1,
    )
    with wire:
        wire.send(msgspec.msgpack.encode(CAMERA))
        waiting(lambda: page.visitors)
        yield wire


def click(wire, x, y, modifier=None):
    ray = {"ray_origin": (x - 1.0, y, 10.0), "ray_direction": (0.1, 0.0, -1.0)}
    message = {"type": "ScenePointerMessage", "event_type": "click", **ray,
               "screen_pos": ((0.5, 0.5),), "modifier": modifier}  # fmt: skip
    wire.send(msgspec.msgpack.encode(message))


def read_on(wire):
    """Take all that comes until the page is closed."""
    with contextlib.suppress(ConnectionClosed):
        while True:
            wire.recv()


def waiting(holds):
    """Wait until something holds that another thread does."""
    for _ in range(2000):
        if found := holds():
            return found
        time.sleep(0.01)
    raise AssertionError("never came")


@pytest.fixture(scope="module")
def recorded():
    return Recorded()


@pytest.fixture
def source(recorded):
    recorded.asked.clear()
    return recorded


def test_a_click_on_the_map_is_a_goal_where_its_ray_meets_the_floor(source):
    with a_console(source) as page, a_browser(page) as wire:
        waiting(lambda: page.drawn)
        click(wire, 2.5, 3.5)
        assert waiting(lambda: source.asked) == [ask.DriveTo(2.5, 3.5)]


def test_a_click_with_shift_puts_a_box_down(source):
    with a_console(source) as page, a_browser(page) as wire:
        waiting(lambda: page.drawn)
        click(wire, 2.5, 3.5, modifier="shift")
        (command,) = waiting(lambda: source.asked)
        assert (type(command), command.x_m, command.y_m) == (ask.PutBox, 2.5, 3.5)


def test_a_run_that_is_only_watched_takes_no_goals(source):
    with a_console(source, interactive=False) as page, a_browser(page) as wire:
        waiting(lambda: page.drawn)
        click(wire, 2.5, 3.5)
        assert isinstance(waiting(lambda: source.asked)[0], ask.PutBox)


def test_a_goal_clicked_through_the_websocket_is_driven_to():
    live = Live(ROOM, speed=math.inf, open_end=True, paused=True).start()
    with a_console(live) as page, a_browser(page) as wire:
        waiting(lambda: page.drawn)
        reader = threading.Thread(target=read_on, args=(wire,))
        reader.start()
        click(wire, 4.0, 3.0)
        waiting(lambda: live.snapshot().robots[0].goal)
        live.do(ask.Pause(False))
        waiting(lambda: live.snapshot().robots[0].goals)
        (goal,) = live.snapshot().robots[0].goals
        assert goal["outcome"] == "reached"
        assert goal["goal_m"] == pytest.approx([4.0, 3.0])
        assert live.end().exit_code == 0
    reader.join()


def test_a_browser_that_reads_nothing_does_not_hold_up_the_run():
    live = Live(Scenario.load("quick"), speed=math.inf)
    with a_console(live, interactive=False) as page, a_browser(page) as wire:
        wire.recv()  # connected, and never reads again
        live.start()
        assert live.wait(60.0)
        assert live.results[0].reached


def test_nobody_looking_asks_for_no_snapshots():
    live = Live(Scenario.load("quick"), speed=math.inf)
    with a_console(live, interactive=False) as page:
        live.start()
        assert live.wait(60.0)
        assert page.visitors == 0
        assert live.snapshot().number <= 3  # the first moment for who comes next, and the end


def test_off_loopback_the_console_is_shown_to_who_has_the_token_only(source):
    with a_console(source, host="0.0.0.0") as page:
        with pytest.raises(InvalidStatus, match="403"), a_browser(page):
            pass
        token = page.url.partition("?token=")[2]
        port = page.url.rpartition(":")[2].partition("/")[0]
        with a_browser(page, cookie=f"cairn_console_{port}={token}") as wire:
            waiting(lambda: page.drawn)
            click(wire, 1.0, 1.0)
            assert waiting(lambda: source.asked) == [ask.DriveTo(1.0, 1.0)]


def test_no_visitor_can_open_a_tunnel_to_the_outside(source, monkeypatch):
    from viser import _viser

    monkeypatch.setattr(_viser, "ViserTunnel", lambda *_: pytest.fail("a tunnel was opened"))
    with a_console(source) as page, a_browser(page) as wire:
        wire.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
        waiting(lambda: page.drawn)
        click(wire, 1.0, 1.0)
        waiting(lambda: source.asked)


def test_without_viser_the_extra_is_named(source, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(errors.ConsoleNotInstalled, match=r"cairn-nav\[console\]"):
        Console(source, port=0)


@pytest.mark.parametrize("name", ["two_robots", "explore", "lost"])
def test_every_kind_of_mission_can_be_shown(name):
    scenario = Scenario.load(name).model_copy(update={"robot": "kinematic"})
    live = Live(scenario, speed=math.inf, paused=True)
    with a_console(live, interactive=False) as page, a_browser(page):
        live.start()
        for ticks in (1, 30):
            live.do(ask.Step(ticks))
            waiting(lambda ticks=ticks: live.newer(0, 10.0).time_s >= ticks / 10)
            drawn = live.snapshot().number
            waiting(lambda drawn=drawn: page.drawn >= drawn)
    live.end()
