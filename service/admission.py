"""Who is answered: the bearer token, and the web pages that may ask."""

from __future__ import annotations

import hmac

from starlette.types import Scope

from motionsplice.service.problems import OriginError, TokenError
from motionsplice.service.settings import Settings

OPEN = frozenset({"/healthz", "/readyz", "/", "/docs", "/redoc", "/openapi.json"})
ASSETS = "/static-offline-docs/"
SUBPROTOCOL, BEARER = "motionsplice", "bearer."


class Admission:
    """Checks requests and handshakes before anything else is done for them."""

    def __init__(self, settings: Settings) -> None:
        self._token = settings.token.get_secret_value().encode() if settings.token else None
        self._origins = frozenset(origin.encode() for origin in settings.origins)

    def check(self, scope: Scope) -> bytes | None:
        """The origin of the page that asks, if one does and may. Raises OriginError or TokenError."""
        origin = host = authorization = None
        for name, value in scope["headers"]:
            if name == b"origin":
                origin = value
            elif name == b"host":
                host = value
            elif name == b"authorization":
                authorization = value
        if origin is not None and not self._may_ask(origin, host):
            mend = "Name it in MOTIONSPLICE_ORIGINS"
            raise OriginError(f"pages of {origin.decode('latin-1')!r:.100} may not ask", mend=mend)
        if self._token is not None and not self._is_open(scope):
            given = self._offered(scope, authorization)
            if not hmac.compare_digest(given, self._token):
                mend = "Send the header `Authorization: Bearer TOKEN`"
                raise TokenError("the token is missing or wrong", mend=mend)
        return origin

    def _may_ask(self, origin: bytes, host: bytes | None) -> bool:
        if b"*" in self._origins or origin in self._origins:
            return True
        return host is not None and origin.partition(b"://")[2] == host  # the service's own pages

    def _is_open(self, scope: Scope) -> bool:
        path: str = scope["path"]
        return path in OPEN or path.startswith(ASSETS) or scope.get("method") == "OPTIONS"

    def _offered(self, scope: Scope, authorization: bytes | None) -> bytes:
        """The token that comes with a request; browsers offer it to a WebSocket as a subprotocol."""
        if authorization is not None:
            kind, _, token = authorization.partition(b" ")
            return token.strip() if kind.lower() == b"bearer" else b""
        for offered in scope.get("subprotocols", ()):
            if offered.startswith(BEARER):
                return str(offered[len(BEARER) :]).encode()
        return b""
