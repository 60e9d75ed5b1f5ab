"""GET /v1/expectation: how far a splice can be trusted, estimated in a thread."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import orjson

from motionsplice.runtime.expectation import Expectation, expectation
from motionsplice.runtime.splice import Splice
from motionsplice.service.answers.answer import Answer
from motionsplice.service.serving import Edition
from motionsplice.service.shared import Shared
from motionsplice.service.wire.messages import JSON, MSGPACK, packed_map
from motionsplice.service.wire.parameters import WHAT, format_parameter, splice_of
from motionsplice.service.wire.query import REQUIRED, Query, text

OTHERS = tuple(one for one in WHAT if one.name not in ("action", "method"))
EXPECTATION = Query(
    text("action", "clip that gives the upper body", REQUIRED), *OTHERS, format_parameter("json", "msgpack")
)
WRITERS: Mapping[str, tuple[str, Callable[[Mapping[str, Any]], bytes]]] = {
    "json": (JSON, orjson.dumps),
    "msgpack": (MSGPACK, packed_map),
}


async def expected(shared: Shared, query: bytes) -> Answer:
    """Returns what to expect of a splice. Raises MotionError."""
    values, edition, splice = check_expectation(shared, query)  # refused before it waits
    with shared.admitted():
        async with shared.estimating:
            found = await asyncio.to_thread(lambda: expectation(edition.estimator, splice))
    media_type, write = WRITERS[values["format"]]
    return Answer(write({"bank": edition.bank.digest, "expected": found and _fields(found)}), media_type.encode())


def check_expectation(shared: Shared, query: bytes) -> tuple[dict[str, Any], Edition, Splice]:
    """Returns the values of a query, the edition and the splice. Raises MotionError."""
    values, edition = EXPECTATION.read(query), shared.serving.edition
    splice = splice_of(values | {"method": "splice"})
    edition.evaluator.action_frames(splice, np.zeros(1))
    return values, edition, splice


def _fields(found: Expectation) -> dict[str, Any]:
    return {**asdict(found), "ratio": found.ratio, "gains_little": found.gains_little}
