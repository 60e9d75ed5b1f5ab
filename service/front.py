"""The outermost layer: access control, caching, and a direct route for the requests of every tick.

FastAPI's routing and models take several times as long as a pose, so those requests bypass FastAPI.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from fastapi import FastAPI
from starlette.types import Message, Receive, Scope, Send

from motionsplice.motion.errors import MotionError
from motionsplice.service.admission import Admission, address_of, origin_of
from motionsplice.service.answers.answer import Answer, Headers
from motionsplice.service.answers.expectation import check_expectation
from motionsplice.service.answers.handlers import HANDLERS, Handler
from motionsplice.service.answers.pose import PoseAnswers
from motionsplice.service.answers.splice import check_splice
from motionsplice.service.caching import (
    POSE,
    Unchanged,
    always_succeeds,
    cache_headers,
    client_has,
    is_cacheable,
    send_unchanged,
)
from motionsplice.service.characters.hub import Hub
from motionsplice.service.logs import request_id, request_ids
from motionsplice.service.problems import (
    MethodError,
    UnknownBankError,
    UpgradeError,
    kind_of,
    stopping,
)
from motionsplice.service.refusals import refuse_websocket, send_problem
from motionsplice.service.shared import Shared

logger = logging.getLogger(__name__)

BANKS, BELOW = "/v1/banks/", "/v1/"
CHARACTERS = "/v1/characters"
WITHOUT_HEAD = frozenset({"/v1/stream", "/v1/job/events", "/v1/poses", "/v1/take"})  # they go on, or have no GET
OTHER, CONNECTION = "other", "connection"  # in metrics: requests of other routes, refusals of the HTTP server
PREFLIGHT: Headers = [
    (b"access-control-allow-methods", b"GET, HEAD, POST, OPTIONS"),
    (b"access-control-allow-headers", b"authorization, content-type, range, if-none-match"),
    (b"access-control-max-age", b"600"),
]


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
        self._direct: dict[tuple[str, str], Handler] = {("GET", POSE): self._pose, **HANDLERS}
        self._checks: dict[str, Callable[[Shared, bytes], object]] = {
            POSE: self._check_pose,
            "/v1/splice": check_splice,
            "/v1/expectation": check_expectation,
        }
        self._methods = {path: method for method, path in self._direct}
        self.paths = frozenset({*self._methods, CHARACTERS})  # of which FastAPI knows nothing

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
            logger.info("stopping", extra={"bank": self.shared.serving.bank.digest})
            self.shared.stopping.set()
            self.shared.arrivals.end()
            self._stopping = asyncio.ensure_future(self.hub.stop())

    def next_request_id(self) -> str:
        """Returns a new id, under which the log lists a request."""
        return f"{next(self._request_ids):x}"

    def refuse_connection(self, status: int, detail: str, client: tuple[str, int] | None) -> str:
        """Counts and logs a refusal of the HTTP server itself. Returns the request's id."""
        identity = self.next_request_id()
        self.shared.metrics.answered(CONNECTION, status)
        self.shared.refusals.note(identity, address_of({"client": client}), status, detail)
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
            if method == "HEAD" and path not in WITHOUT_HEAD:
                method = "GET"  # the server drops the body
            cached: Headers = []
            if method == "GET" and (is_cacheable(path) or (immutable and path == POSE)):
                cached = cache_headers(self.shared.serving.bank.digest, self._cache_scope, immutable=immutable)
            inner = {**scope, "path": path, "method": method}
            status = await self._answer(inner, receive, begin, headers, cached)
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

    async def _answer(self, scope: Scope, receive: Receive, send: Send, headers: Headers, cached: Headers) -> int:
        """Answers a request that is allowed. Returns the status. Raises MotionError."""
        method, path = scope["method"], scope["path"]
        direct, is_known = self._direct.get((method, path)), client_has(scope, cached)
        if direct is None:
            self._check_method(method, path)
            if not (is_known and always_succeeds(scope)):
                return await self._fastapi(scope, receive, send, headers, cached, is_known)
        elif not is_known:
            return await direct(self.shared, scope, receive, send, [*headers, *cached])
        else:
            self._checks[path](self.shared, scope["query_string"])
        return await send_unchanged(send, [*headers, *cached])

    async def _refuse(self, scope: Scope, send: Send, path: str, error: MotionError, headers: Headers) -> int:
        """Logs an error and answers with it. Returns the status."""
        status, kind = kind_of(error)
        self.shared.refusals.note(request_id.get(), address_of(scope), status, str(error), path)
        if isinstance(error, MethodError):
            headers = [*headers, (b"allow", allowed(path, self._methods[path]).encode())]
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
            raise no_method(method, path, self._methods[path])
        if path == CHARACTERS:
            mend = "Connect with a WebSocket, and let proxies pass the header Upgrade on"
            raise UpgradeError(f"{path} is a WebSocket, but the request does not ask for one", mend=mend)

    async def _fastapi(
        self, scope: Scope, receive: Receive, send: Send, headers: Headers, cached: Headers, is_known: bool
    ) -> int:
        """Answers with FastAPI, and adds headers, or with 304 what the client has already. Returns the status."""
        status = 500

        async def with_headers(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status, ours = message["status"], [*headers, *(cached if message["status"] < 300 else [])]
                if is_known and status < 300:
                    status = await send_unchanged(send, ours)
                    raise Unchanged
                replaced = {name for name, _ in ours}
                message["headers"] = [one for one in message["headers"] if one[0] not in replaced] + ours
            await send(message)

        try:
            await self.app(scope, receive, with_headers)
        except Unchanged:
            pass
        except Exception:
            logger.exception("failed", extra={"path": scope["path"]})  # FastAPI has answered 500
        return status

    def _check_pose(self, shared: Shared, query: bytes) -> None:
        self._poses.answer(shared.serving.edition, query)

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


def no_method(method: str, path: str, methods: str) -> MethodError:
    """Returns the error about a method that a path does not have."""
    return MethodError(f"{path[:80]} does not have the method {method}", mend=f"Use {methods}")


def allowed(path: str, methods: str) -> str:
    """Returns the methods that a path has, with HEAD wherever GET is answered at once."""
    return f"{methods}, HEAD" if "GET" in methods and path not in WITHOUT_HEAD else methods
