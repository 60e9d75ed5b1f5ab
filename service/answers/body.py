"""Reading the body of a request."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from starlette.types import Receive, Scope

from motionsplice.service.problems import RequestError, TooLargeError, TooSlowError


def header(scope: Scope, name: bytes) -> str:
    """The value of a header, or nothing."""
    return next((value.decode("latin-1") for key, value in scope["headers"] if key == name), "")


async def whole_body(scope: Scope, receive: Receive, most: int, seconds: float) -> bytes:
    """All of a body. Raises TooLargeError before more than `most` bytes are held, and TooSlowError."""
    try:
        async with asyncio.timeout(seconds):
            return b"".join([chunk async for chunk in chunks(scope, receive, most)])
    except TimeoutError:
        raise TooSlowError(f"the body did not arrive within {seconds:g} s", mend="Send it at once") from None


async def chunks(scope: Scope, receive: Receive, most: int) -> AsyncIterator[bytes]:
    """A body as it arrives. Raises TooLargeError, and RequestError if the client goes before its end."""
    length, seen = header(scope, b"content-length"), 0
    if length.isdigit() and int(length[:18]) > most:
        raise _too_large(most)
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise RequestError("the body was cut short")
        chunk = message.get("body", b"")
        seen += len(chunk)
        if seen > most:
            raise _too_large(most)
        yield chunk
        if not message.get("more_body", False):
            return


def _too_large(most: int) -> TooLargeError:
    return TooLargeError(f"the body has more than {most} bytes", mend="Send it in parts")
