"""The console in a browser: viser behind a door that checks who comes in.

The view runs in a thread of its own. It asks for a snapshot when somebody looks and it has drawn
the last one; whatever it needs for that, the run does not wait.
"""

from __future__ import annotations

import contextlib
import secrets
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any, Protocol

from cairn.errors import ConsoleNotInstalled
from cairn.view.console.commands import Command
from cairn.view.console.gate import Gate
from cairn.view.console.panel import Panel
from cairn.view.console.scene import Drawing
from cairn.view.console.snapshot import Snapshot

DRAWS_PER_S = 8.0
_WAIT_S = 0.5
_SETTLES_S = 5.0  # after a browser came, until its layout stands
_ASPECT = 1.4  # until a browser has told its own


class Source(Protocol):
    """Where snapshots come from and commands go: `cairn.missions.live.Live`, say."""

    def newer(self, than: int, timeout_s: float) -> Snapshot | None:
        """A snapshot with a number above `than`; None if there was none in time."""
        ...

    def do(self, command: Command) -> None:
        """Ask for something, without waiting."""
        ...


class Console:
    """Shows a run in browsers, and hands their clicks on.

    Args:
        source: of snapshots, and for commands.
        host: address to listen on; with any but a loopback one, visitors need a token.
        port: 0: any free one.
        interactive: whether goals and start poses can be given.
        title: of the page.

    Raises:
        ConsoleNotInstalled: no `viser`.
        ConsoleAddressUnusable: the address cannot be listened on.
    """

    def __init__(
        self,
        source: Source,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        interactive: bool = True,
        title: str = "Cairn",
    ) -> None:
        server_class = _quiet_server()
        self._source = source
        others = set(threading.enumerate())
        with _silence():
            self._server = server_class(host=_hidden_address(), port=0, label=title, verbose=False)
        self._threads = set(threading.enumerate()) - others
        try:
            behind = (self._server.get_host(), self._server.get_port())
            self._gate = Gate(behind, host=host, port=port)
        except BaseException:
            self._stop_server()
            raise
        self._drawing = Drawing(self._server)
        self._panel = Panel(
            self._server, self._drawing, source.do, interactive=interactive, title=title
        )
        self._shown = 0
        self._last: Snapshot | None = None
        self._stopping = threading.Event()
        self._error: BaseException | None = None
        self._server.scene.on_click()(lambda event: self._clicked(event, box=False))
        self._server.scene.on_click(modifier="shift")(lambda event: self._clicked(event, box=True))
        self._server.on_client_connect(self._connected)
        self._thread = threading.Thread(target=self._view, name="cairn console", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """What to open in a browser, token included."""
        return self._gate.url

    @property
    def visitors(self) -> int:
        """How many browsers are looking."""
        return len(self._server.get_clients())

    @property
    def drawn(self) -> int:
        """Number of the snapshot last drawn."""
        return self._shown

    def stop(self) -> None:
        """Close the page.

        Raises:
            Whatever broke the view in its thread.
        """
        self._stopping.set()
        self._thread.join(timeout=5.0)
        self._gate.stop()
        self._stop_server()
        if self._error is not None:
            raise self._error

    def _stop_server(self) -> None:
        with _silence():
            self._server.stop()
            # Its thread says goodbye on the terminal, sometimes after `stop` has returned.
            for thread in set(threading.enumerate()) & self._threads:
                thread.join(timeout=2.0)

    # ---- the view's thread -----------------------------------------------------------------------

    def _view(self) -> None:
        try:
            while not self._stopping.is_set():
                began = time.monotonic()
                self._draw_next()
                self._stopping.wait(max(1 / DRAWS_PER_S - (time.monotonic() - began), 0.0))
        except BaseException as error:
            self._error = error
            raise

    def _draw_next(self) -> None:
        """Draw what is newest, if somebody looks; the first one in any case."""
        if self._last is not None and not self.visitors:
            return
        snapshot = self._source.newer(self._shown, _WAIT_S)
        if snapshot is None:
            return
        first = self._last is None
        self._last = snapshot
        self._panel.show(snapshot)
        self._drawing.show(snapshot, self._panel.robot)
        if first:
            camera = self._server.initial_camera
            self._drawing.look_from_above(camera, snapshot.world, _ASPECT)
        self._shown = snapshot.number

    # ---- browsers --------------------------------------------------------------------------------

    def _connected(self, client: Any) -> None:
        """Frame the map; again when the panel beside it has found its place."""
        began = time.monotonic()
        framed: list[tuple[int, int]] = []

        def frame(camera: Any) -> None:
            size = (camera.image_width, camera.image_height)
            settled = time.monotonic() - began > _SETTLES_S
            if self._last is None or size in framed or (framed and settled):
                return
            framed.append(size)
            self._drawing.look_from_above(camera, self._last.world, size[0] / max(size[1], 1))

        client.camera.on_update(frame)
        frame(client.camera)

    def _clicked(self, event: Any, *, box: bool) -> None:
        """Where the ray of a click meets the floor."""
        (x, y, z), (dx, dy, dz) = event.ray_origin, event.ray_direction
        if dz < -1e-6:
            self._panel.clicked(x - z * dx / dz, y - z * dy / dz, box=box)


def _quiet_server() -> Any:
    """viser's server without its tunnel to the outside, which any visitor could ask for."""
    try:
        import viser
    except ImportError:
        raise ConsoleNotInstalled(
            'the console needs viser: pip install "cairn-nav[console]"'
        ) from None

    class Server(viser.ViserServer):
        def request_share_url(self, verbose: bool = True) -> str | None:
            return None

    return Server


def _hidden_address() -> str:
    """A loopback address that nobody guesses, where the system has more than one.

    What listens there has no login: only the gate is to find it.
    """
    if not sys.platform.startswith("linux"):
        return "127.0.0.1"
    return ".".join(["127", *(str(1 + secrets.randbelow(254)) for _ in range(3))])


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep viser's banner off the terminal."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before
