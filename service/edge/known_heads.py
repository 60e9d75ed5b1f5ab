"""Known parts of GET /v1/pose and its answers, so that they are not parsed or built again."""

from __future__ import annotations

GET, VERSION, END = b"GET ", b" HTTP/1.1\r\n", b"\r\n\r\n"
LONGEST = 1024  # bytes of a request that is known
MOST = 64  # known headers

Header = tuple[bytes, bytes]


class KnownHeaders:
    """The bytes of headers that the parser and the access control have passed before.

    A client sends the same ones with each request. `MOST` are kept.
    """

    def __init__(self) -> None:
        self._known: set[bytes] = set()

    def learn(self, request: bytes, url: bytes) -> None:
        """Remembers the headers of a plain GET request, whole and without a body, that the parser has passed."""
        line, _, headers = request.partition(VERSION)
        if len(request) <= LONGEST and line == GET + url and headers.endswith(END):
            if len(self._known) >= MOST:
                self._known.clear()
            self._known.add(headers)

    def target(self, request: bytes) -> bytes:
        """Returns what a GET request asks for if its headers are known, else nothing."""
        if len(request) > LONGEST:
            return b""
        line, _, headers = request.partition(VERSION)
        url = line[len(GET) :]
        return url if headers in self._known and line.startswith(GET) and url.split() == [url] else b""


class AnswerHead:
    """The first lines of an answer, up to the value of x-request-id. The server renews its own headers each second."""

    def __init__(self) -> None:
        self._headers: list[Header] | None = None
        self._heads: dict[bytes, bytes] = {}

    def of(self, headers: list[Header], media_type: bytes) -> bytes:
        """Returns the lines of an answer 200 with the server's `headers`."""
        if headers is not self._headers:
            self._headers, self._heads = headers, {}
        if media_type not in self._heads:
            lines = b"".join([b"%s: %s\r\n" % one for one in headers])
            own = b"content-type: %s\r\nvary: origin\r\nx-request-id: " % media_type
            self._heads[media_type] = b"HTTP/1.1 200 OK\r\n" + lines + own
        return self._heads[media_type]
