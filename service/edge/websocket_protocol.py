"""uvicorn's WebSocket protocol, with limits: nobody who stops reading or floods is waited for."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, cast

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from service.edge.stall import StallGuard

if TYPE_CHECKING:
    from service.edge.config import EdgeConfig

MOST_FRAGMENTS = 1024  # of one message: even empty ones take memory
TOO_LARGE = 1009


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """One connection, once it has become a WebSocket."""

    config: EdgeConfig

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        seconds = self.config.settings.stall_seconds
        self._guard = StallGuard(cast("asyncio.Transport", transport), self.loop, seconds)
        self.close_timeout = seconds

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._guard.resume_writing()
        self.config.ledger.forget(self.transport)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._guard.pause_writing()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._guard.resume_writing()

    def keepalive_timeout(self) -> None:
        self.transport.abort()

    def handle_ping(self) -> None:
        if self.writable.is_set():
            super().handle_ping()
        else:  # a peer that pings and does not read would have pongs pile up
            self.conn.data_to_send()

    def handle_cont(self, event: Frame) -> None:
        super().handle_cont(event)
        if len(self.frames) >= MOST_FRAGMENTS and not self.close_sent:
            self.conn.fail(TOO_LARGE, "too many fragments")
            self.handle_parser_exception()

    def shutdown(self) -> None:
        """The application tells its clients, and closes: here there is nothing to be cut."""
        self.config.front.begin_stop()
        if not self.handshake_complete:
            super().shutdown()
