"""POST /v1/poses: many characters at one moment, the request that a game sends every tick."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from starlette.types import Receive, Scope

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.requests import Requests
from motionsplice.service.answers.answer import Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.body import media_type, whole_body
from motionsplice.service.problems import LimitError
from motionsplice.service.serving import Edition
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import FORMS, JSON, JSON_SHARE, MSGPACK
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import Query

SMALL = 32 * 1024  # bytes of a body that is parsed without a turn of its own
BLOCK = 1024  # characters that are evaluated and encoded in a turn, within half a millisecond
POSES = Query(*HOW, format_parameter("json", "msgpack"))


async def poses(shared: Shared, scope: Scope, receive: Receive) -> Answer:
    """Returns the poses of all characters of a batch. Raises MotionError."""
    values, settings = POSES.read(scope["query_string"]), shared.settings
    is_json = media_type(scope, MSGPACK, JSON) == JSON
    most = settings.max_body // (JSON_SHARE if is_json else 1)
    body = await whole_body(scope, receive, most, settings.request_seconds)
    read = Batch.from_json if is_json else Batch.from_msgpack
    if len(body) > SMALL:
        await shared.turns.next()
    batch = read(body, settings.max_batch)
    edition, form, count = shared.serving.edition, values["format"], len(batch.columns["locomotion"])
    if form == "json" and count > (fewer := settings.max_batch // JSON_SHARE):
        raise LimitError(
            f"{count} characters are more than the limit of {fewer} for JSON", mend="Ask for format=msgpack"
        )
    arrays = await _arrays(shared, edition, batch.requests(edition.bank), encoding(values))
    answer_type, write = FORMS[form]
    return Answer(write(edition.bank.digest, {}, arrays), answer_type)


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
