"""GET /v1/stream: a splice as a chunked response of length-delimited messages, paced or as fast as it goes."""

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
from motionsplice.service.wire.messages import PROTOCOL, frame_fields, length_delimited, packed
from motionsplice.service.wire.parameters import HOW, WHAT, encoding
from motionsplice.service.wire.query import Query, choice, integer

logger = logging.getLogger(__name__)

MEDIA_TYPE = b"application/vnd.motionsplice.stream"
BLOCK = 64  # frames that are evaluated and, if as fast as it goes, sent at once
LONGER = 100  # times as many frames as one splice may have, for they are not held at once
STREAM = Query(
    *WHAT,
    *WHICH,
    choice("pace", "as fast as it goes, or each frame when it is due", ("fast", "realtime"), "fast"),
    integer("ahead", "frames in a message", 1, least=1, most=1000),
    *HOW,
)


@dataclass(frozen=True)
class Clock:
    """Where a stream takes the time from; seconds."""

    now: Callable[[], float]
    sleep: Callable[[float], Awaitable[object]]


async def stream(shared: Shared, query: bytes, receive: Receive, send: Send, more: Headers) -> None:
    """Sends the header and all frames. Raises MotionError before anything is sent, and never afterwards."""
    values, settings = STREAM.read(query), shared.settings
    frames = Frames.asked(shared.serving.edition, values, LONGER * settings.max_frames)
    at_most("ahead", values["ahead"], settings.max_ahead)
    if values["pace"] == "realtime":
        at_most("rate", frames.rate, settings.max_rate)
    with shared.admitted(), shared.metrics.connection("stream"):
        gone = asyncio.ensure_future(_gone(receive))

        async def wait(seconds: float) -> None:
            if seconds > 0.0:
                await asyncio.wait((gone,), timeout=seconds)
            else:
                await asyncio.sleep(0.0)

        clock = Clock(asyncio.get_running_loop().time, wait)
        try:
            headers = [(b"content-type", MEDIA_TYPE), *more]
            await send({"type": "http.response.start", "status": 200, "headers": headers})
            async for count, message in messages(frames, encoding(values), values["ahead"], values["pace"], clock):
                if shared.stopping.is_set() or gone.done():
                    return
                await send({"type": "http.response.body", "body": message, "more_body": True})
                shared.metrics.frames_sent.inc(count)
            await send({"type": "http.response.body", "body": b""})
        except Exception:
            logger.exception("a stream failed")  # it has begun, so all that can be told is that it ends early
        finally:
            gone.cancel()


async def messages(
    frames: Frames, how: Encoding, ahead: int, pace: str, clock: Clock
) -> AsyncIterator[tuple[int, bytes]]:
    """The header, then `ahead` frames a message, with their number; if as fast as it goes, several messages at once.

    Paced ones are due at their own times, so that delays do not add up.
    """
    yield 0, length_delimited(packed(_header(frames, how), {}))
    began, bank, paced = clock.now(), frames.edition.bank.digest, pace == "realtime"
    for first, poses in frames.blocks(ahead * max(1, BLOCK // ahead)):
        arrays, count = how.arrays(frames.evaluator, poses), len(poses.flat)
        block = []
        for row in range(0, count, ahead):
            some = {name: one[row : row + ahead] for name, one in arrays.items()}
            few = min(ahead, count - row)
            message = length_delimited(packed(frame_fields(bank, first + row, few, frames.rate), some))
            if paced:
                await clock.sleep(max(0.0, began + (first + row - frames.first) / frames.rate - clock.now()))
                yield few, message
            else:
                block.append(message)
        if not paced:
            yield count, b"".join(block)
            await clock.sleep(0.0)


async def _gone(receive: Receive) -> None:
    """Returns when the client has gone, which sending alone does not tell."""
    while (await receive())["type"] != "http.disconnect":
        pass


def _header(frames: Frames, how: Encoding) -> dict[str, Any]:
    return {
        "stream": PROTOCOL,
        **frames.edition.rig,
        **how.fields,
        "locomotion": frames.splice.locomotion,
        "action": frames.splice.action,
        "hands": frames.splice.hands,
        "rate": frames.rate,
        "first": frames.first,
        "frames": frames.count,
    }
