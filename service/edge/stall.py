"""Cuts off peers that stop reading. uvicorn would wait for them for ever, even to close."""

from __future__ import annotations

import asyncio

LOOKS = 8  # how often the buffer is checked before a peer is cut off


class StallGuard:
    """Aborts a transport whose send buffer does not shrink for some seconds.

    A large answer may take long to read, as long as the peer keeps reading. The protocol forwards `pause_writing` and
    `resume_writing`.
    """

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop, seconds: float) -> None:
        self._transport = transport
        self._loop = loop
        self._seconds = seconds
        self._timer: asyncio.TimerHandle | None = None
        self._left = 0
        self._since = 0.0
        transport.set_write_buffer_limits(high=0)  # so that it pauses as soon as anything is buffered

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
