"""GET /v1/expectation: how far a splice can be trusted."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import msgpack
import pytest
from fastapi.testclient import TestClient

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import expectation
from motionsplice.runtime.splice import Splice
from motionsplice.service.answers import expectation as answers
from tests.service.conftest import warm_client

PATH = "/v1/expectation"


def test_it_is_what_the_bank_expects(client: TestClient, bank: Bank) -> None:
    query = "locomotion=run&action=wave~mirror&start=0.5&posture=absolute"
    answer = client.get(f"{PATH}?{query}").json()
    found = expectation(Evaluator(bank), Splice("run", "wave~mirror", start=0.5, posture="absolute"))
    assert found is not None
    assert answer["bank"] == bank.digest
    assert answer["expected"] == {**vars(found), "ratio": found.ratio, "gains_little": found.gains_little}
    packed = client.get(f"{PATH}?{query}&format=msgpack")
    assert packed.headers["content-type"] == "application/msgpack"
    assert msgpack.unpackb(packed.content) == answer


def test_a_running_posture_needs_no_memory_of_the_client(client: TestClient) -> None:
    answer = client.get(f"{PATH}?locomotion=run&action=wave&posture=running")
    assert answer.json()["expected"]["replaced"] > 0.0


def test_nothing_is_expected_of_an_action_that_stands(standing_bank: Bank) -> None:
    action = next(clip.name for clip in standing_bank.clips if clip.stands)
    with warm_client(standing_bank) as client:
        answer = client.get(f"{PATH}?locomotion=walk&action={action}")
        assert answer.json() == {"bank": standing_bank.digest, "expected": None}
        assert client.get(f"{PATH}?locomotion=walk&action={action}&start=99").json()["status"] == 422


@pytest.mark.parametrize(
    ("query", "status", "words"),
    [
        ("locomotion=walk", 422, "action: missing"),
        ("action=wave", 422, "locomotion: missing"),
        ("locomotion=walk&action=wafe", 404, "Did you mean 'wave'"),
        ("locomotion=walk&action=wave&start=99", 422, "start 99.0 s lies outside"),
        ("locomotion=walk&action=wave&start=nan", 422, "start: "),
        ("locomotion=walk&action=wave&method=naive", 422, "unknown parameter 'method'"),
        ("locomotion=walk&action=wave&posture=upright", 422, "posture: "),
        ("locomotion=walk&action=wave&hands=fists", 404, "the bank has no hands"),
        ("locomotion=walk&action=wave&format=bvh", 422, "format: "),
    ],
)
def test_what_cannot_be_answered_is_a_problem(client: TestClient, query: str, status: int, words: str) -> None:
    problem = client.get(f"{PATH}?{query}").json()
    assert problem["status"] == status
    assert words in problem["detail"]


def test_other_requests_are_answered_while_it_is_estimated(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    began, may_end = threading.Event(), threading.Event()

    def slow(*_: object) -> None:
        began.set()
        assert may_end.wait(30.0)

    monkeypatch.setattr(answers, "expectation", slow)
    with warm_client(bank) as client, ThreadPoolExecutor() as pool:
        waiting = pool.submit(client.get, f"{PATH}?locomotion=walk&action=wave")
        assert began.wait(30.0)
        assert client.get("/v1/pose?locomotion=walk&time=0").status_code == 200
        assert not waiting.done()
        may_end.set()
        assert waiting.result().json()["expected"] is None
