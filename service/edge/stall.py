"""Cutting off peers that stop reading: uvicorn waits for them for ever, even to close."""

from __future__ import annotations

import asyncio


class StallGuard:
    """Aborts a transport whose buffer does not empty in time. It is told what the transport tells its protocol."""

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop, seconds: float) -> None:
        self._transport = transport
        self._loop = loop
        self._seconds = seconds
        self._timer: asyncio.TimerHandle | None = None
        transport.set_write_buffer_limits(high=0)  # so that it is told of anything that cannot be sent at once

    def pause_writing(self) -> None:
        if self._timer is None:
            self._timer = self._loop.call_later(self._seconds, self._transport.abort)

    def resume_writing(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
