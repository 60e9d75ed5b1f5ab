"""By which names the service may be called: a web page can make a name of its own resolve to this machine."""

from __future__ import annotations

from collections.abc import Sequence
from http import HTTPStatus
from ipaddress import ip_address

from motionsplice.service.settings import Settings

LOCAL = "localhost"
MOST_KNOWN = 64  # accepted values that are remembered; clients of one service send few

Headers = Sequence[tuple[bytes, bytes]]
Refusal = tuple[HTTPStatus, str, str]


class Hosts:
    """Checks the header Host of requests and handshakes.

    Addresses cannot be rebound, and a page without the token gets nothing, so both are accepted. Other names must be
    `localhost`, the name that the service listens on, or one of `hosts`.
    """

    def __init__(self, settings: Settings) -> None:
        self._names = {LOCAL, settings.host.lower(), *(name.lower() for name in settings.hosts)}
        self._any = settings.token is not None or "*" in settings.hosts
        self._known = set[bytes]()

    def refusal(self, headers: Headers, version: str = "1.1") -> Refusal | None:
        """Returns status, problem type and detail if a request must be refused, else None.

        A request of HTTP/1.0 needs no Host. Health checks of proxies leave it out; browsers never do.
        """
        named = [value for name, value in headers if name == b"host"]
        if not named and version == "1.0":
            return None
        if len(named) != 1:
            problem = "has no Host header" if not named else "has more than one Host header"
            return HTTPStatus.BAD_REQUEST, "http", f"the request {problem}. Send one."
        host = named[0]
        if self._any or host in self._known:
            return None
        name = name_of(host.decode("latin-1"))
        if name not in self._names and not _is_address(name):
            detail = f"this service is not called {name!r:.100}. Add the name to MOTIONSPLICE_HOSTS, or set a token."
            return HTTPStatus.MISDIRECTED_REQUEST, "host", detail
        if len(self._known) < MOST_KNOWN:
            self._known.add(host)
        return None


def name_of(host: str) -> str:
    """Returns the name or address in a Host header, without port and brackets, in lower case."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.partition(":")[0].removesuffix(".").lower()


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True
