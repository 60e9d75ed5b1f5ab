"""Requests over HTTP, and handshakes of WebSockets with their frames, in pieces of any size: through `service/edge`."""

from __future__ import annotations

import asyncio
import logging
import re
import struct
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache, cached_property
from pathlib import Path
from typing import Any
from unittest.mock import patch

import anyio.to_thread
from uvicorn.server import ServerState

from bench.hostile.damage import damage_bytes, damage_text
from motionsplice.service.edge.config import EdgeConfig
from motionsplice.service.front import Front
from motionsplice.service.problems import RequestError
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.hardening.fuzz.banks import played_bank
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw

TARGETS = (
    *("/healthz", "/v1/pose?locomotion=walk&time=0.5", "/v1/pose?locomotion=walk&action=wave&time=1", "/v1/clips"),
    *("/v1/stream?locomotion=walk&rate=100", "/v1/splice?locomotion=walk&action=wave&rate=10", "/v1/clips/walk"),
    *(
        "/v1/poses",
        "/v1/characters",
        "/v1/manifest",
        "/v1/tables/lower",
        "/v1/server",
        "/",
        "/openapi.json",
        "/metrics",
    ),
    *("/v1/banks/x/pose?time=0", "*", "http://a/healthz", "/%00", "/v1/clips/%ff%fe", "//", "/v1/pose?" + "a=b&" * 300),
    *("/v1/pose?locomotion=walk~mirror&time=0", "/v1/expectation?locomotion=walk&action=wave", "/v1/job", "/view/"),
)
METHODS = (
    "GET",
    "GET",
    "GET",
    "POST",
    "HEAD",
    "OPTIONS",
    "PUT",
    "DELETE",
    "CONNECT",
    "PRI",
    "M-SEARCH",
    "get",
    "",
    "X",
)
VERSIONS = ("HTTP/1.1", "HTTP/1.1", "HTTP/1.1", "HTTP/1.0", "HTTP/2.0", "HTTP/9.9", "http/1.1", "", "ICY")
HEADERS = (
    *("Content-Length: 2", "Content-Length: 0", "Content-Length: -1", "Content-Length: 99999999999999999999"),
    *("Transfer-Encoding: chunked", "Transfer-Encoding: gzip, chunked", "Expect: 100-continue", "Connection: close"),
    *("Connection: keep-alive, Upgrade", "Upgrade: websocket", "Upgrade: h2c", "Origin: null", "Origin: http://evil"),
    *("If-None-Match: *", 'If-None-Match: W/"a", "b"', "Range: bytes=0-1", "Range: bytes=5-1,-3", "Authorization: x"),
    *("Content-Type: application/json", "Content-Type: application/x-msgpack", "Host: evil.example", "Host: [::1]:80"),
    *("Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Version: 7"),
    *("Sec-WebSocket-Extensions: permessage-deflate", "Sec-WebSocket-Protocol: x, y", "A" * 300 + ": b", "X: \t ", ":"),
    *("no colon", "X\0: y", "Cookie: " + "a" * 3000, "X: \xff\xfe", " folded", "Accept-Encoding: gzip", "Trailer: X"),
)
HANDSHAKE = (
    "GET /v1/characters HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
)
BODIES = (
    "{}",
    "2\r\n{}\r\n0\r\n\r\n",
    "ffffffffffffffff\r\n",
    "0\r\nX: y\r\n\r\n",
    "-1\r\n",
    "",
    "5;a=b\r\nhello\r\n0\r\n\r\n",
)
MESSAGES = ('{"do": "create", "id": 1, "locomotion": "walk"}', "[]", "x", '{"do": "set", "rate": 9}', "\xff", "")
STATUS = re.compile(rb"HTTP/1\.1 (\d{3}) ")
TURNS = 12  # of the event loop after each piece, at most
PATIENCE = 200  # times TURNS in which the tasks of a closed connection must end
PIECES = 6


class Sink(asyncio.Transport):
    """A connection whose client reads at once whatever is written."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 5), "socket": self})
        self.written, self._closing = bytearray(), False

    def setsockopt(self, *option: int) -> None:
        """Takes the place of the socket, too."""

    def getsockname(self) -> tuple[str, int]:
        return "127.0.0.1", 80

    def getpeername(self) -> tuple[str, int]:
        return "127.0.0.1", 5

    def write(self, data: Any) -> None:
        self.written += data

    def close(self) -> None:
        self._closing = True

    def abort(self) -> None:
        self._closing = True

    def is_closing(self) -> bool:
        return self._closing

    def pause_reading(self) -> None: ...

    def resume_reading(self) -> None: ...

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None: ...

    def get_write_buffer_size(self) -> int:
        return 0

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        self.protocol = protocol

    @cached_property
    def protocol(self) -> Any:
        """The protocol that receives what arrives, which an upgrade replaces."""


class Failures(logging.Handler):
    """Collects what is logged as an error."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        self.found.append(f"{record.getMessage()}: {error!r}")


