"""A splice as a stream of frames: how each is encoded, and when it is sent."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from motion.errors import SettingsError
from runtime.evaluator import Evaluator
from runtime.requests import Memory, Poses
from service.models import AXES, UNITS, StreamRequest

STREAM_VERSION = 1
BLOCK = 64  # frames evaluated at once: enough to be quick, few enough that others get their turn
MEDIA_TYPES = {"msgpack": "application/vnd.motionsplice.stream", "json": "application/x-ndjson"}

Times = NDArray[np.float64]
Encode = Callable[[dict[str, Any]], bytes]


@dataclass(frozen=True)
class Clock:
    """Where a stream takes the time from; seconds."""

    now: Callable[[], float]
    sleep: Callable[[float], Awaitable[None]]


def frame_times(evaluator: Evaluator, request: StreamRequest, max_frames: int) -> Times:
    """The times [n] of a stream's frames, seconds. Raises MotionError for all that can be wrong with a request."""
    clip = evaluator.bank.clip(request.locomotion)
    rate = request.rate or clip.rate
    count = int(clip.duration * rate + 1e-6) + 1
    if count > max_frames:
        mend = "Ask for a lower rate or a shorter clip"
        raise SettingsError(f"{count} frames are more than the {max_frames} that one stream may have", mend=mend)
    times = np.minimum(np.arange(count) / rate, clip.duration)
    _evaluate(evaluator, request, times[:1], Memory.begin(1, rate))
    return times


async def messages(evaluator: Evaluator, request: StreamRequest, times: Times, clock: Clock) -> AsyncIterator[bytes]:
    """The encoded header, then the frames: paced one by one, else in blocks.

    Frames are due at their own times after the first, so that delays do not add up.
    """
    encode, as_blob = (_length_delimited, True) if request.format == "msgpack" else (_json_line, False)
    yield encode(_header(evaluator, request, len(times)))
    began, memory = clock.now(), Memory.begin(1, request.rate or evaluator.bank.clip(request.locomotion).rate)
    for first in range(0, len(times), BLOCK):
        block = times[first : first + BLOCK]
        poses = _evaluate(evaluator, request, block, memory)
        frames = [
            encode(_frame(first + row, float(time), poses, row, as_blob=as_blob)) for row, time in enumerate(block)
        ]
        if request.pace == "fast":
            yield b"".join(frames)
            await clock.sleep(0.0)
            continue
        for time, frame in zip(block, frames, strict=True):
            await clock.sleep(max(0.0, began + float(time) - clock.now()))
            yield frame


def _evaluate(evaluator: Evaluator, request: StreamRequest, times: Times, memory: Memory) -> Poses:
    return evaluator.sequence(
        request.locomotion,
        times,
        request.action,
        start=request.start,
        method=request.method,
        posture=request.posture,
        memory=memory,
    )


def _header(evaluator: Evaluator, request: StreamRequest, count: int) -> dict[str, Any]:
    bank = evaluator.bank
    return {
        "stream": STREAM_VERSION,
        "bank": bank.digest,
        "locomotion": request.locomotion,
        "action": request.action,
        "rate": request.rate or bank.clip(request.locomotion).rate,
        "frames": count,
        "axes": AXES,
        "units": UNITS,
        "joints": list(bank.skeleton.names),
        "parents": bank.skeleton.parents.tolist(),
    }


def _frame(number: int, time: float, poses: Poses, row: int, *, as_blob: bool) -> dict[str, Any]:
    arrays = {"root_position": poses.root_positions[row], "rotations": poses.rotations[row]}
    return {"frame": number, "time": time} | {
        name: values.astype("<f4").tobytes() if as_blob else np.round(values.astype(np.float64), 6).tolist()
        for name, values in arrays.items()
    }


def _length_delimited(message: dict[str, Any]) -> bytes:
    packed: bytes = msgpack.packb(message)
    return len(packed).to_bytes(4, "big") + packed


def _json_line(message: dict[str, Any]) -> bytes:
    return json.dumps(message, separators=(",", ":")).encode() + b"\n"
