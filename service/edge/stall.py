"""Cutting off peers that stop reading: uvicorn waits for them for ever, even to close."""

from __future__ import annotations

import asyncio

LOOKS = 8  # at the buffer, in the time after which a peer is cut off


class StallGuard:
    """Aborts a transport whose buffer does not shrink for some seconds. It hears what the transport tells its protocol.

    A large answer may take long to read; what counts is that the peer goes on.
    """

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop, seconds: float) -> None:
        self._transport = transport
        self._loop = loop
        self._seconds = seconds
        self._timer: asyncio.TimerHandle | None = None
        self._left = 0
        self._since = 0.0
        transport.set_write_buffer_limits(high=0)  # so that it is told of anything that cannot be sent at once

    def pause_writing(self) -> None:
        if self._timer is None:
            self._left, self._since = self._transport.get_write_buffer_size(), self._loop.time()
            self._wait()

    def resume_writing(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _wait(self) -> None:
        self._timer = self._loop.call_later(self._seconds / LOOKS, self._look)

    def _look(self) -> None:
        left, now = self._transport.get_write_buffer_size(), self._loop.time()
        if left < self._left:
            self._since = now
        self._left = left
        if now - self._since >= self._seconds:
            self._transport.abort()
        else:
            self._wait()
