"""Clients that send requests repeatedly: `python -m bench.service.request_client`, with a job as JSON on stdin."""

from __future__ import annotations

import asyncio
import base64
import json
import resource
import sys
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import uvloop

LENGTH = b"content-length: "


@dataclass(frozen=True)
class Job:
    """Connections that each send the requests (base64) one after the other, for `seconds`."""

    port: int
    requests: list[str]
    connections: int
    seconds: float


class Client(asyncio.Protocol):
    """One connection, which sends its next request as soon as the last is answered."""

    def __init__(self, requests: list[bytes], first: int, end: float) -> None:
        self.latencies: list[float] = []
        self.failed = 0
        self._requests = requests
        self._next = first
        self._end = end
        self._buffer = b""
        self._wanted = 0

    def connection_made(self, transport: Any) -> None:
        self._transport = transport
        self._ask()

    def _ask(self) -> None:
        self._asked = time.perf_counter()
        self._transport.write(self._requests[self._next % len(self._requests)])
        self._next += 1

    def data_received(self, data: bytes) -> None:
        self._buffer += data
        if not self._wanted:
            end = self._buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            found = self._buffer.index(LENGTH) + len(LENGTH)
            self._wanted = end + 4 + int(self._buffer[found : self._buffer.index(b"\r\n", found)])
            self.failed += not self._buffer.startswith(b"HTTP/1.1 200")
        if len(self._buffer) >= self._wanted:
            now = time.perf_counter()
            self.latencies.append(now - self._asked)
            self._buffer, self._wanted = b"", 0
            if now < self._end:
                self._ask()
            else:
                self._transport.close()


async def ask(job: Job) -> list[Client]:
    """Connects all clients and lets them send requests until the job ends."""
    loop, requests = asyncio.get_running_loop(), [base64.b64decode(one) for one in job.requests]
    end, clients = time.perf_counter() + job.seconds, []
    for number in range(job.connections):
        make = partial(Client, requests, 7 * number, end)
        _, client = await loop.create_connection(make, "127.0.0.1", job.port)
        clients.append(client)
    await asyncio.sleep(job.seconds + 0.2)
    return clients


def main() -> None:
    job = Job(**json.load(sys.stdin))
    clients = uvloop.run(ask(job))
    used = resource.getrusage(resource.RUSAGE_SELF)
    result = {
        "latencies": [latency for one in clients for latency in one.latencies],
        "failed": sum(one.failed for one in clients),
        "cpu": used.ru_utime + used.ru_stime,
    }
    json.dump(result, sys.stdout)


if __name__ == "__main__":
    main()