class Inline(ThreadPoolExecutor):
    """Runs at once what is meant for a thread: inputs take less time, and the same one every time."""

    def submit(self, run: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(run(*given, **named))
        except Exception as error:
            future.set_exception(error)
        return future


async def _inline(run: Callable[..., Any], *given: Any, **options: Any) -> Any:
    """Takes the place of `anyio.to_thread.run_sync`, likewise; options are about the thread."""
    return run(*given)


@cache
def _service() -> tuple[asyncio.AbstractEventLoop, EdgeConfig, Failures]:
    """Returns an event loop that does not run, a loaded service, and what it logs as an error."""
    loop, failures = asyncio.new_event_loop(), Failures()
    loop.set_default_executor(Inline())
    bank = played_bank()
    config = EdgeConfig(bank.path, Settings(request_seconds=3600.0, idle_seconds=3600.0, max_frames=2000))
    config.load()
    front = config.loaded_app
    assert isinstance(front, Front)
    front.shared.serving.exchange(Edition.warm(bank))
    for name in ("motionsplice", "uvicorn.error", "asyncio"):
        logging.getLogger(name).handlers = [failures]
        logging.getLogger(name).propagate = False
    return loop, config, failures


def _request(draw: Draw) -> bytes:
    method, version = (draw.choice(words) if draw.rarely(3) else words[0] for words in (METHODS, VERSIONS))
    target = draw.choice(TARGETS)
    if target == "/v1/poses":
        method = "POST" if not draw.rarely(6) else method
    headers = ["Host: 127.0.0.1"] if not draw.rarely(12) else []
    headers += [draw.choice(HEADERS) for _ in range(draw.randrange(4))]
    ending = draw.choice(("\n", "\r", "\r\n\r\n", "\0")) if draw.rarely(12) else "\r\n"
    head = ending.join([f"{method} {target} {version}", *headers, "", ""])
    body = draw.choice(BODIES) if any(one.startswith(("Content-Length", "Transfer")) for one in headers) else ""
    return (head + body).encode("latin-1", "replace")


def _frame(draw: Draw) -> bytes:
    """Returns a frame of a WebSocket by RFC 6455, rarely with a wrong length, without a mask or of an unknown kind."""
    payload = draw.choice(MESSAGES).encode("latin-1") * (draw.choice((30, 300)) if draw.rarely(12) else 1)
    head = draw.choice((0x81, 0x82, 0x01, 0x80, 0x88, 0x89, 0x8A, 0x00, 0x83, 0xC1, 0xFF)) if draw.rarely(3) else 0x81
    size = draw.choice((0, 1, 2**16, 2**63 - 1)) if draw.rarely(20) else len(payload)
    masked = 0 if draw.rarely(20) else 0x80
    if size < 126:
        lengths = struct.pack("!B", masked | size)
    else:
        lengths = struct.pack("!BH", masked | 126, size) if size < 2**16 else struct.pack("!BQ", masked | 127, size)
    return bytes([head]) + lengths + bytes(4 if masked else 0) + payload


def make(draw: Draw) -> Files:
    """Returns what a client sends, in the pieces in which it arrives."""
    if draw.randrange(4) < 3:
        sent = b"".join(_request(draw) for _ in range(20 if draw.rarely(20) else draw.choice((1, 1, 1, 2, 3))))
    else:
        headers = [draw.choice(HEADERS) for _ in range(draw.randrange(3))] if draw.rarely(2) else []
        sent = (HANDSHAKE + "".join(f"{one}\r\n" for one in headers) + "\r\n").encode("latin-1")
        sent += b"".join(_frame(draw) for _ in range(draw.randrange(8)))
    if draw.rarely(8):
        sent = draw.choice((damage_text, damage_bytes))(sent, sent, draw)
    cuts = sorted(draw.randrange(len(sent) + 1) for _ in range(draw.randrange(PIECES)))
    return {f"{at}": sent[begin:end] for at, (begin, end) in enumerate(zip([0, *cuts], [*cuts, None], strict=True))}


async def _settled(loop: asyncio.AbstractEventLoop) -> None:
    """Lets the event loop turn until all wait for the clock or the client."""
    for _ in range(TURNS):
        if not loop._ready:  # type: ignore[attr-defined]
            return
        await asyncio.sleep(0)


async def _connection(config: EdgeConfig, files: Files) -> bytes:
    """Returns what a connection answers. Its tasks must end when it does."""
    own, sink, loop = asyncio.current_task(), Sink(), asyncio.get_running_loop()
    state = ServerState()
    sink.protocol = config.http_protocol_class(config, state, {}, loop)  # type: ignore[call-arg]
    sink.protocol.connection_made(sink)
    for piece in files.values():
        if sink.is_closing():
            break
        sink.protocol.data_received(piece)
        await _settled(loop)
    sink.close()
    sink.protocol.connection_lost(None)
    for _ in range(PATIENCE):
        await _settled(loop)
        if len(asyncio.all_tasks()) == 1:
            break
        if not loop._ready:  # type: ignore[attr-defined]
            await asyncio.sleep(0.01)  # a task waits for the clock
    else:
        left = [task for task in asyncio.all_tasks() if task is not own]
        raise AssertionError(f"tasks were left: {left}")
    if any(held := (len(config.ledger), len(state.connections), len(config.front.shared.streams))):
        raise AssertionError(f"connections, requests and streams are still held: {held}")
    return bytes(sink.written)


def enter(files: Files, folder: Path) -> None:
    """Sends the pieces through a connection. Raises RequestError if a request is refused."""
    loop, config, failures = _service()
    with patch.object(anyio.to_thread, "run_sync", _inline):
        answer = loop.run_until_complete(_connection(config, files))
    found, failures.found = failures.found, []
    if found:
        raise AssertionError(found[0])
    statuses = STATUS.findall(answer)
    if answer and not answer.startswith(b"HTTP/1.1 "):
        raise AssertionError(f"an answer begins with {answer[:40]!r}")
    if any(status >= b"500" for status in statuses):
        raise AssertionError(f"status {statuses}")
    if refused := [status.decode() for status in statuses if status >= b"400"]:
        raise RequestError(f"status {refused[0]} at first" if statuses[0] >= b"400" else "status 4xx later")
    if not statuses:
        raise RequestError("no answer yet")


EARLY = re.compile("status 400|no answer yet")
DOOR = Door(make, enter, EARLY)
