"""Reads the body of a request."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import orjson
from starlette.types import Receive, Scope

from motionsplice.service.arrivals import Arrivals
from motionsplice.service.parsing import loads
from motionsplice.service.problems import MediaTypeError, RequestError, TooLargeError, TooSlowError

SLOWEST = 32 * 1024  # bytes per second of an upload


def header(scope: Scope, name: bytes) -> str:
    """Returns the value of a header, or an empty text."""
    return next((value.decode("latin-1") for key, value in scope["headers"] if key == name), "")


def media_type(scope: Scope, *supported: str) -> str:
    """Returns the media type of a body. Raises MediaTypeError if it is none of those that are supported."""
    found = header(scope, b"content-type").partition(";")[0].strip().lower()
    if found not in supported:
        raise MediaTypeError(f"content type {found!r:.80} is not supported", mend=f"Send {' or '.join(supported)}")
    return found


def json_map(body: bytes) -> dict[str, Any]:
    """Returns a body that is a map in JSON. Raises RequestError."""
    try:
        values = loads(body)
    except orjson.JSONDecodeError as error:
        raise RequestError(f"the body is not JSON ({error})") from None
    if not isinstance(values, dict):
        raise RequestError("the body is not a map")
    return values


async def whole_body(scope: Scope, receive: Receive, most: int, seconds: float, arrivals: Arrivals) -> bytes:
    """Returns a whole body.

    Raises TooLargeError if it has more than `most` bytes, TooSlowError after `seconds`, or NotReadyError if the service
    stops.
    """
    late = TooSlowError(f"the body did not arrive within {seconds:g} s", mend="Send it in one piece")
    async with arrivals.until(asyncio.get_running_loop().time() + seconds, late):
        return b"".join([chunk async for chunk in chunks(scope, receive, most)])


async def steady_chunks(
    scope: Scope, receive: Receive, most: int, seconds: float, arrivals: Arrivals
) -> AsyncIterator[bytes]:
    """Yields a body as it arrives, as `chunks` does.

    Raises TooSlowError if it falls `seconds` behind one that comes at SLOWEST, or NotReadyError if the service stops.
    """
    loop, received = asyncio.get_running_loop(), 0
    begun, body = loop.time(), chunks(scope, receive, most)
    mend = f"Send at least {SLOWEST // 1024} KiB a second"
    while True:
        late = TooSlowError(f"the body stopped coming after {received} bytes", mend=mend)
        async with arrivals.until(begun + seconds + received / SLOWEST, late):
            chunk = await anext(body, None)
        if chunk is None:
            return
        received += len(chunk)
        yield chunk


async def chunks(scope: Scope, receive: Receive, most: int) -> AsyncIterator[bytes]:
    """Yields a body as it arrives.

    Raises MediaTypeError if it is compressed, TooLargeError, or RequestError if the client disconnects before its end.
    """
    if header(scope, b"content-encoding").strip().lower() not in ("", "identity"):
        found = header(scope, b"content-encoding")
        raise MediaTypeError(f"content encoding {found!r:.40} is not supported", mend="Send the body uncompressed")
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
