"""uvicorn's WebSocket protocol, with limits on clients that stop reading or flood the service."""

from __future__ import annotations

import asyncio
import socket
import struct
from http import HTTPStatus
from typing import Any, cast

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidMessage
from websockets.frames import Frame
from websockets.http11 import Request

from motionsplice.service.allowance import Allowance
from motionsplice.service.characters.connection import TRANSPORT
from motionsplice.service.edge.context import EdgeContext
from motionsplice.service.edge.corked import LARGE
from motionsplice.service.edge.refusal import refusal
from motionsplice.service.edge.stall import StallGuard

MOST_UNSENT = 32 * 1024  # bytes that the kernel buffers for a slow client; more would be out of date when read
PIECE = 256  # bytes that are given to the parser at once: 42 empty frames at most
MOST_FRAMES, MOST_BYTES = 32, 16 * 1024  # frames and bytes that are parsed in a turn, within half a millisecond
CONTROLS = 100.0  # pings, pongs and fragments that a client may send at once
MOST_FRAGMENTS = 1024  # fragments of one message; even empty ones take memory
NO_UTF8, TOO_LARGE = 1007, 1009
WHOLE_TEXT, WHOLE_BINARY = 0x81, 0x82  # first byte of a message in one frame


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """One connection, from its upgrade to a WebSocket on."""

    config: EdgeContext

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        seconds = self.config.settings.stall_seconds
        self._guard = StallGuard(cast("asyncio.Transport", transport), self.loop, seconds)
        self.close_timeout = seconds
        self._unparsed = bytearray()
        self._will_parse = False  # once it has its turn
        self._waits_for_allowance = False  # before it gets its turn
        self._frames = self._controls = 0  # of the current turn: frames, and those of them that are no messages
        rate = float(self.config.settings.max_commands)
        self._allowance = Allowance(rate, CONTROLS, self.loop.time(), left=CONTROLS)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            found: socket.socket = transport.get_extra_info("socket")
            found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MOST_UNSENT)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._guard.resume_writing()
        self._unparsed.clear()
        self.config.ledger.forget(self.transport)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._guard.pause_writing()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._guard.resume_writing()

    def data_received(self, data: bytes) -> None:
        if not self.handshake_initiated:
            super().data_received(data)
            if self.conn.handshake_exc is not None and not self.handshake_initiated:
                self._refuse_handshake(self.conn.handshake_exc)
            return
        self._unparsed += data
        if self._will_parse:
            self.transport.pause_reading()
        elif len(self._unparsed) <= PIECE:
            self._parse()
        else:
            self._parse_later()

    async def send(self, message: Any) -> None:
        """Sends a message. Raises ClientDisconnected once the protocol has closed the connection by itself."""
        await self.writable.wait()
        if self.close_sent:
            raise ClientDisconnected
        await super().send(message)

    async def receive(self) -> Any:
        message = await super().receive()
        if self._unparsed and not self.read_paused:  # it has just resumed reading
            self._parse_later()
        return message

    def _parse_later(self, seconds: float = 0.0) -> None:
        """Parses what was received in a turn of its own, and reads no more until then."""
        self.transport.pause_reading()
        if self._will_parse:
            return
        self._will_parse, self._waits_for_allowance = True, seconds > 0.0
        turns = self.config.front.shared.turns
        if seconds:
            self.loop.call_later(seconds, turns.call, self._parse)
        else:
            turns.call(self._parse)

    def _parse(self) -> None:
        """Parses as much as one turn may take, up to the first message, which the application must receive first.

        Frames that are no messages are charged, and the next ones wait if there are too many.
        """
        self._will_parse = False
        self._frames = self._controls = parsed = 0
        while self._unparsed and not self.read_paused and self._frames < MOST_FRAMES and parsed < MOST_BYTES:
            if self.transport.is_closing():
                self._unparsed.clear()
                return
            piece = bytes(self._unparsed[:PIECE])
            del self._unparsed[:PIECE]
            parsed += len(piece)
            super().data_received(piece)
        wait = self._allowance.charge(self._controls, self.loop.time())
        if wait or (self._unparsed and not self.read_paused):
            self._parse_later(wait)
        elif not self.read_paused:
            self.transport.resume_reading()

    def handle_events(self) -> None:
        self._frames += len(self.conn.events)
        super().handle_events()

    def _refuse_handshake(self, error: Exception) -> None:
        """Answers a handshake that `websockets` cannot parse. uvicorn would not answer it, and could not stop then."""
        status, kind = HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too-large"
        if isinstance(error, InvalidMessage):
            status, kind = HTTPStatus.BAD_REQUEST, "http"
        self.handshake_initiated = self.handshake_complete = self.close_sent = True
        detail = f"the request is not a WebSocket handshake: {error}"
        identity = self.config.front.refuse_connection(status, detail, self.client)
        self.transport.write(refusal(status, kind, detail, identity))
        self.transport.close()

    def keepalive_timeout(self) -> None:
        waits_for_turn = self._will_parse and not self._waits_for_allowance
        if self.read_paused or waits_for_turn:  # its pong may be behind commands that wait
            assert self.ping_timeout is not None
            self.pong_timer = self.loop.call_later(self.ping_timeout, self.keepalive_timeout)
        else:
            self.transport.abort()

    def handle_pong(self, event: Frame) -> None:
        self._controls += 1
        super().handle_pong(event)

    def handle_ping(self) -> None:
        self._controls += 1
        if self.writable.is_set():
            super().handle_ping()
        else:  # drops the pong, as pongs would pile up for a peer that does not read
            self.conn.data_to_send()

    def handle_cont(self, event: Frame) -> None:
        self._controls += 1
        super().handle_cont(event)
        if len(self.frames) >= MOST_FRAGMENTS and not self.close_sent:
            self.conn.fail(TOO_LARGE, "too many fragments")
            self.handle_parser_exception()

    def send_receive_event_to_app(self) -> None:
        """Passes a whole message on. uvicorn would log text that is not UTF-8 as an error of the service."""
        if self.curr_msg_data_type == "text" and not self.close_sent and not _is_utf8(b"".join(self.frames)):
            self.frames = []
            self.conn.fail(NO_UTF8, "text must be UTF-8")
            self.handle_parser_exception()
        else:
            super().send_receive_event_to_app()

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


def _is_utf8(data: bytes) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True
