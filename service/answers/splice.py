"""GET /v1/splice: a whole splice, or a range of its frames, in one cacheable answer."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any

import numpy as np

from motionsplice.runtime.requests import Poses
from motionsplice.service.answers.answer import Answer, joined
from motionsplice.service.answers.files import FILES, check_encoding, file_answer, written
from motionsplice.service.answers.frames import BLOCK, WHICH, Frames
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import FORMS, frame_fields, json_pieces, packed
from motionsplice.service.wire.parameters import HOW, WHAT, encoding, format_parameter
from motionsplice.service.wire.query import Query

SPLICE = Query(*WHAT, *WHICH, *HOW, format_parameter("json", "msgpack", *FILES))


async def splice(shared: Shared, query: bytes) -> Answer:
    """Returns the frames as one map, or as a file of the motion. Raises MotionError."""
    values, frames, how = check_splice(shared, query)
    form: str = values["format"]
    if form in FILES:
        write = _file(frames, form)
    elif form == "json":
        write = _json(frames, how)
    else:
        write = _msgpack(frames, how)
    with shared.admitted():
        body = await joined(write)
    if form in FILES:
        return file_answer(body, form, values["locomotion"], values["action"], values["hands"])
    return Answer(body, FORMS[form].media_type)


def check_splice(shared: Shared, query: bytes) -> tuple[dict[str, Any], Frames, Encoding]:
    """Returns the values of a query, its frames, of which one is evaluated, and their encoding. Raises MotionError."""
    values = SPLICE.read(query)
    frames, how = Frames.from_query(shared.serving.edition, values, shared.settings.max_frames), encoding(values)
    if values["format"] in FILES:
        check_encoding(values["format"], how)
    return values, frames, how


def _fields(frames: Frames) -> dict[str, Any]:
    return frame_fields(frames.first, frames.count, frames.rate)


def _msgpack(frames: Frames, how: Encoding) -> Iterator[bytes]:
    arrays = yield from _arrays(frames, how)
    yield packed(frames.edition.bank.digest, _fields(frames), arrays)


def _json(frames: Frames, how: Encoding) -> Iterator[bytes]:
    arrays = yield from _arrays(frames, how)
    yield from json_pieces(frames.edition.bank.digest, _fields(frames), arrays)


def _arrays(frames: Frames, how: Encoding) -> Generator[bytes, None, Arrays]:
    """Returns the encoded frames. Yields nothing, so that others are served in between."""
    blocks: list[Arrays] = []
    for _, poses in frames.blocks(BLOCK):
        blocks.append(how.arrays(frames.evaluator, poses))
        yield b""
    return {name: np.concatenate([one[name] for one in blocks]) for name in blocks[0]}


def _file(frames: Frames, form: str) -> Iterator[bytes]:
    roots, rotations = [], []
    for _, poses in frames.blocks(BLOCK):
        roots.append(poses.root_positions)
        rotations.append(poses.rotations)
        yield b""
    poses, bank = Poses(np.concatenate(roots), np.concatenate(rotations)), frames.edition.bank
    yield from written(poses.clip(frames.splice.name, bank.skeleton, frames.rate), bank.roles, form)
