"""The door of the console: nothing is served before who comes has been checked."""

import contextlib
import socket
import threading

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.sync.server import serve

from cairn import errors
from cairn.view.console.gate import Gate, is_loopback


@pytest.fixture(scope="module")
def behind():
    """A server that answers everything, and a websocket that echoes: what it saw is listed."""
    seen = []

    def page(connection, request):
        seen.append((request.path, dict(request.headers.raw_items())))
        if "Upgrade" in request.headers or "upgrade" in request.headers:
            return None
        return connection.respond(200, "the page\n")

    def echo(connection):
        for message in connection:
            connection.send(message)

    with serve(echo, "127.0.0.1", 0, process_request=page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.socket.getsockname(), seen
        server.shutdown()
    thread.join()


@contextlib.contextmanager
def a_gate(behind, **options):
    gate = Gate(behind[0], **options)
    behind[1].clear()
    try:
        yield gate
    finally:
        gate.stop()


def ask(gate, text):
    """Send bytes as they are, return (status, head, body)."""
    with socket.create_connection(("127.0.0.1", gate.port), timeout=10) as wire:
        wire.sendall(text.replace("\n", "\r\n").encode())
        answer = b""
        while chunk := wire.recv(65536):
            answer += chunk
    head, _, body = answer.decode().partition("\r\n\r\n")
    return int(head.split()[1]) if head else None, head, body


def get(gate, path="/", host=None, **fields):
    lines = [f"GET {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{gate.port}'}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in fields.items()]
    return ask(gate, "\n".join(lines) + "\n\n")


@pytest.mark.parametrize(
    ("host", "own"),
    [("127.0.0.1", True), ("127.3.4.5", True), ("localhost", True), ("::1", True),
     ("0.0.0.0", False), ("192.168.1.7", False), ("::", False)],
)  # fmt: skip
def test_only_loopback_addresses_are_for_this_machine_alone(host, own):
    assert is_loopback(host) is own


def test_on_loopback_the_page_and_its_websocket_need_no_token(behind):
    with a_gate(behind) as gate:
        assert gate.token is None
        assert get(gate)[::2] == (200, "the page\n")
        with connect(f"ws://127.0.0.1:{gate.port}/") as wire:
            wire.send(b"x" * 300_000)
            assert wire.recv() == b"x" * 300_000


def test_a_page_of_another_site_gets_no_websocket_even_on_loopback(behind):
    with a_gate(behind) as gate:
        for origin in ("http://evil.example", f"http://evil.example:{gate.port}", "null"):
            with pytest.raises(InvalidStatus, match="403"):
                connect(f"ws://127.0.0.1:{gate.port}/", origin=origin)
        assert not behind[1]
        connect(f"ws://127.0.0.1:{gate.port}/", origin=f"http://127.0.0.1:{gate.port}").close()


def test_a_name_that_an_attacker_points_at_this_machine_is_no_name_of_the_console(behind):
    with a_gate(behind) as gate:
        status, _, body = get(gate, host=f"evil.example:{gate.port}")
        assert status == 403
        assert "for this machine only" in body
        assert get(gate, host=f"localhost:{gate.port}")[0] == 200
        assert not any(path != "/" for path, _ in behind[1])


def test_another_site_may_not_put_the_console_into_a_frame_of_its_own(behind):
    with a_gate(behind) as gate:
        assert get(gate, Sec_Fetch_Site="cross-site", Sec_Fetch_Dest="iframe")[0] == 403
        assert get(gate, Sec_Fetch_Site="cross-site", Sec_Fetch_Dest="document")[0] == 200


def test_off_loopback_nothing_is_served_without_the_token(behind):
    with a_gate(behind, host="0.0.0.0") as gate:
        assert len(gate.token) >= 32
        refused = [get(gate), get(gate, "/index.html"), get(gate, "/?token="),
                   get(gate, "/?token=" + "x" * 32),
                   get(gate, "/", Cookie=f"cairn_console_{gate.port}=nonsense"),
                   get(gate, "/", Cookie="cairn_console=" + gate.token)]  # fmt: skip
        for status, _, body in refused:
            assert status == 403
            assert "the page" not in body
            assert "token" in body
        for query in ("", "?token=wrong", f"?token={gate.token}"):
            # Not even with the token in the address: a websocket shows the cookie.
            with pytest.raises(InvalidStatus, match="403"):
                connect(f"ws://127.0.0.1:{gate.port}/{query}")
        assert not behind[1]  # nothing reached the server behind


def test_the_token_once_given_is_kept_as_a_cookie_and_not_passed_on(behind):
    with a_gate(behind, host="0.0.0.0") as gate:
        assert gate.url.endswith(f":{gate.port}/?token={gate.token}")
        status, head, _ = get(gate, f"/?token={gate.token}")
        assert status == 303
        assert "Location: /\r\n" in head
        cookie = head.partition("Set-Cookie: ")[2].partition("\r\n")[0]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        pair = cookie.partition(";")[0]
        assert get(gate, Cookie=f"other=1; {pair}")[::2] == (200, "the page\n")
        with connect(f"ws://127.0.0.1:{gate.port}/", additional_headers={"Cookie": pair}) as wire:
            wire.send("hello")
            assert wire.recv() == "hello"
        assert gate.token not in str(behind[1])


def test_every_door_has_a_token_of_its_own(behind):
    with a_gate(behind, host="0.0.0.0") as one, a_gate(behind, host="0.0.0.0") as other:
        assert one.token != other.token


def test_a_second_request_on_one_connection_is_not_passed_on(behind):
    with a_gate(behind) as gate:
        first = f"GET / HTTP/1.1\nHost: 127.0.0.1:{gate.port}\n\n"
        smuggled = "GET /smuggled HTTP/1.1\nHost: evil.example\n\n"
        status, _, body = ask(gate, first + smuggled)
        assert (status, body) == (200, "the page\n")
        assert [path for path, _ in behind[1]] == ["/"]


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        ("POST / HTTP/1.1\nHost: 127.0.0.1\n\n", 405),
        ("GET http://evil.example/ HTTP/1.1\nHost: 127.0.0.1\n\n", 400),
        ("GET / HTTP/1.1\nHost: 127.0.0.1\nHost: evil.example\n\n", 400),
        ("GET / HTTP/1.1\nHost: 127.0.0.1\nContent-Length: 5\n\nhello", 400),
        ("GET / HTTP/1.1\nHost: 127.0.0.1\nTransfer-Encoding: chunked\n\n", 400),
        ("GET / HTTP/1.1\nHost : 127.0.0.1\n\n", 400),
        ("GET / HTTP/1.1\n\n", 403),
        ("hello\n\n", 400),
        ("GET / HTTP/1.1\nX: " + "y" * 70_000 + "\n\n", None),
    ],
)
def test_what_is_no_plain_request_is_refused(behind, request_, status):
    with a_gate(behind) as gate:
        with contextlib.suppress(ConnectionError):
            assert ask(gate, request_)[0] == status
        assert not behind[1]


def test_an_address_that_cannot_be_had_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(errors.ConsoleAddressUnusable, match=str(port)):
            Gate(("127.0.0.1", 1), port=port)
    with pytest.raises(errors.ConsoleAddressUnusable, match="no address"):
        Gate(("127.0.0.1", 1), host="no.such.host.invalid")
