"""The outermost layer: access control, caching, and a direct route for the requests of every tick.

FastAPI's routing and models take several times as long as a pose, so those requests bypass FastAPI.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable

from fastapi import FastAPI
from starlette.types import Message, Receive, Scope, Send

from motionsplice.motion.errors import MotionError
from motionsplice.service.admission import Admission, address_of, origin_of
from motionsplice.service.answers.answer import Answer, Headers
from motionsplice.service.answers.expectation import expected
from motionsplice.service.answers.pose import PoseAnswers
from motionsplice.service.answers.poses import poses
from motionsplice.service.answers.splice import splice
from motionsplice.service.answers.stream import stream
from motionsplice.service.answers.take import take
from motionsplice.service.characters.hub import Hub
from motionsplice.service.logs import request_id, request_ids
from motionsplice.service.problems import (
    MethodError,
    UnknownBankError,
    UpgradeError,
    kind_of,
    stopping,
)
from motionsplice.service.refused import refuse_websocket, send_problem
from motionsplice.service.shared import Shared

logger = logging.getLogger(__name__)

BANKS, BELOW = "/v1/banks/", "/v1/"
POSE, CHARACTERS = "/v1/pose", "/v1/characters"
OTHER, CONNECTION = "other", "connection"  # in metrics: requests of other routes, refusals of the HTTP server
CACHED = frozenset({"/v1/splice", "/v1/expectation", "/v1/bank", "/v1/skeleton", "/v1/clips", "/v1/manifest"})
CACHED_BELOW = ("/v1/clips/", "/v1/tables/")
PREFLIGHT: Headers = [
    (b"access-control-allow-methods", b"GET, HEAD, POST, OPTIONS"),
    (b"access-control-allow-headers", b"authorization, content-type, range, if-none-match"),
    (b"access-control-max-age", b"600"),
]
Handler = Callable[[Shared, Scope, Receive, Send, Headers], Awaitable[int]]


class Front:
    """The service as an ASGI application."""

    def __init__(self, shared: Shared, app: FastAPI) -> None:
        self.shared = shared
        self.app = app
        self.hub = Hub(shared)
        self._request_ids = request_ids()
        self._admission = Admission(shared.settings)
        self._cache_scope = b"private" if shared.settings.token else b"public"
        self._poses = PoseAnswers()
        self._direct: dict[tuple[str, str], Handler] = {
            ("GET", POSE): self._pose,
            ("POST", "/v1/poses"): _poses,
            ("GET", "/v1/splice"): _splice,
            ("GET", "/v1/expectation"): _expectation,
            ("GET", "/v1/stream"): _stream,
            ("POST", "/v1/take"): _take,
        }
        self._methods = {path: method for method, path in self._direct}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            await self._http(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._websocket(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    def begin_stop(self) -> None:
        """Ends all streams and WebSockets, and the wait for bodies. Further calls do nothing."""
        if not self.shared.stopping.is_set():
            self.shared.stopping.set()
            self.shared.arrivals.stop()
            self._stopping = asyncio.ensure_future(self.hub.stop())

    def next_request_id(self) -> str:
        """Returns a new id, under which the log lists a request."""
        return f"{next(self._request_ids):x}"

    def refuse_connection(self, status: int, detail: str, address: str) -> str:
        """Counts and logs a refusal of the HTTP server itself. Returns the request's id."""
        identity = self.next_request_id()
        self.shared.metrics.answered(CONNECTION, status)
        self.shared.refusals.note(identity, address, status, detail)
        return identity

    def answer_at_once(self, query: bytes, headers: Headers) -> tuple[Answer, str] | None:
        """Returns the answer to GET /v1/pose and the request's id, for a server that answers without a task.

        Returns None for a request that is refused, which must take the usual route. The server passes no requests of
        web pages.
        """
        try:
            self._admission.check({"headers": headers, "path": POSE})
            answer = self._poses.answer(self.shared.serving.edition, query)
        except MotionError:
            return None
        self.shared.metrics.answered(POSE, answer.status)
        return answer, self.next_request_id()

    def answer_known(self, query: bytes) -> tuple[Answer, str] | None:
        """Returns the same for a query that differs from an earlier one only in its time.

        The caller knows the headers: the access control has passed them.
        """
        try:
            answer = self._poses.known(self.shared.serving.edition, query)
        except MotionError:
            return None
        if answer is None:
            return None
        self.shared.metrics.answered(POSE, answer.status)
        return answer, self.next_request_id()

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        identity = self.next_request_id()
        request_id.set(identity)
        method = scope["method"]
        # `vary` also without an origin: else a cache that an engine has filled gives pages what they may not read
        headers: Headers = [(b"x-request-id", identity.encode()), (b"vary", b"origin")]
        path, status = scope["path"], 500
        origin = origin_of(scope)
        if origin is not None:  # refusals too, so that a page can read them
            headers.append((b"access-control-allow-origin", origin))
        is_begun = False

        async def begin(message: Message) -> None:
            nonlocal is_begun
            is_begun = True
            await send(message)

        try:
            self._admission.check(scope)
            if origin is not None and method == "OPTIONS":
                status = 204
                await Answer(b"", b"text/plain", status, PREFLIGHT).send(send, headers)
                return
            path, immutable = self._without_digest(path)
            cacheable = path in CACHED or path.startswith(CACHED_BELOW) or (immutable and path == POSE)
            if method == "HEAD" and (cacheable or path == POSE):
                method = "GET"  # the server drops the body
            if method == "GET" and cacheable:
                etag = b'"%s"' % self.shared.serving.bank.digest.encode()
                keep = b"%s, max-age=31536000, immutable" % self._cache_scope if immutable else b"no-cache"
                cached = [(b"etag", etag), (b"cache-control", keep)]
                if _client_has(scope, etag):
                    status = 304
                    await send({"type": "http.response.start", "status": status, "headers": [*headers, *cached]})
                    await send({"type": "http.response.body", "body": b""})
                    return
            else:
                cached = []
            direct = self._direct.get((method, path))
            if direct is not None:
                status = await direct(self.shared, scope, receive, begin, [*headers, *cached])
            else:
                self._check_method(method, path)
                inner = {**scope, "path": path, "method": method}
                status = await self._fastapi(inner, receive, begin, headers, cached)
        except MotionError as error:
            status = await self._refuse(scope, send, path, error, headers)
        except asyncio.CancelledError:  # by uvicorn when the time to stop is over; it would answer 500 in plain text
            if not self.shared.stopping.is_set():
                raise
            if not is_begun:
                status = await self._refuse(scope, send, path, stopping(), headers)
        except Exception:
            logger.exception("failed", extra={"path": path})
            await send_problem(send, 500, "failure", "the service failed; see its log", headers)
        finally:
            self.shared.metrics.answered(path if (method, path) in self._direct else OTHER, status)

    async def _refuse(self, scope: Scope, send: Send, path: str, error: MotionError, headers: Headers) -> int:
        """Logs an error and answers with it. Returns the status."""
        status, kind = kind_of(error)
        self.shared.refusals.note(request_id.get(), address_of(scope), status, str(error), path)
        if isinstance(error, MethodError):
            headers = [*headers, (b"allow", self._methods[path].encode())]
        await send_problem(send, status, kind, str(error), headers)
        return status

    def _without_digest(self, path: str) -> tuple[str, bool]:
        """Returns a path without a bank's digest, and whether it had one. Raises UnknownBankError."""
        if not path.startswith(BANKS):
            return path, False
        digest, _, rest = path[len(BANKS) :].partition("/")
        if digest != self.shared.serving.bank.digest:
            raise UnknownBankError(f"the bank {digest!r:.40} is not served", mend="GET /v1/server returns the digest")
        return BELOW + rest, True

    def _check_method(self, method: str, path: str) -> None:
        """Refuses what FastAPI would call unknown: other methods of a direct route, and the WebSocket without upgrade.

        Raises MethodError or UpgradeError.
        """
        if path in self._methods:
            raise MethodError(f"{path} does not have the method {method}", mend=f"Use {self._methods[path]}")
        if path == CHARACTERS:
            mend = "Connect with a WebSocket, and let proxies pass the header Upgrade on"
            raise UpgradeError(f"{path} is a WebSocket, but the request does not ask for one", mend=mend)

    async def _fastapi(self, scope: Scope, receive: Receive, send: Send, headers: Headers, cached: Headers) -> int:
        """Answers with FastAPI, and adds headers. Returns the status."""
        status = 500

        async def with_headers(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status, ours = message["status"], [*headers, *(cached if message["status"] < 300 else [])]
                replaced = {name for name, _ in ours}
                message["headers"] = [one for one in message["headers"] if one[0] not in replaced] + ours
            await send(message)

        try:
            await self.app(scope, receive, with_headers)
        except Exception:
            logger.exception("failed", extra={"path": scope["path"]})  # FastAPI has answered 500
        return status

    async def _pose(self, shared: Shared, scope: Scope, receive: Receive, send: Send, headers: Headers) -> int:
        await self._poses.answer(shared.serving.edition, scope["query_string"]).send(send, headers)
        return 200

    async def _websocket(self, scope: Scope, receive: Receive, send: Send) -> None:
        identity = self.next_request_id()
        request_id.set(identity)
        try:
            self._admission.check(scope)
            if scope["path"] == CHARACTERS:
                await self.hub.serve(scope, receive, send)
                return
            status, kind, detail = 404, "http", f"no WebSocket here. Connect to {CHARACTERS}."
        except MotionError as error:
            (status, kind), detail = kind_of(error), str(error)
        self.shared.metrics.answered(CHARACTERS if scope["path"] == CHARACTERS else OTHER, status)
        self.shared.refusals.note(identity, address_of(scope), status, detail, scope["path"])
        await refuse_websocket(scope, receive, send, status, kind, detail)


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


def _client_has(scope: Scope, etag: bytes) -> bool:
    """Returns whether the client's If-None-Match header lists this tag."""
    for name, value in scope["headers"]:
        if name == b"if-none-match":
            return value.strip() == b"*" or etag in [tag.strip().removeprefix(b"W/") for tag in value.split(b",")]
    return False
