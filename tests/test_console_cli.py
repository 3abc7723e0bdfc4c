"""`cairn console` and `cairn run --live` as a person calls them."""

import json
import os
import re
import signal
import threading
import time
import urllib.request

import pytest

from cairn.record import open_run

QUIET = ("--port", "0", "--no-browser")


def test_a_live_run_ends_prints_and_leaves_what_a_run_does(command, tmp_path):
    live = ("run", "quick", "--live", "--speed", "inf", *QUIET, "--no-picture")
    code, out, err = command(*live, "--json", "--record", "seen")
    assert code == 0
    assert "http://127.0.0.1:" in err
    plain = command("run", "quick", "--no-picture", "--json")[1]
    watched, alone = json.loads(out), json.loads(plain)
    del watched["wall"], alone["wall"]
    assert watched == alone
    run = open_run(tmp_path / "seen")
    assert run.summary["summary"]["reached"]
    assert sum(1 for _ in run.ticks()) > 50


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("console", "nowhere"), "no scenario `nowhere`"),
        (("console", "quick", "--speed", "0"), "--speed"),
        (("console", "quick", "--host", "no.such.host.invalid"), "no address of this machine"),
        (("run", "quick", "--live", "--seeds", "2"), "--live shows one run"),
    ],
)
def test_what_cannot_be_shown_is_refused_with_code_2(command, arguments, told):
    code, _, err = command(*arguments, *QUIET)
    assert code == 2
    assert told in re.sub(r"[\s│]+", " ", err)


def test_a_console_serves_its_page_and_ends_with_the_signal(command, tmp_path, monkeypatch):
    pages = []

    def visit(url):
        with urllib.request.urlopen(url) as page:
            pages.append((page.status, page.read()))
        time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGTERM)

    def opened(url):
        threading.Thread(target=visit, args=(url,)).start()

    monkeypatch.setattr("webbrowser.open", opened)
    code, out, _ = command("console", "quick", "--port", "0", "--browser", "--speed", "inf")
    assert code == 0
    assert "Ctrl-C ends it" in out
    assert "no goal was given" in out
    assert pages[0][0] == 200
    assert b"<html" in pages[0][1]
    assert (tmp_path / "runs" / "console-quick" / "summary.json").is_file()
