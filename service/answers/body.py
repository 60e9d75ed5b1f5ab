"""Reads the body of a request."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from starlette.types import Receive, Scope

from motionsplice.service.problems import RequestError, TooLargeError, TooSlowError


def header(scope: Scope, name: bytes) -> str:
    """Returns the value of a header, or an empty text."""
    return next((value.decode("latin-1") for key, value in scope["headers"] if key == name), "")


async def whole_body(scope: Scope, receive: Receive, most: int, seconds: float) -> bytes:
    """Returns a whole body. Raises TooLargeError if it has more than `most` bytes, or TooSlowError after `seconds`."""
    try:
        async with asyncio.timeout(seconds):
            return b"".join([chunk async for chunk in chunks(scope, receive, most)])
    except TimeoutError:
        raise TooSlowError(f"the body did not arrive within {seconds:g} s", mend="Send it in one piece") from None


async def chunks(scope: Scope, receive: Receive, most: int) -> AsyncIterator[bytes]:
    """Yields a body as it arrives. Raises TooLargeError, or RequestError if the client disconnects before its end."""
    length, received = header(scope, b"content-length"), 0
    if length.isdigit() and int(length[:18]) > most:
        raise too_large(most)
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise RequestError("the body was cut short")
        chunk = message.get("body", b"")
        received += len(chunk)
        if received > most:
            raise too_large(most)
        yield chunk
        if not message.get("more_body", False):
            return


def too_large(most: int) -> TooLargeError:
    """Returns the error for a body with more than `most` bytes."""
    return TooLargeError(f"the body has more than {most} bytes", mend="Send it in parts")
