"""What is answered without the application: a problem, as the bytes of a whole HTTP response."""

from __future__ import annotations

from http import HTTPStatus

from motionsplice.service.problems import MEDIA_TYPE, problem


def refusal(status: HTTPStatus, kind: str, detail: str, identity: str) -> bytes:
    """A response after which the connection is closed; `identity` is the request's."""
    body = problem(status, kind, detail, identity)
    head = (
        f"HTTP/1.1 {status.value} {status.phrase}\r\ncontent-type: {MEDIA_TYPE}\r\ncontent-length: {len(body)}\r\n"
        f"x-request-id: {identity}\r\nconnection: close\r\n\r\n"
    )
    return head.encode() + body
