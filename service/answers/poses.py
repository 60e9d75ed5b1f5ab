"""POST /v1/poses: many characters at one moment, the request that a game sends every tick."""

from __future__ import annotations

import asyncio
from time import perf_counter

import numpy as np
from starlette.types import Receive, Scope

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.requests import Requests
from motionsplice.service.admission import address_of
from motionsplice.service.answers.answer import Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.body import media_type, whole_body
from motionsplice.service.problems import LimitError
from motionsplice.service.serving import Edition
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import FORMS, JSON, JSON_NUMBERS, JSON_SHARE, MSGPACK, json_pieces
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import Query

SMALL = 32 * 1024  # bytes of a body that is parsed without a turn of its own
WIDEST = 28  # bytes of a character in a body that has all columns
BLOCK = 1024  # characters that are evaluated and encoded in a turn, within half a millisecond
POSES = Query(*HOW, format_parameter("json", "msgpack"))


async def poses(shared: Shared, scope: Scope, receive: Receive) -> Answer:
    """Returns the poses of all characters of a batch. Raises MotionError.

    An address that has asked for more than it may has to wait, before its body is parsed and again before the poses are
    made.
    """
    values, settings = POSES.read(scope["query_string"]), shared.settings
    is_json = media_type(scope, MSGPACK, JSON) == JSON
    most = settings.max_body // (JSON_SHARE if is_json else 1)
    body = await whole_body(scope, receive, most, settings.request_seconds, shared.arrivals)
    charged = len(body) / WIDEST
    await _charge(shared, scope, charged)
    batch = await _read(shared, body, is_json)
    edition, form, count = shared.serving.edition, values["format"], len(batch.columns["locomotion"])
    if form == "json" and count > (fewer := settings.max_batch // JSON_SHARE):
        raise LimitError(
            f"{count} characters are more than the limit of {fewer} for JSON", mend="Ask for format=msgpack"
        )
    await _charge(shared, scope, max(0.0, count * (JSON_SHARE if form == "json" else 1) - charged))
    arrays = await _arrays(shared, edition, batch.requests(edition.bank), encoding(values))
    return Answer(await _written(shared, edition.bank.digest, arrays, form), FORMS[form].media_type)


async def _charge(shared: Shared, scope: Scope, characters: float) -> None:
    """Charges characters to the client's address, and waits if that has no more left."""
    if wait := shared.batches.charge(address_of(scope), characters, asyncio.get_running_loop().time()):
        await asyncio.sleep(wait)


async def _read(shared: Shared, body: bytes, is_json: bool) -> Batch:
    most, is_large = shared.settings.max_batch, len(body) > SMALL
    if is_large:
        await shared.turns.next()
    if not is_json:
        return Batch.from_msgpack(body, most)
    batch = None
    for batch in Batch.from_json(body, most):
        if batch is None and is_large:
            await shared.turns.next()
    assert batch is not None
    return batch


async def _written(shared: Shared, bank: str, arrays: Arrays, form: str) -> bytes:
    """Returns arrays as a message. That of many characters has a turn of its own, and JSON several."""
    if form != "json" or sum(one.size for one in arrays.values()) <= JSON_NUMBERS:
        if len(next(iter(arrays.values()))) > BLOCK:
            await shared.turns.next()
        return FORMS[form].write(bank, {}, arrays)
    made = []
    for piece in json_pieces(bank, {}, arrays):
        await shared.turns.next()
        made.append(piece)
    return b"".join(made)


async def _arrays(shared: Shared, edition: Edition, requests: Requests, how: Encoding) -> Arrays:
    """Returns the encoded poses of all requests, made in blocks so that others are served in between."""
    arrays: Arrays = {}
    count = len(requests)
    for first in range(0, max(1, count), BLOCK):
        if count > BLOCK:
            await shared.turns.next()
        began, block = perf_counter(), Requests(requests.records[first : first + BLOCK])
        out = edition.evaluator.poses(len(block))
        try:
            edition.evaluator.evaluate(block, out)
        except MotionError:
            edition.evaluator.evaluate(requests, edition.evaluator.poses(count))  # names its place in the whole batch
            raise
        made = how.arrays(edition.evaluator, out)
        shared.metrics.evaluation.observe(perf_counter() - began)
        if count <= BLOCK:
            return made
        arrays = arrays or {key: np.empty((count, *one.shape[1:]), one.dtype) for key, one in made.items()}
        for key, one in made.items():
            arrays[key][first : first + BLOCK] = one
    return arrays
