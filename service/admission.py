"""Access control: the bearer token, and the web origins that may send requests."""

from __future__ import annotations

import hmac

from starlette.types import Scope

from motionsplice.service.problems import OriginError, TokenError
from motionsplice.service.settings import Settings

OPEN = frozenset({"/healthz", "/readyz", "/", "/docs", "/redoc", "/openapi.json"})
ASSETS = "/static-offline-docs/"
SUBPROTOCOL, BEARER = "motionsplice", "bearer."


class Admission:
    """Checks the token and the origin of requests and handshakes."""

    def __init__(self, settings: Settings) -> None:
        self._token = settings.token.get_secret_value().encode() if settings.token else None
        self._origins = frozenset(origin.encode() for origin in settings.origins)

    def check(self, scope: Scope) -> bytes | None:
        """Returns the request's Origin header, or None. Raises OriginError or TokenError if it is not allowed."""
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
        return origin

    def _is_allowed(self, origin: bytes, host: bytes | None) -> bool:
        if b"*" in self._origins or origin in self._origins:
            return True
        return host is not None and origin.partition(b"://")[2] == host  # the service's own pages

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
