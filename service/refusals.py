"""Answers of the front to refused requests and handshakes."""

from __future__ import annotations

from starlette.types import Receive, Scope, Send

from motionsplice.service.answers.answer import Answer, Headers
from motionsplice.service.characters.connection import REFUSED, event_message
from motionsplice.service.characters.hub import accept
from motionsplice.service.logs import request_id
from motionsplice.service.problems import MEDIA_TYPE, URN, problem

# after 408 and 413, the rest of the body would come in place of the next request
WITH_STATUS: dict[int, Headers] = {
    401: [(b"www-authenticate", b"Bearer")],
    408: [(b"connection", b"close")],
    413: [(b"connection", b"close")],
    426: [(b"upgrade", b"websocket"), (b"connection", b"upgrade")],
}


async def send_problem(send: Send, status: int, kind: str, detail: str, headers: Headers) -> None:
    """Sends a problem with additional headers."""
    body = problem(status, kind, detail, request_id.get())
    await Answer(body, MEDIA_TYPE.encode(), status).send(send, [*headers, *WITH_STATUS.get(status, [])])


async def refuse_websocket(scope: Scope, receive: Receive, send: Send, status: int, kind: str, detail: str) -> None:
    """Accepts a WebSocket to refuse it: web pages and most engines cannot read why a handshake failed."""
    await accept(scope, receive, send)
    event = event_message("refused", ref=None, type=URN + kind, detail=detail)
    await send({"type": "websocket.send", "text": event.decode()})
    await send({"type": "websocket.close", "code": REFUSED + status, "reason": kind})
