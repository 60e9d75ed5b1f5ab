"""GET /v1/stream: a splice as a chunked response of length-delimited messages, in real time or as fast as possible."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from starlette.types import Receive, Send

from motionsplice.service.answers.answer import Headers
from motionsplice.service.answers.frames import WHICH, Frames
from motionsplice.service.problems import at_most
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Encoding
from motionsplice.service.wire.messages import PROTOCOL, frame_fields, length_delimited, packed, packed_map
from motionsplice.service.wire.parameters import HOW, WHAT, encoding
from motionsplice.service.wire.query import Query, choice, integer

logger = logging.getLogger(__name__)

MEDIA_TYPE = b"application/vnd.motionsplice.stream"
BLOCK = 64  # frames that are evaluated at once and, unless paced, sent at once
LONGER = 100  # a stream may have this many times the frames of a splice, as they are not all in memory
STREAM = Query(
    *WHAT,
    *WHICH,
    choice("pace", "`fast`: as fast as possible; `realtime`: each frame when it is due", ("fast", "realtime"), "fast"),
    integer("ahead", "frames in a message", 1, least=1, most=1000),
    *HOW,
)


@dataclass(frozen=True)
class Clock:
    """The clock of a stream, in seconds; tests replace it."""

    now: Callable[[], float]
    sleep: Callable[[float], Awaitable[object]]


async def stream(shared: Shared, query: bytes, receive: Receive, send: Send, more: Headers) -> None:
    """Sends the header and all frames. Raises MotionError before the first byte is sent, never afterwards."""
    values, settings = STREAM.read(query), shared.settings
    frames = Frames.from_query(shared.serving.edition, values, LONGER * settings.max_frames)
    at_most("ahead", values["ahead"], settings.max_ahead)
    if values["pace"] == "realtime":
        at_most("rate", frames.rate, settings.max_rate)
    with shared.admitted(), shared.metrics.connection("stream"):
        disconnected = asyncio.ensure_future(_disconnected(receive))

        async def wait(seconds: float) -> None:
            if seconds > 0.0:
                await asyncio.wait((disconnected,), timeout=seconds)
            else:
                await asyncio.sleep(0.0)

        clock = Clock(asyncio.get_running_loop().time, wait)
        try:
            headers = [(b"content-type", MEDIA_TYPE), *more]
            await send({"type": "http.response.start", "status": 200, "headers": headers})
            async for count, message in messages(frames, encoding(values), values["ahead"], values["pace"], clock):
                if shared.stopping.is_set() or disconnected.done():
                    return
                await send({"type": "http.response.body", "body": message, "more_body": True})
                shared.metrics.frames_sent.inc(count)
            await send({"type": "http.response.body", "body": b""})
        except Exception:
            logger.exception("a stream failed")  # the client notices that it ends early
        finally:
            disconnected.cancel()


async def messages(
    frames: Frames, how: Encoding, ahead: int, pace: str, clock: Clock
) -> AsyncIterator[tuple[int, bytes]]:
    """Yields the header, then messages of `ahead` frames, each with its number of frames.

    Unless `pace` is `realtime`, several messages are joined. In real time each message has its own due time, so that
    delays do not add up.
    """
    yield 0, length_delimited(packed_map(_header(frames, how)))
    began, bank, paced = clock.now(), frames.edition.bank.digest, pace == "realtime"
    for first, poses in frames.blocks(ahead * max(1, BLOCK // ahead)):
        arrays, count = how.arrays(frames.evaluator, poses), len(poses.flat)
        block = []
        for row in range(0, count, ahead):
            some = {name: one[row : row + ahead] for name, one in arrays.items()}
            few = min(ahead, count - row)
            message = length_delimited(packed(bank, frame_fields(first + row, few, frames.rate), some))
            if paced:
                await clock.sleep(max(0.0, began + (first + row - frames.first) / frames.rate - clock.now()))
                yield few, message
            else:
                block.append(message)
        if not paced:
            yield count, b"".join(block)
            await clock.sleep(0.0)


async def _disconnected(receive: Receive) -> None:
    """Waits until the client disconnects, which sending does not report."""
    while (await receive())["type"] != "http.disconnect":
        pass


def _header(frames: Frames, how: Encoding) -> dict[str, Any]:
    return {
        "stream": PROTOCOL,
        **frames.edition.rig(how.axes),
        **how.fields,
        "locomotion": frames.splice.locomotion,
        "action": frames.splice.action,
        "hands": frames.splice.hands,
        "rate": frames.rate,
        "first": frames.first,
        "frames": frames.count,
    }
