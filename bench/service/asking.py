"""A lean HTTP client: connections that ask again as soon as they are answered."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter, process_time
from typing import cast

import numpy as np
import uvloop

from bench.service.servers import Endpoint
from motion.errors import SettingsError
from motion.quaternion import Floats

LENGTH, HEAD_END = b"content-length: ", b"\r\n\r\n"
SETTLING = 0.3  # seconds before anything is noted


@dataclass(frozen=True)
class Asked:
    """One run: seconds of each answer [n], shares of a core that the server and the client took, bytes of a body."""

    latencies: Floats
    seconds: float
    cpu: float
    client_cpu: float
    body: float

    @property
    def per_second(self) -> float:
        return len(self.latencies) / self.seconds

    @property
    def per_core(self) -> float:
        """Answers per second of the server's computing time."""
        return self.per_second / self.cpu


class Asker(asyncio.Protocol):
    """One connection, which asks one thing after the other until it is told to stop."""

    def __init__(self, requests: Sequence[bytes], first: int) -> None:
        self.latencies: list[float] = []
        self.received = 0  # bytes of bodies
        self.problem = ""
        self._requests, self._number = requests, first
        self._pieces: list[bytes] = []
        self._wanted = self._here = 0
        self._is_stopping = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast("asyncio.Transport", transport)
        self._ask()

    def connection_lost(self, exc: Exception | None) -> None:
        if not self._is_stopping:
            self.problem = self.problem or f"a connection was lost: {exc or 'the server closed'}"

    def data_received(self, data: bytes) -> None:
        if not self._wanted:
            data = b"".join((*self._pieces, data))
            self._pieces = []
            end, length = data.find(HEAD_END), data.find(LENGTH)
            if end < 0:
                self._pieces = [data]
                return
            if data[9:12] != b"200":
                self.problem = data.decode("latin-1")
                self.transport.abort()
                return
            size = int(data[length + len(LENGTH) : data.index(b"\r", length)])
            self._here, self._wanted = 0, end + len(HEAD_END) + size
            self.received += size
        self._here += len(data)
        if self._here == self._wanted:
            self.latencies.append(perf_counter() - self._since)
            self._wanted = 0
            self._ask()

    def forget(self) -> None:
        """Begins to note answers anew."""
        self.latencies, self.received = [], 0

    def stop(self) -> None:
        """Asks no more."""
        self._is_stopping = True
        self.transport.abort()

    def _ask(self) -> None:
        self._number += 1
        self._since = perf_counter()
        self.transport.write(self._requests[self._number % len(self._requests)])


def get(path: str) -> bytes:
    """A request."""
    return f"GET {path} HTTP/1.1\r\nhost: 127.0.0.1\r\n\r\n".encode()


def post(path: str, media_type: str, body: bytes) -> bytes:
    """A request with a body."""
    head = (
        f"POST {path} HTTP/1.1\r\nhost: 127.0.0.1\r\ncontent-type: {media_type}\r\ncontent-length: {len(body)}\r\n\r\n"
    )
    return head.encode() + body


def ask(endpoint: Endpoint, requests: Sequence[bytes], connections: int, seconds: float) -> Asked:
    """Has all connections ask for a while, each beginning elsewhere among the requests. Raises SettingsError."""
    return uvloop.run(_ask(endpoint, requests, connections, seconds))


async def _ask(endpoint: Endpoint, requests: Sequence[bytes], connections: int, seconds: float) -> Asked:
    loop, askers = asyncio.get_running_loop(), []
    for number in range(connections):
        asker = Asker(requests, number * len(requests) // connections)
        await loop.create_connection(lambda asker=asker: asker, "127.0.0.1", endpoint.port)  # type: ignore[misc]
        askers.append(asker)
    await asyncio.sleep(SETTLING)
    for asker in askers:
        asker.forget()
    began, own, theirs = perf_counter(), process_time(), endpoint.cpu_seconds
    await asyncio.sleep(seconds)
    lasted, own, theirs = perf_counter() - began, process_time() - own, endpoint.cpu_seconds - theirs
    for asker in askers:
        asker.stop()
        if asker.problem:
            raise SettingsError(f"an answer was not as expected: {asker.problem[:500]}")
    latencies = np.concatenate([asker.latencies for asker in askers])
    body = sum(asker.received for asker in askers) / max(1, len(latencies))
    return Asked(latencies, lasted, theirs / lasted, own / lasted, body)
