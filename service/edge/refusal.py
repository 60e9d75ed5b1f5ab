"""Problems that the protocols answer without the application, as bytes of an HTTP response."""

from __future__ import annotations

from http import HTTPStatus

from motionsplice.service.problems import MEDIA_TYPE, problem


def refusal(status: HTTPStatus, kind: str, detail: str, identity: str, origin: bytes | None = None) -> bytes:
    """Returns a response that closes the connection. `identity` is the request's id.

    A page of `origin` may read it, as it may read the application's refusals.
    """
    body = problem(status, kind, detail, identity)
    head = (
        f"HTTP/1.1 {status.value} {status.phrase}\r\ncontent-type: {MEDIA_TYPE}\r\ncontent-length: {len(body)}\r\n"
        f"x-request-id: {identity}\r\nvary: origin\r\nconnection: close\r\n"
    )
    readable = b"" if origin is None else b"access-control-allow-origin: %s\r\n" % origin
    return head.encode() + readable + b"\r\n" + body
