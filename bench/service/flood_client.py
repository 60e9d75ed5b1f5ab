"""Clients that flood WebSockets: `python -m bench.service.flood_client`, with a job as JSON on stdin."""

from __future__ import annotations

import asyncio
import base64
import json
import sys
from dataclasses import dataclass
from typing import Any

import uvloop

from bench.service.stream_client import HANDSHAKE, Connections


@dataclass(frozen=True)
class Job(Connections):
    """Each connection sends `first` and then `flood` (base64) as fast as it is taken."""

    first: str
    flood: str


class Flooder(asyncio.Protocol):
    """One connection, which reads and ignores all that it gets."""

    def __init__(self, job: Job) -> None:
        self.times = 0
        self._job = job
        self._flood = base64.b64decode(job.flood)
        self._is_open = False
        self._may_write = asyncio.Event()
        self._may_write.set()

    def connection_made(self, transport: Any) -> None:
        self._transport = transport
        transport.write(HANDSHAKE.format(path=self._job.path).encode())

    def data_received(self, data: bytes) -> None:
        if not self._is_open:
            self._is_open = True
            self._transport.write(base64.b64decode(self._job.first))
            self._pouring = asyncio.ensure_future(self._pour())

    def pause_writing(self) -> None:
        self._may_write.clear()

    def resume_writing(self) -> None:
        self._may_write.set()

    def connection_lost(self, exc: Exception | None) -> None:
        self._may_write.set()

    async def _pour(self) -> None:
        while not self._transport.is_closing():
            self._transport.write(self._flood)
            self.times += 1
            await asyncio.sleep(0)
            await self._may_write.wait()


async def flood(job: Job) -> int:
    """Floods until the job ends. A connection that is cut off is opened again. Returns how often `flood` was sent."""
    loop, end, every = asyncio.get_running_loop(), asyncio.get_running_loop().time() + job.seconds, list[Flooder]()

    async def one() -> None:
        while loop.time() < end:
            transport, client = await loop.create_connection(lambda: Flooder(job), "127.0.0.1", job.port)
            every.append(client)
            while loop.time() < end and not transport.is_closing():
                await asyncio.sleep(0.05)
            transport.abort()

    await asyncio.gather(*(one() for _ in range(job.connections)))
    return sum(client.times for client in every)


def main() -> None:
    print(uvloop.run(flood(Job(**json.load(sys.stdin)))))


if __name__ == "__main__":
    main()
