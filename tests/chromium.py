"""A headless Chromium, driven by its DevTools protocol: enough to load, click, read and look."""

import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-dev-shm-usage", "--remote-debugging-port=0",
    "--no-first-run", "--hide-scrollbars", "--mute-audio",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
SHIFT = 8
_STARTS_S, _ANSWERS_S = 60.0, 120.0


def installed():
    """Path of a Chromium, or None. `CAIRN_CHROMIUM` names one that is not on the path."""
    return os.environ.get("CAIRN_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)


class Chromium:
    """One browser with one page. A context manager."""

    def __init__(self, size=(1440, 900)):
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._log = Path(self._folder.name) / "log"
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(
                [
                    installed(),
                    *FLAGS,
                    f"--window-size={size[0]},{size[1]}",
                    f"--user-data-dir={self._folder.name}/profile",
                    "about:blank",
                ],
                stdout=subprocess.DEVNULL,
                stderr=log,
            )
        self._wire = connect(self._address(), max_size=None, close_timeout=0.1)
        self._asked = 0
        self._session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **metrics)

    def _address(self):
        began = time.monotonic()
        while time.monotonic() - began < _STARTS_S:
            told = self._log.read_text(errors="replace")
            if found := re.search(r"DevTools listening on (ws://\S+)", told):
                return found[1]
            assert self._process.poll() is None, f"Chromium does not start: {told[-2000:]}"
            time.sleep(0.05)
        raise AssertionError("Chromium does not start")

    def call(self, method, **parameters):
        """Ask for something by its protocol's name; return the answer."""
        self._asked += 1
        message = {"id": self._asked, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        self._wire.send(json.dumps(message))
        while True:
            answer = json.loads(self._wire.recv(timeout=_ANSWERS_S))
            if answer.get("id") == self._asked:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]

    def goto(self, url):
        """Load a page."""
        return self.call("Page.navigate", url=url)

    def read(self, script):
        """Value of a JavaScript expression."""
        return self.call("Runtime.evaluate", expression=script, returnByValue=True)["result"].get(
            "value"
        )

    @property
    def text(self):
        """All that can be read on the page."""
        return self.read("document.body ? document.body.innerText : ''") or ""

    def middle_of(self, text):
        """Where on the screen the smallest element with exactly this text is; None if nowhere."""
        return self.read(
            "(() => { const all = [...document.querySelectorAll('*')].filter("
            f"e => e.innerText && e.innerText.trim() === {json.dumps(text)} && e.offsetParent);"
            "if (!all.length) return null; const r = all[all.length - 1].getBoundingClientRect();"
            "return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )

    def canvas(self):
        """(x, y, width, height) of what the scene is drawn on."""
        return self.read(
            "(() => { const c = document.querySelector('canvas'); if (!c) return null;"
            "const r = c.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()"
        )

    def click(self, x, y, modifiers=0):
        """Press and let go of the left button."""
        at = {"x": x, "y": y, "modifiers": modifiers}
        self.call("Input.dispatchMouseEvent", type="mouseMoved", **at)
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, **at)

    def screenshot(self, path):
        """Keep what is to be seen as a PNG."""
        shot = self.call("Page.captureScreenshot", format="png")
        Path(path).write_bytes(base64.b64decode(shot["data"]))
        return path

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._wire.close()
        self._process.terminate()
        self._process.wait(30)
        self._folder.cleanup()
