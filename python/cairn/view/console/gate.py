"""The door of the console: every connection is checked before anything is served.

The page behind it has no login of its own. It listens on an address of this machine only, and this
small proxy stands in front: it reads the head of each request, refuses whatever is not allowed, and
hands the rest over, websockets included. One connection is one request.

- Whoever comes must name this server (`Host`), and a page that connects must be of this server
  (`Origin`): no other site that happens to be open in the same browser gets in.
- Reached from other machines, the first request needs the token in its address; the browser then
  keeps it as a cookie and sends it with every request and websocket.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import secrets
import socket
import threading
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from cairn.errors import ConsoleAddressUnusable

_HEAD_BYTES = 32_768
_HEAD_S = 10.0
_CONNECTIONS = 128
_CHUNK = 65_536
_LOOPBACK_NAMES = {"localhost", "127.0.0.1", "::1"}
_EMBEDDED = {"iframe", "frame", "embed", "object"}
_TOKEN_BYTES = 24


class _Refused(Exception):
    def __init__(self, status: HTTPStatus, why: str) -> None:
        super().__init__(why)
        self.status = status


class _Head:
    """The head of a request, as far as it matters here."""

    def __init__(self, raw: bytes) -> None:
        lines = raw.decode("latin-1").split("\r\n")
        parts = lines[0].split(" ")
        if len(parts) != 3 or not parts[2].startswith("HTTP/1."):
            raise _Refused(HTTPStatus.BAD_REQUEST, "That is not a request this server knows.")
        self.method, self.target, _ = parts
        self.fields: list[tuple[str, str]] = []
        for line in lines[1:]:
            if not line:
                continue
            name, colon, value = line.partition(":")
            if not colon or name != name.strip() or not name:
                raise _Refused(HTTPStatus.BAD_REQUEST, "A header of the request is malformed.")
            self.fields.append((name.lower(), value.strip()))

    def one(self, name: str) -> str | None:
        """The value of a header that may be there once."""
        values = [value for key, value in self.fields if key == name]
        if len(values) > 1:
            raise _Refused(HTTPStatus.BAD_REQUEST, f"The request has several headers `{name}`.")
        return values[0] if values else None

    @property
    def is_upgrade(self) -> bool:
        """Whether it asks for a websocket."""
        return (self.one("upgrade") or "").lower() == "websocket"


class Gate:
    """A checking proxy before a server on this machine.

    Args:
        behind: (host, port) of the server.
        host: address to listen on; other machines reach it only where it is no loopback address,
            and then every visitor needs the token.
        port: to listen on; 0: any free one.

    Raises:
        ConsoleAddressUnusable: the address cannot be listened on.
    """

    def __init__(self, behind: tuple[str, int], *, host: str = "127.0.0.1", port: int = 0) -> None:
        self._behind = behind
        self.host = host
        self.token = None if is_loopback(host) else secrets.token_urlsafe(_TOKEN_BYTES)
        self._socket = _listening(host, port)
        self.port = int(self._socket.getsockname()[1])
        self._open = 0
        self._ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._serve()), name="cairn console gate", daemon=True
        )
        self._thread.start()
        self._ready.wait()

    @property
    def url(self) -> str:
        """What to open in a browser, token included."""
        name = socket.gethostname() if self.host in ("0.0.0.0", "::") else self.host
        name = f"[{name}]" if ":" in name else name
        query = f"?token={self.token}" if self.token else ""
        return f"http://{name}:{self.port}/{query}"

    def stop(self) -> None:
        """Close the door and every connection."""
        with contextlib.suppress(RuntimeError):  # closed already
            self._loop.call_soon_threadsafe(self._stopping.set)
        self._thread.join(timeout=5.0)

    # ---- one connection --------------------------------------------------------------------------

    async def _serve(self) -> None:
        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        server = await asyncio.start_server(self._welcome, sock=self._socket, limit=_HEAD_BYTES)
        self._ready.set()
        await self._stopping.wait()
        server.close()  # whoever is still connected is cut off when the loop ends

    async def _welcome(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open += 1
        try:
            if self._open > _CONNECTIONS:
                return
            async with asyncio.timeout(_HEAD_S):
                raw = await reader.readuntil(b"\r\n\r\n")
            try:
                await self._pass_on(_Head(raw[:-4]), reader, writer)
            except _Refused as refused:
                writer.write(_page(refused.status, str(refused)))
                await writer.drain()
        except (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            pass  # whoever came has left, or says nothing
        except asyncio.CancelledError:
            pass  # the door is closing
        finally:
            self._open -= 1
            writer.close()

    async def _pass_on(
        self, head: _Head, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        cookie = self._check(head)
        if cookie is not None:
            writer.write(cookie)
            await writer.drain()
            return
        there, back = await asyncio.open_connection(*self._behind)
        try:
            back.write(self._rewritten(head))
            if head.is_upgrade:
                await _both_ways((reader, back), (there, writer))
            else:
                await _copy(there, writer)
        finally:
            back.close()

    def _check(self, head: _Head) -> bytes | None:
        """Refuse what is not allowed; return an answer of our own where there is one."""
        if head.method != "GET":
            raise _Refused(HTTPStatus.METHOD_NOT_ALLOWED, "Only GET is served here.")
        if not head.target.startswith("/"):
            raise _Refused(HTTPStatus.BAD_REQUEST, "The request names no path.")
        if head.one("content-length") not in (None, "0") or head.one("transfer-encoding"):
            raise _Refused(HTTPStatus.BAD_REQUEST, "A request with a body is not served here.")
        host = head.one("host") or ""
        if self.token is None and _name_of(host) not in _LOOPBACK_NAMES | {self.host}:
            raise _Refused(
                HTTPStatus.FORBIDDEN,
                f"This console is for this machine only; it is not called `{host}`.",
            )
        origin = head.one("origin")
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            raise _Refused(HTTPStatus.FORBIDDEN, "A page of another site may not connect here.")
        if head.one("sec-fetch-site") == "cross-site" and head.one("sec-fetch-dest") in _EMBEDDED:
            raise _Refused(HTTPStatus.FORBIDDEN, "Another site may not show this console.")
        return None if self.token is None else self._check_token(head, self.token)

    def _check_token(self, head: _Head, token: str) -> bytes | None:
        given = parse_qs(urlsplit(head.target).query).get("token", [""])[0]
        name = f"cairn_console_{self.port}"
        if given and _same(given, token) and not head.is_upgrade:
            return _answer(
                HTTPStatus.SEE_OTHER,
                "",
                Location="/",
                Set_Cookie=f"{name}={token}; Path=/; HttpOnly; SameSite=Strict",
            )
        try:
            kept = SimpleCookie(head.one("cookie") or "").get(name)
        except CookieError:
            kept = None
        if kept is None or not _same(kept.value, token):
            raise _Refused(
                HTTPStatus.FORBIDDEN,
                "This console needs its token: open the whole address that `cairn` printed when "
                "it began, from ?token= to the end.",
            )
        return None

    def _rewritten(self, head: _Head) -> bytes:
        """The head for the server behind: without our secrets, one request per connection."""
        host, port = self._behind
        kept = [
            (name, value)
            for name, value in head.fields
            if name not in {"host", "cookie", "connection", "origin", "keep-alive"}
        ]
        connection = "Upgrade" if head.is_upgrade else "close"
        fields = [("Host", f"{host}:{port}"), ("Connection", connection), *kept]
        lines = [f"GET {head.target} HTTP/1.1", *(f"{name}: {value}" for name, value in fields)]
        return "\r\n".join([*lines, "", ""]).encode("latin-1")


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this machine only.

    Raises:
        ConsoleAddressUnusable: no such address.
    """
    return all(ipaddress.ip_address(ip).is_loopback for ip in _addresses(host))


