"""Clients that receive streams: `python -m bench.service.stream_client`, with a job as JSON on stdin.

They do as little work as possible: they record arrival times and frame numbers, and decode nothing else.
"""

from __future__ import annotations

import asyncio
import json
import signal
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

import uvloop

HANDSHAKE = (
    "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
FRAME_KEY = b"\xa5frame"


@dataclass(frozen=True)
class Connections:
    """WebSockets to a path, for `seconds`."""

    port: int
    path: str
    connections: int
    seconds: float


@dataclass(frozen=True)
class Job(Connections):
    """Each connection sends `commands` once. `stalled` of them stop reading after 0.5 s."""

    commands: list[str] = field(default_factory=list)
    stalled: int = 0
    keep: int = 0  # number of first messages to keep of each connection; if not 0, every 100th message is kept too


class Client(asyncio.Protocol):
    """One connection."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.arrivals: list[float] = []
        self.numbers: list[int] = []
        self.kept: list[bytes] = []
        self.events: list[str] = []
        self.bytes = 0
        self.lost: float | None = None
        self._buffer = bytearray()
        self._open = False

    def connection_made(self, transport: Any) -> None:
        self.transport = transport
        transport.write(HANDSHAKE.format(path=self.job.path).encode())

    def connection_lost(self, exc: Exception | None) -> None:
        self.lost = time.perf_counter()

    def data_received(self, data: bytes) -> None:
        now = time.perf_counter()
        self._buffer += data
        if not self._open:
            end = self._buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            if not self._buffer.startswith(b"HTTP/1.1 101"):
                raise SystemExit(bytes(self._buffer).decode())
            del self._buffer[: end + 4]
            self._open = True
            for command in self.job.commands:
                self._send(TEXT, command.encode())
        self._take(now)

    def _take(self, now: float) -> None:
        buffer, at = self._buffer, 0
        while len(buffer) - at >= 2:
            size, head = buffer[at + 1], 2
            if size >= 126:
                head = 4 if size == 126 else 10
                if len(buffer) - at < head:
                    break
                size = int.from_bytes(buffer[at + 2 : at + head], "big")
            if len(buffer) - at < head + size:
                break
            self._message(buffer[at] & 15, buffer, at + head, size, now)
            at += head + size
        del buffer[:at]

    def _message(self, kind: int, buffer: bytearray, at: int, size: int, now: float) -> None:
        if kind == BINARY:
            self.bytes += size
            self.arrivals.append(now)
            self.numbers.append(_number(buffer, at))
            if len(self.kept) < self.job.keep or (self.job.keep and len(self.arrivals) % 100 == 0):
                self.kept.append(bytes(buffer[at : at + size]))
        elif kind == TEXT:
            self.events.append(bytes(buffer[at : at + size]).decode())
        elif kind == PING:
            self._send(PONG, bytes(buffer[at : at + size]))

    def _send(self, kind: int, data: bytes) -> None:
        self.transport.write(frame(kind, data))


def frame(kind: int, data: bytes) -> bytes:
    """Returns a WebSocket frame of less than 64 KiB, masked with zeros."""
    size = bytes((0x80 | len(data),)) if len(data) < 126 else b"\xfe" + len(data).to_bytes(2, "big")
    return bytes((0x80 | kind,)) + size + bytes(4) + data


def _number(buffer: bytearray, at: int) -> int:
    """Returns the frame number of a message, which is in its first 120 bytes; -1 if it has none."""
    found = buffer.find(FRAME_KEY, at, at + 120)
    if found < 0:
        return -1
    kind = buffer[found + 6]
    if kind < 0x80:
        return kind
    return int.from_bytes(buffer[found + 7 : found + 7 + (1 << (kind - 0xCC))], "big")


async def take(job: Job) -> list[Client]:
    """Connects all clients, and waits until the job ends, or until SIGTERM."""
    loop, ended = asyncio.get_running_loop(), asyncio.Event()
    loop.add_signal_handler(signal.SIGTERM, ended.set)
    clients = []
    for _ in range(job.connections):
        _, client = await loop.create_connection(lambda: Client(job), "127.0.0.1", job.port)
        clients.append(client)
    await asyncio.sleep(0.5)
    for client in clients[: job.stalled]:
        client.transport.pause_reading()
    with suppress(TimeoutError):
        await asyncio.wait_for(ended.wait(), job.seconds)
    for client in clients:
        client.transport.abort()
    return clients


def main() -> None:
    job = Job(**json.load(sys.stdin))
    clients = uvloop.run(take(job))
    results = [
        {
            "arrivals": one.arrivals,
            "numbers": one.numbers,
            "events": one.events,
            "bytes": one.bytes,
            "lost": one.lost is not None and one.lost < (one.arrivals[-1] if one.arrivals else 0.0),
            "kept": [message.hex() for message in one.kept],
        }
        for one in clients
    ]
    json.dump(results, sys.stdout)


def as_json(job: Job) -> str:
    """Returns a job as the JSON text that main() reads."""
    return json.dumps(asdict(job))


if __name__ == "__main__":
    main()
