"""A lean WebSocket client: it notes when messages come, and can stop reading."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any, cast

import msgpack

from bench.service.jitter import Arrivals
from bench.service.servers import Endpoint
from motion.errors import SettingsError

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10  # opcodes
LAST, MASKED = 0x80, 0x80
PATIENCE = 60.0  # seconds

Read = Callable[[bytes], tuple[int, int]]  # a message's first frame, and how many it has
Command = dict[str, Any]


def handshake(path: str) -> bytes:
    """A request to become a WebSocket; the key need not be random for a client that does not check the answer."""
    return (
        f"GET {path} HTTP/1.1\r\nhost: 127.0.0.1\r\nupgrade: websocket\r\nconnection: Upgrade\r\n"
        "sec-websocket-key: bW90aW9uc3BsaWNlMTIzNA==\r\nsec-websocket-version: 13\r\n\r\n"
    ).encode()


def masked_frame(opcode: int, payload: bytes) -> bytes:
    """A frame as clients send it; under a mask of zeros, so that the payload is as it was."""
    size = len(payload)
    if size < 126:
        length = bytes((MASKED | size,))
    elif size < 2**16:
        length = bytes((MASKED | 126,)) + size.to_bytes(2, "big")
    else:
        length = bytes((MASKED | 127,)) + size.to_bytes(8, "big")
    return bytes((LAST | opcode,)) + length + bytes(4) + payload


def next_frame(buffer: bytearray) -> tuple[int, bytes] | None:
    """Takes a server's frame from the front of a buffer: its opcode and payload; None if it is not there whole."""
    if len(buffer) < 2:
        return None
    size, at = buffer[1], 2
    if size >= 126:
        at = 4 if size == 126 else 10
        if len(buffer) < at:
            return None
        size = int.from_bytes(buffer[2:at], "big")
    if len(buffer) < at + size:
        return None
    opcode, payload = buffer[0] & 0x0F, bytes(memoryview(buffer)[at : at + size])
    del buffer[: at + size]
    return opcode, payload


def numbered(message: bytes) -> tuple[int, int]:
    """The first frame of a message of the service, and how many it has."""
    frame = msgpack.unpackb(message)
    return frame["frame"], frame["count"]


class Player(asyncio.Protocol):
    """One connection. `heard`, if given, is called with each message of frames."""

    def __init__(self, path: str, read: Read | None = None, heard: Callable[[bytes], None] | None = None) -> None:
        self.arrivals = Arrivals()
        self.received = 0  # bytes of messages of frames
        self.events: list[Mapping[str, Any]] = []
        self.lost_by: Exception | str | None = None
        self._path, self._read, self._heard = path, read, heard
        self._buffer, self._is_open = bytearray(), False
        self._news = asyncio.Event()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast("asyncio.Transport", transport)
        self.transport.write(handshake(self._path))

    def connection_lost(self, exc: Exception | None) -> None:
        self.lost_by = self.lost_by or exc or "the server closed"
        self._news.set()

    def data_received(self, data: bytes) -> None:
        now = perf_counter()
        self._buffer += data
        if not self._is_open:
            head, end, rest = self._buffer.partition(b"\r\n\r\n")
            if not end:
                return
            if b" 101 " not in head.partition(b"\r\n")[0]:
                self.lost_by = head.decode("latin-1")
                self.transport.abort()
                return
            self._buffer, self._is_open = bytearray(rest), True
            self._news.set()
        while (frame := next_frame(self._buffer)) is not None:
            self._take(now, *frame)

    def _take(self, now: float, opcode: int, payload: bytes) -> None:
        if opcode == BINARY:
            arrivals = self.arrivals
            self.received += len(payload)
            frame, count = self._read(payload) if self._read else (len(arrivals.frames), 1)
            arrivals.times.append(now)
            arrivals.frames.append(frame)
            arrivals.counts.append(count)
            if self._heard:
                self._heard(payload)
        elif opcode == TEXT:
            self.events.append(json.loads(payload))
        elif opcode == PING:
            self.transport.write(masked_frame(PONG, payload))
        elif opcode == CLOSE:
            self.lost_by = f"closed with {int.from_bytes(payload[:2], 'big')}"
        self._news.set()

    def forget(self) -> None:
        """Begins to note arrivals anew."""
        self.arrivals, self.received = Arrivals(), 0

    def say(self, commands: Sequence[Command]) -> None:
        """Sends a message of commands."""
        self.transport.write(masked_frame(TEXT, json.dumps(commands, separators=(",", ":")).encode()))

    async def do(self, commands: Sequence[Command]) -> None:
        """Sends a message of commands and waits until they are done. Raises SettingsError if they are refused."""
        known = len(self.events)
        self.say(commands)
        await self.until(lambda: any(one["event"] in ("done", "refused") for one in self.events[known:]))
        for one in self.events[known:]:
            if one["event"] == "refused":
                raise SettingsError(f"the service refused: {one['detail']}")

    async def until(self, holds: Callable[[], bool]) -> None:
        """Waits until something holds of this connection. Raises SettingsError if it ends before."""
        try:
            async with asyncio.timeout(PATIENCE):
                while not holds():
                    if self.lost_by is not None:
                        raise SettingsError(f"a connection was lost: {self.lost_by}")
                    self._news.clear()
                    await self._news.wait()
        except TimeoutError:
            raise SettingsError(f"nothing that was waited for came within {PATIENCE:g} s") from None

    async def opened(self) -> None:
        """Waits for the end of the handshake."""
        await self.until(lambda: self._is_open)


async def connect(endpoint: Endpoint, player: Player, receive_buffer: int = 0) -> None:
    """Connects a player, with a receive buffer of so many bytes if one is given."""
    peer = socket.socket()
    if receive_buffer:
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    peer.setblocking(False)
    loop = asyncio.get_running_loop()
    await loop.sock_connect(peer, ("127.0.0.1", endpoint.port))
    await loop.create_connection(lambda: player, sock=peer)
    await player.opened()
