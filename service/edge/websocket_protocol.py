"""uvicorn's WebSocket protocol, with limits on clients that stop reading or flood the service."""

from __future__ import annotations

import asyncio
import socket
import struct
from http import HTTPStatus
from typing import cast

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidMessage
from websockets.frames import Frame
from websockets.http11 import Request

from motionsplice.service.characters.connection import TRANSPORT
from motionsplice.service.edge.context import EdgeContext
from motionsplice.service.edge.corked import LARGE
from motionsplice.service.edge.refusal import refusal
from motionsplice.service.edge.stall import StallGuard

MOST_UNSENT = 32 * 1024  # bytes that the kernel buffers for a slow client; more would be out of date when read
MOST_FRAGMENTS = 1024  # fragments of one message; even empty ones take memory
TOO_LARGE = 1009
WHOLE_TEXT, WHOLE_BINARY = 0x81, 0x82  # first byte of a message in one frame


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """One connection, from its upgrade to a WebSocket on."""

    config: EdgeContext

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        seconds = self.config.settings.stall_seconds
        self._guard = StallGuard(cast("asyncio.Transport", transport), self.loop, seconds)
        self.close_timeout = seconds
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            found: socket.socket = transport.get_extra_info("socket")
            found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MOST_UNSENT)

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

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self._refuse_handshake(self.conn.handshake_exc)

    def _refuse_handshake(self, error: Exception) -> None:
        """Answers a handshake that `websockets` cannot parse. uvicorn would not answer it, and could not stop then."""
        status, kind = HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too-large"
        if isinstance(error, InvalidMessage):
            status, kind = HTTPStatus.BAD_REQUEST, "http"
        self.handshake_initiated = self.handshake_complete = self.close_sent = True
        detail = f"the request is not a WebSocket handshake: {error}"
        self.transport.write(refusal(status, kind, detail, self.config.front.next_request_id()))
        self.transport.close()

    def keepalive_timeout(self) -> None:
        self.transport.abort()

    def handle_ping(self) -> None:
        if self.writable.is_set():
            super().handle_ping()
        else:  # drops the pong, as pongs would pile up for a peer that does not read
            self.conn.data_to_send()

    def handle_cont(self, event: Frame) -> None:
        super().handle_cont(event)
        if len(self.frames) >= MOST_FRAGMENTS and not self.close_sent:
            self.conn.fail(TOO_LARGE, "too many fragments")
            self.handle_parser_exception()

    def handle_connect(self, event: Request) -> None:
        super().handle_connect(event)
        if self.response.status_code == HTTPStatus.SWITCHING_PROTOCOLS:
            cast("dict[str, object]", self.scope["extensions"])[TRANSPORT] = self

    @property
    def is_free(self) -> bool:
        """Whether the send buffer is empty."""
        return self.writable.is_set()

    def send_at_once(self, message: bytes, *, text: bool) -> bool:
        """Sends a message without a task if the send buffer is empty. Returns whether it did."""
        if not self.writable.is_set() or self.close_sent or self.transport.is_closing():
            return False
        kind, size = WHOLE_TEXT if text else WHOLE_BINARY, len(message)
        if size < 126:
            head = struct.pack("!BB", kind, size)
        elif size < 1 << 16:
            head = struct.pack("!BBH", kind, 126, size)
        else:
            head = struct.pack("!BBQ", kind, 127, size)
        if size > LARGE:
            self.transport.writelines((head, message))
        else:
            self.transport.write(head + message)
        return True

    async def nothing_waits(self) -> None:
        """Waits until the send buffer is empty. Raises OSError if the client has disconnected."""
        await self.writable.wait()
        if self.disconnected:
            raise ClientDisconnected

    def shutdown(self) -> None:
        """Begins to stop the application, which closes its WebSockets itself."""
        self.config.front.begin_stop()
        if not self.handshake_complete:
            super().shutdown()
