"""Answers of the direct route."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from starlette.types import Send

Headers = list[tuple[bytes, bytes]]
PART = 512 * 1024  # bytes of a body that are handed to the operating system in a turn of the event loop


class Answer(NamedTuple):
    """A complete response."""

    body: bytes
    media_type: bytes
    status: int = 200
    headers: Sequence[tuple[bytes, bytes]] = ()

    async def send(self, send: Send, more: Headers) -> None:
        """Sends the response with additional headers."""
        length = str(len(self.body)).encode()
        headers = [(b"content-type", self.media_type), (b"content-length", length), *self.headers, *more]
        await send({"type": "http.response.start", "status": self.status, "headers": headers})
        for first in range(0, len(self.body) - PART, PART):
            await send({"type": "http.response.body", "body": self.body[first : first + PART], "more_body": True})
            await asyncio.sleep(0)
        last = max(0, len(self.body) - 1) // PART * PART
        await send({"type": "http.response.body", "body": self.body[last:] if last else self.body})


async def joined(pieces: Iterator[bytes]) -> bytes:
    """Returns all pieces of a body as one, and serves other requests after each."""
    made = []
    for piece in pieces:
        made.append(piece)
        await asyncio.sleep(0)
    return b"".join(made)
