"""uvicorn's HTTP protocol with limits on connections, on the size and time of a request, and on slow readers."""

from __future__ import annotations

import asyncio
from enum import Enum
from http import HTTPStatus
from typing import Any, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.server import ServerState

from motionsplice.service.admission import origin_of
from motionsplice.service.answers.answer import Answer
from motionsplice.service.edge.context import EdgeContext
from motionsplice.service.edge.corked import Corked
from motionsplice.service.edge.refusal import refusal
from motionsplice.service.edge.stall import StallGuard

POSE = b"/v1/pose?"
MOST_PIPELINED = 16  # requests of a connection that wait for an earlier answer
NOT_PLAIN = frozenset({b"content-length", b"transfer-encoding", b"expect", b"if-none-match", b"origin", b"upgrade"})

NO_UPGRADE = (  # the parser takes the body for the other protocol, so the application would get none
    "the request has a body and asks for another protocol, such as h2c. Speak HTTP/1.1, without the header Upgrade."
)


class Phase(Enum):
    """Which part of a request arrives next."""

    HEAD = "head"  # its line and headers, or nothing yet
    BODY = "body"  # the application has the request
    ANSWERED = "answered"  # it was answered without the application, which does not get its end either


class HttpProtocol(HttpToolsProtocol):
    """One connection, until it becomes a WebSocket."""

    config: EdgeContext

    def __init__(
        self,
        config: EdgeContext,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self._guard: StallGuard | None = None
        self._deadline: asyncio.TimerHandle | None = None
        self._phase = Phase.HEAD
        self._unfinished = 0  # bytes of heads and trailers since a head was complete or a piece of a body arrived
        self._progress = False  # whether the current data completed a head or held a piece of a body
        self._answered = False  # whether a request in the current data was answered at once
        self._is_between = True  # whether the parser expects the first byte of a request
        self._begun = 0  # requests that began in the current data
        self._idle_since = 0.0  # when a known request was answered, which leaves the timer of idle connections running

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(Corked(transport, self.loop))
        self._guard = StallGuard(transport, self.loop, self.config.settings.stall_seconds)
        if reason := self.config.ledger.admit(transport):
            self._refuse(HTTPStatus.TOO_MANY_REQUESTS, "busy", f"{reason}. Try again later.")
        else:
            self._expect_a_request()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._stop_waiting()
        if self._guard is not None:
            self._guard.resume_writing()
        self.config.ledger.forget(self._real_transport)

    def data_received(self, data: bytes) -> None:
        if self._answer_known(data):
            return
        was_between, self._begun, self._answered = self._is_between, 0, False
        if self._phase is Phase.HEAD:
            self._expect_a_request()
        self._progress = False
        super().data_received(data)
        self._unfinished = 0 if self._progress else self._unfinished + len(data)
        if self._unfinished > self.config.settings.max_header:
            self._refuse_head()
        if self._answered and was_between and self._is_between and self._begun == 1:
            self.config.known_headers.learn(data, self.url)

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self._phase, self._is_between = Phase.HEAD, False
        self._begun += 1

    def on_headers_complete(self) -> None:
        if self.transport.is_closing():
            return
        self._stop_waiting()
        self._phase, self._progress = Phase.BODY, True
        size = len(self.url) + sum(len(name) + len(value) for name, value in self.headers)
        if size > self.config.settings.max_header:
            self._refuse_head()
        elif refused := self.config.hosts.refusal(self.headers, self.parser.get_http_version()):
            self._refuse(*refused)
        elif self.parser.should_upgrade() and not self._should_upgrade() and self._has_body():
            self._refuse(HTTPStatus.BAD_REQUEST, "http", NO_UPGRADE)
        elif len(self.pipeline) >= MOST_PIPELINED:
            self._real_transport.abort()
        elif not self._answer_at_once():
            super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        self._progress = True
        if not self.transport.is_closing():
            super().on_body(body)

    def on_message_complete(self) -> None:
        was_answered = self._phase is Phase.ANSWERED
        self._phase, self._progress, self._is_between = Phase.HEAD, True, True
        if not self.transport.is_closing() and not was_answered:
            super().on_message_complete()

    def on_response_complete(self) -> None:
        super().on_response_complete()
        if self._deadline is not None:  # the next request is arriving
            self._unset_keepalive_if_required()

    def timeout_keep_alive_handler(self) -> None:
        left = self._idle_since + self.timeout_keep_alive - self.loop.time()
        if left > 0.0:
            self.timeout_keep_alive_task = self.loop.call_later(left, self.timeout_keep_alive_handler)
        else:
            super().timeout_keep_alive_handler()

    def pause_writing(self) -> None:
        super().pause_writing()
        if self._guard is not None:
            self._guard.pause_writing()

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._guard is not None:
            self._guard.resume_writing()

    def handle_websocket_upgrade(self) -> None:
        if self.transport.is_closing():  # the handshake was refused
            return
        self._stop_waiting()
        self._unset_keepalive_if_required()
        corked = cast("Corked", self.transport)
        if self.cycle is not None and not self.cycle.response_complete:  # its rest would be written into the WebSocket
            corked.transport.abort()
            return
        corked.flush()
        self.transport = corked.transport
        super().handle_websocket_upgrade()

    def send_400_response(self, msg: str) -> None:
        self._refuse(
            HTTPStatus.BAD_REQUEST, "http", "the request is not HTTP/1.1. Send a request line, headers and a body."
        )

    def shutdown(self) -> None:
        self.config.front.begin_stop()
        super().shutdown()

    @property
    def _real_transport(self) -> asyncio.Transport:
        return self.transport.transport if isinstance(self.transport, Corked) else self.transport

    def _has_body(self) -> bool:
        fields = dict(self.headers)
        return b"transfer-encoding" in fields or fields.get(b"content-length", b"0") != b"0"

    def _answer_at_once(self) -> bool:
        """Answers a plain `GET /v1/pose` without a task, which is what games ask for most. Returns whether it did.

        It must be the connection's only open request. Only one is answered in each turn of the event loop, so that a
        client that sends many at once does not hold up others.
        """
        parser, idle = self.parser, self.cycle is None or self.cycle.response_complete
        if not (self.url.startswith(POSE) and idle) or self._answered or parser.get_method() != b"GET":
            return False
        if (
            parser.get_http_version() != "1.1"
            or not parser.should_keep_alive()
            or parser.should_upgrade()
            or any(name in NOT_PLAIN for name, _ in self.headers)
        ):
            return False
        answered = self.config.front.answer_at_once(self.url[len(POSE) :], self.headers)
        if answered is None:
            return False
        self._send(*answered)
        self._answered, self._phase = True, Phase.ANSWERED
        self.on_response_complete()
        return True

    def _answer_known(self, data: bytes) -> bool:
        """Answers a request for a pose that differs from earlier ones only in its time, without the parser.

        The connection must be idle, so its timer is running; it goes on. Returns whether it was answered.
        """
        if self.timeout_keep_alive_task is None or not self._is_between or self.flow.write_paused:
            return False
        url = self.config.known_headers.target(data)
        if not url.startswith(POSE) or (answered := self.config.front.answer_known(url[len(POSE) :])) is None:
            return False
        self._send(*answered)
        self._idle_since = self.loop.time()
        self.server_state.total_requests += 1
        return True

    def _send(self, answer: Answer, identity: str) -> None:
        head = self.config.answer_head.of(self.server_state.default_headers, answer.media_type)
        lines = b"%s%s\r\ncontent-length: %d\r\n\r\n" % (head, identity.encode(), len(answer.body))
        cast("Corked", self.transport).write_now(lines + answer.body)

    def _expect_a_request(self) -> None:
        if self._deadline is None:
            self._deadline = self.loop.call_later(self.config.settings.request_seconds, self._refuse_slow)

    def _stop_waiting(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _refuse_slow(self) -> None:
        seconds = self.config.settings.request_seconds
        detail = f"the request did not arrive within {seconds:g} s. Send it in one piece."
        self._refuse(HTTPStatus.REQUEST_TIMEOUT, "timeout", detail)

    def _refuse_head(self) -> None:
        detail = f"the request line and headers exceed {self.config.settings.max_header} bytes. Send fewer headers."
        self._refuse(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too-large", detail)

    def _refuse(self, status: HTTPStatus, kind: str, detail: str) -> None:
        """Sends a problem without the application, and closes the connection."""
        self._stop_waiting()
        if self.transport.is_closing():
            return
        if self.cycle is not None and self.cycle.response_started and not self.cycle.response_complete:
            self._real_transport.abort()  # the middle of an answer, where a problem cannot be sent
            return
        identity = self.config.front.refuse_connection(status, detail, self.client)
        origin = None if self._phase is Phase.HEAD else origin_of({"headers": self.headers})
        self.transport.write(refusal(status, kind, detail, identity, origin))
        self.transport.close()
