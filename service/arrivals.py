"""Waits for the bodies of requests, which end when they last too long or the service stops."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from motionsplice.service.problems import TooSlowError, stopping


class Arrivals:
    """The bodies that a process waits for. They end when the service stops."""

    def __init__(self, stopping: asyncio.Event) -> None:
        self._stopping = stopping
        self._waits: set[asyncio.Timeout] = set()

    def end(self) -> None:
        """Ends all waits, once the service stops; later ones end at once if a body has not arrived."""
        for wait in self._waits:
            if not wait.expired():
                wait.reschedule(asyncio.get_running_loop().time())

    @asynccontextmanager
    async def until(self, when: float, late: TooSlowError) -> AsyncIterator[None]:
        """Raises `late` if the context lasts until a time of the event loop, or NotReadyError if the service stops."""
        wait = asyncio.timeout_at(asyncio.get_running_loop().time() if self._stopping.is_set() else when)
        self._waits.add(wait)
        try:
            async with wait:
                yield
        except TimeoutError:
            if self._stopping.is_set():
                raise stopping() from None
            raise late from None
        finally:
            self._waits.discard(wait)
