"""The handlers of the direct route but for single poses: each sends an answer, and returns its status."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from starlette.types import Receive, Scope, Send

from motionsplice.service.answers.answer import Headers
from motionsplice.service.answers.expectation import expected
from motionsplice.service.answers.poses import poses
from motionsplice.service.answers.splice import splice
from motionsplice.service.answers.stream import stream
from motionsplice.service.answers.take import take
from motionsplice.service.shared import Shared

Handler = Callable[[Shared, Scope, Receive, Send, Headers], Awaitable[int]]


async def _poses(shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
    await (await poses(shared, scope, receive)).send(send, headers)
    return 200


async def _splice(shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
    await (await splice(shared, scope["query_string"])).send(send, headers)
    return 200


async def _expectation(shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
    await (await expected(shared, scope["query_string"])).send(send, headers)
    return 200


async def _take(shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
    await (await take(shared, scope, receive)).send(send, headers)
    return 200


async def _stream(shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
    await stream(shared, scope["query_string"], receive, send, headers)
    return 200


HANDLERS: Mapping[tuple[str, str], Handler] = {
    ("POST", "/v1/poses"): _poses,
    ("GET", "/v1/splice"): _splice,
    ("GET", "/v1/expectation"): _expectation,
    ("GET", "/v1/stream"): _stream,
    ("POST", "/v1/take"): _take,
}