def _addresses(host: str) -> list[str]:
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError) as error:
        raise ConsoleAddressUnusable(
            f"`{host}` is no address of this machine: {error}", host=host, port=0
        ) from error
    return [str(entry[4][0]).partition("%")[0] for entry in found]


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in _addresses(host)[0] else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(64)
    except (OSError, OverflowError) as error:
        listener.close()
        raise ConsoleAddressUnusable(
            f"cannot listen on {host} port {port}: {error}", host=host, port=port
        ) from error
    return listener


def _name_of(host: str) -> str:
    """The name in a `Host` header, without port and brackets."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.partition(":")[0].lower()


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())


def _page(status: HTTPStatus, why: str) -> bytes:
    return _answer(
        status,
        "<!doctype html><meta charset=utf-8><title>Cairn</title>"
        "<body style='font:16px system-ui;margin:15vh auto;max-width:34em;color:#22303c'>"
        f"<h1 style='font-size:20px'>Cairn</h1><p>{_escaped(why)}</p>",
    )


def _answer(status: HTTPStatus, body: str, **fields: str) -> bytes:
    content = body.encode()
    fields = {
        "Content_Type": "text/html; charset=utf-8",
        "Content_Length": str(len(content)),
        "Cache_Control": "no-store",
        "Referrer_Policy": "no-referrer",
        "X_Frame_Options": "DENY",
        "Connection": "close",
        **fields,
    }
    lines = [f"HTTP/1.1 {status.value} {status.phrase}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in fields.items()]
    return "\r\n".join([*lines, "", ""]).encode("latin-1") + content


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


async def _both_ways(
    *ways: tuple[asyncio.StreamReader, asyncio.StreamWriter],
) -> None:
    """Copy both ways until one side has had enough."""
    tasks = [asyncio.create_task(_copy(*way)) for way in ways]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Copy until the end; whoever reads slowly slows this down, and nobody else."""
    while chunk := await reader.read(_CHUNK):
        writer.write(chunk)
        await writer.drain()
