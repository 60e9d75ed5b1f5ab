"""Batches that are made in blocks."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import msgpack
import numpy as np
import pytest
from starlette.types import Message

from motionsplice.motion.errors import TimeRangeError
from motionsplice.runtime.bank import Bank
from motionsplice.service.answers.answer import PART, Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.poses import BLOCK, poses
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition, Serving
from motionsplice.service.settings import Settings
from motionsplice.service.shared import Shared
from motionsplice.service.turns import Turns


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


class CountedTurns(Turns):
    def __init__(self) -> None:
        super().__init__()
        self.taken = 0

    async def next(self) -> None:
        self.taken += 1
        await super().next()


def _answer(edition: Edition, times: Any) -> tuple[Answer, int]:
    serving = Serving(edition.bank)
    serving.exchange(edition)
    shared = SimpleNamespace(settings=Settings(), metrics=Metrics(), serving=serving, turns=CountedTurns())
    body = _body(times)
    headers = [(b"content-type", b"application/msgpack")]
    scope = {"headers": headers, "query_string": b"format=msgpack"}

    async def receive() -> Message:
        return {"type": "http.request", "body": body, "more_body": False}

    return asyncio.run(poses(cast("Shared", shared), scope, receive)), shared.turns.taken


def _body(times: Any) -> bytes:
    columns = {"locomotion": np.zeros(len(times), "<i4").tobytes(), "time": np.asarray(times, "<f8").tobytes()}
    return bytes(msgpack.packb({"clips": ["walk"], **columns}))


@pytest.mark.parametrize(("count", "turns"), [(0, 0), (1, 0), (BLOCK, 0), (BLOCK + 1, 2), (2 * BLOCK + 1000, 1 + 3)])
def test_each_block_of_a_batch_has_a_turn_and_they_are_the_whole(edition: Edition, count: int, turns: int) -> None:
    times = np.linspace(0.0, 1.0, count)
    answer, taken = _answer(edition, times)
    requests = Batch.from_msgpack(_body(times), 10_000).requests(edition.bank)
    expected = edition.evaluator.poses(count)
    edition.evaluator.evaluate(requests, expected)
    found = msgpack.unpackb(answer.body)
    assert found["rotations"] == expected.rotations.tobytes()
    assert found["root_positions"] == expected.root_positions.tobytes()
    assert taken == turns


def test_a_wrong_request_of_a_later_block_is_named_by_its_place(edition: Edition) -> None:
    times = np.zeros(2 * BLOCK)
    times[BLOCK + 7] = 1e6
    with pytest.raises(TimeRangeError, match=f"character {BLOCK + 7}:"):
        _answer(edition, times)


@pytest.mark.parametrize("size", [0, 1, PART - 1, PART, PART + 1, 3 * PART, 3 * PART + 5])
def test_a_large_body_is_sent_in_parts(size: int) -> None:
    body, sent = np.arange(size, dtype=np.uint8).tobytes(), list[Message]()

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(Answer(body, b"text/plain").send(send, []))
    start, *parts = sent
    assert dict(start["headers"])[b"content-length"] == str(size).encode()
    assert b"".join(part["body"] for part in parts) == body
    assert [part.get("more_body", False) for part in parts] == [True] * (len(parts) - 1) + [False]
    assert max(len(part["body"]) for part in parts) <= PART
    assert len(parts) == max(1, -(-size // PART))
