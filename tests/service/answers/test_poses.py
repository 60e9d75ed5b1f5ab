"""Batches that are made in blocks."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import msgpack
import numpy as np
import orjson
import pytest
from starlette.types import Message

from motionsplice.motion.errors import TimeRangeError
from motionsplice.runtime.bank import Bank
from motionsplice.service.answers.answer import PART, Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.poses import BLOCK, WIDEST, poses
from motionsplice.service.metrics import Metrics
from motionsplice.service.problems import RequestError
from motionsplice.service.serving import Edition, Serving
from motionsplice.service.settings import Settings
from motionsplice.service.shared import Shared
from motionsplice.service.turns import Turns
from motionsplice.service.wire.messages import JSON_NUMBERS, JSON_SHARE


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


def _shared(edition: Edition, **settings: Any) -> Shared:
    serving = Serving(edition.bank)
    serving.exchange(edition)
    return Shared(Settings(**settings), serving, Metrics(), turns=CountedTurns())


def _asked(
    shared: Shared,
    body: bytes,
    kind: str = "application/msgpack",
    form: str = "msgpack",
    patience: float | None = None,
) -> Answer:
    scope = {
        "headers": [(b"content-type", kind.encode())],
        "query_string": f"format={form}".encode(),
        "client": ("10.0.0.1", 5000),
    }

    async def receive() -> Message:
        return {"type": "http.request", "body": body, "more_body": False}

    return asyncio.run(asyncio.wait_for(poses(shared, scope, receive), patience))


def _answer(edition: Edition, times: Any) -> tuple[Answer, int]:
    shared = _shared(edition)
    return _asked(shared, _body(times)), _taken(shared)


def _taken(shared: Shared) -> int:
    assert isinstance(shared.turns, CountedTurns)
    return shared.turns.taken


def _body(times: Any) -> bytes:
    columns = {"locomotion": np.zeros(len(times), "<i4").tobytes(), "time": np.asarray(times, "<f8").tobytes()}
    return bytes(msgpack.packb({"clips": ["walk"], **columns}))


@pytest.mark.parametrize(
    ("count", "turns"), [(0, 0), (1, 0), (BLOCK, 0), (BLOCK + 1, 2 + 1), (2 * BLOCK + 1000, 1 + 3 + 1)]
)
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


@pytest.mark.parametrize(("count", "turns"), [(5, 0), (5000, 1 + 3 + 5 + 1)])
def test_a_large_body_in_json_is_parsed_in_turns(edition: Edition, count: int, turns: int) -> None:
    shared, times = _shared(edition), np.linspace(0.0, 1.0, count).round(3)
    body = {"clips": ["walk"], "locomotion": [0] * count, "time": times.tolist()}
    answer = _asked(shared, json.dumps(body).encode(), "application/json")
    assert answer.body == _answer(edition, times)[0].body
    assert _taken(shared) == turns


@pytest.mark.parametrize("count", [5, 600])
def test_json_of_many_characters_is_written_in_turns(edition: Edition, count: int) -> None:
    shared, times = _shared(edition), np.linspace(0.0, 1.0, count)
    found = orjson.loads(_asked(shared, _body(times), form="json").body)
    expected = msgpack.unpackb(_answer(edition, times)[0].body)
    for key in ("root_positions", "rotations"):
        assert np.array_equal(np.array(found[key], np.float32).ravel(), np.frombuffer(expected[key], "<f4"))
    numbers = sum(np.size(found[key]) for key in ("root_positions", "rotations"))
    assert (
        (_taken(shared) == 0) if count == 5 else (numbers / JSON_NUMBERS < _taken(shared) < numbers / JSON_NUMBERS + 4)
    )


class Ledger:
    """Notes what addresses are charged."""

    def __init__(self, shared: Shared, monkeypatch: pytest.MonkeyPatch, wait: float = 0.0) -> None:
        self.charged: list[float] = []

        def charge(address: str, characters: float, now: float) -> float:
            assert address == "10.0.0.1"
            self.charged.append(characters)
            return wait

        monkeypatch.setattr(shared.batches, "charge", charge)


@pytest.mark.parametrize(("form", "share"), [("msgpack", 1), ("json", JSON_SHARE)])
def test_a_batch_is_charged_its_characters_in_all(
    edition: Edition, monkeypatch: pytest.MonkeyPatch, form: str, share: int
) -> None:
    shared = _shared(edition)
    ledger, body = Ledger(shared, monkeypatch), _body(np.zeros(500))
    _asked(shared, body, form=form)
    assert ledger.charged[0] == len(body) / WIDEST
    assert sum(ledger.charged) == 500 * share


@pytest.mark.parametrize("kind", ["application/msgpack", "application/json"])
def test_a_batch_that_is_refused_is_charged_by_its_size(
    edition: Edition, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    shared = _shared(edition)
    ledger = Ledger(shared, monkeypatch)
    with pytest.raises(RequestError):
        _asked(shared, 2800 * b"x", kind)
    assert ledger.charged == [100.0]


def test_an_address_that_has_asked_for_too_much_waits_before_its_batch_is_parsed(
    edition: Edition, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared = _shared(edition)
    Ledger(shared, monkeypatch, wait=1000.0)
    with pytest.raises(TimeoutError):  # a batch that is parsed raises RequestError
        _asked(shared, b"no batch", patience=0.1)


def test_batches_may_have_as_many_characters_a_second_as_websockets(edition: Edition) -> None:
    shared = _shared(edition, max_load=5000)
    assert shared.batches.charge("a", 5000.0, 0.0) == 0.0
    assert shared.batches.charge("a", 2500.0, 0.0) == 0.5
    assert shared.batches.charge("b", 5000.0, 0.0) == 0.0


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
