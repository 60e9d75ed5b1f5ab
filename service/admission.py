"""Access control: the bearer token, and the web origins that may send requests."""

from __future__ import annotations

import hmac
import re

from starlette.types import Scope

from motionsplice.service.problems import OriginError, TokenError
from motionsplice.service.settings import Settings

OPEN = frozenset({"/healthz", "/readyz", "/", "/docs", "/redoc", "/openapi.json", "/view"})
ASSETS = ("/static-offline-docs/", "/view/")
SUBPROTOCOL, BEARER = "motionsplice", "bearer."
LOOPBACK = rb"(?:localhost|127\.0\.0\.1|\[::1\])(?::\d{1,5})?"
LOOPBACK_HOST, LOOPBACK_PAGE = re.compile(LOOPBACK), re.compile(rb"https?://" + LOOPBACK)
LOOPBACK_ADDRESSES = frozenset({"localhost", "127.0.0.1", "::1"})  # what the service may listen on


class Admission:
    """Checks the token and the origin of requests and handshakes."""

    def __init__(self, settings: Settings) -> None:
        self._token = settings.token.get_secret_value().encode() if settings.token else None
        self._origins = frozenset(origin.encode() for origin in settings.origins)
        self._is_local = settings.host in LOOPBACK_ADDRESSES

    def check(self, scope: Scope) -> None:
        """Raises OriginError or TokenError if a request is not allowed."""
        origin = host = authorization = None
        for name, value in scope["headers"]:
            if name == b"origin":
                origin = value
            elif name == b"host":
                host = value
            elif name == b"authorization":
                authorization = value
        if origin is not None and not self._is_allowed(origin, host):
            mend = "Add it to MOTIONSPLICE_ORIGINS"
            raise OriginError(
                f"requests from web pages of {origin.decode('latin-1')!r:.100} are not allowed", mend=mend
            )
        if self._token is not None and not self._is_open(scope):
            found = self._offered(scope, authorization)
            if not hmac.compare_digest(found, self._token):
                mend = "Send the header `Authorization: Bearer TOKEN`"
                raise TokenError("the token is missing or wrong", mend=mend)

    def _is_allowed(self, origin: bytes, host: bytes | None) -> bool:
        """Returns whether pages of an origin may send requests: those of `origins`, the service's own, and local ones.

        A foreign name can be made to resolve to 127.0.0.1 (DNS rebinding). Its pages would pass for the service's own,
        so a service that listens on loopback, and has no token, must be addressed by a loopback name.
        """
        if b"*" in self._origins or origin in self._origins:
            return True
        if host is None:
            return False
        is_own = origin.partition(b"://")[2] == host
        if self._is_local and LOOPBACK_HOST.fullmatch(host):
            return is_own or LOOPBACK_PAGE.fullmatch(origin) is not None
        return is_own and (not self._is_local or self._token is not None)

    def _is_open(self, scope: Scope) -> bool:
        path: str = scope["path"]
        return path in OPEN or path.startswith(ASSETS) or scope.get("method") == "OPTIONS"

    def _offered(self, scope: Scope, authorization: bytes | None) -> bytes:
        """Returns the token of a request. For a WebSocket, browsers send it as a subprotocol."""
        if authorization is not None:
            kind, _, token = authorization.partition(b" ")
            return token.strip() if kind.lower() == b"bearer" else b""
        for offered in scope.get("subprotocols", ()):
            if offered.startswith(BEARER):
                return str(offered[len(BEARER) :]).encode()
        return b""


def address_of(scope: Scope) -> str:
    """Returns the address of the client, or an empty text if it has none."""
    return str((scope.get("client") or ("",))[0])


def origin_of(scope: Scope) -> bytes | None:
    """Returns the Origin header, which browsers send for web pages, or None."""
    return next((value for name, value in scope["headers"] if name == b"origin"), None)
