from __future__ import annotations

import json
import tracemalloc
from contextlib import suppress
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.errors import MotionError, SettingsError, TimeRangeError, UnknownClipError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, POSTURES
from motionsplice.runtime.splice import Splice
from motionsplice.service.answers.batch import Batch
from motionsplice.service.problems import LimitError, RequestError

MOST = 50
KINDS = {"locomotion": "<i4", "action": "<i4", "hands": "<i4", "time": "<f8", "start": "<f8"}


def as_msgpack(batch: dict[str, Any]) -> bytes:
    body: bytes = msgpack.packb(
        {key: np.array(value, KINDS[key]).tobytes() if key in KINDS else value for key, value in batch.items()}
    )
    return body


GOOD: dict[str, Any] = {
    "clips": ["walk", "wave", "run"],
    "locomotion": [0, 2, 2],
    "action": [1, -1, 1],
    "time": [0.5, 1.0, 0.0],
    "start": [0.25, 0.0, 0.0],
    "posture": "absolute",
}


@pytest.mark.parametrize("form", ["msgpack", "json"])
def test_columns_become_requests(bank: Bank, form: str) -> None:
    batch = Batch.from_msgpack(as_msgpack(GOOD), MOST) if form == "msgpack" else _from_json(_json(GOOD), MOST)
    requests = batch.requests(bank)
    walk, wave, run = (bank.number(name) for name in GOOD["clips"])
    assert requests.locomotion.tolist() == [walk, run, run]
    assert requests.action.tolist() == [wave, run, wave]
    assert requests.method.tolist() == [METHODS["splice"], METHODS["none"], METHODS["splice"]]
    assert set(requests.posture.tolist()) == {POSTURES["absolute"]}
    assert requests.time.tolist() == GOOD["time"]
    assert requests.start.tolist() == GOOD["start"]


def _json(batch: dict[str, Any]) -> bytes:
    return json.dumps(batch).encode()


def _from_json(body: bytes, most: int) -> Batch:
    *steps, batch = Batch.from_json(body, most)
    assert batch is not None
    assert not any(steps)
    return batch


def test_json_is_parsed_in_a_step_for_the_text_and_for_each_column() -> None:
    assert [one is None for one in Batch.from_json(_json(GOOD), MOST)] == [True] * 5 + [False]


@pytest.mark.parametrize("form", ["msgpack", "json"])
def test_hands_are_counted_from_1_and_none_is_0(hands_bank: Bank, form: str) -> None:
    batch = GOOD | {"clips": ["walk", "counting", "run", "other_hands", "counting_hands"], "hands": [4, -1, 3]}
    read, body = (_from_json, _json(batch)) if form == "json" else (Batch.from_msgpack, as_msgpack(batch))
    assert read(body, MOST).requests(hands_bank).hands.tolist() == [
        1 + hands_bank.hand_number("counting_hands"),
        0,
        1 + hands_bank.hand_number("other_hands"),
    ]
    without = {key: value for key, value in batch.items() if key != "hands"} | {"clips": batch["clips"][:3]}
    assert _from_json(_json(without), MOST).requests(hands_bank).hands.tolist() == [0, 0, 0]


NAMES = st.sampled_from(["walk", "run", "counting", "counting_hands", "other_hands", "nobody"])
FITTING = st.sampled_from(
    [("walk", "counting", "other_hands"), ("run", None, "counting_hands"), ("counting", "run", "counting_hands")]
)
TIMES = st.floats(0.0, 1.0)


@given(
    st.lists(st.tuples(FITTING, TIMES), max_size=4)
    | st.lists(st.tuples(FITTING | st.tuples(NAMES, NAMES | st.none(), NAMES | st.none()), TIMES | st.floats())),
    st.sampled_from(["splice", "naive", "none"]),
)
def test_any_hands_on_any_clips_are_shown_or_refused(
    hands_bank: Bank, rows: list[tuple[tuple[str, str | None, str | None], float]], method: str
) -> None:
    named, times = [row for row, _ in rows], [time for _, time in rows]
    names = sorted({name for row in named for name in row if name})
    locomotion, action, hands = ([names.index(one) if (one := row[n]) else -1 for row in named] for n in range(3))
    batch = {"clips": names, "locomotion": locomotion, "action": action, "hands": hands, "time": times}
    evaluator = Evaluator(hands_bank)
    with suppress(RequestError, UnknownClipError, SettingsError, TimeRangeError):
        requests = Batch.from_msgpack(as_msgpack(batch | {"method": method}), MOST).requests(hands_bank)
        poses = evaluator.poses(len(requests))
        evaluator.evaluate(requests, poses)
        np.testing.assert_allclose(np.linalg.norm(poses.rotations, axis=-1), 1.0, atol=1e-5)
        for pose, (name, second, laid), time in zip(poses.rotations, named, times, strict=True):
            alone = evaluator.pose(Splice(name, second, method=method, hands=laid), time)  # type: ignore[arg-type]
            np.testing.assert_array_equal(pose, alone.rotations[0])


def test_a_batch_may_be_empty(bank: Bank) -> None:
    batch = _from_json(_json({"clips": [], "locomotion": [], "time": []}), MOST)
    assert len(batch.requests(bank)) == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clips": None}, "clips: expected a list of names"),
        ({"clips": ["walk", 3, "run"]}, "clips: expected a list of names"),
        ({"time": [0.5, 1.0]}, "locomotion has, found 2. In MessagePack time is float64, and locomotion int32"),
        ({"locomotion": [0, 3, 0]}, "locomotion: character 1 has index 3, but there are 3 clips"),
        ({"locomotion": [0, 0, -1]}, "locomotion: character 2 has index -1"),
        ({"action": [0, 0, -2]}, "action: character 2 has index -2"),
        ({"hands": [3, -1, -1]}, "hands: character 0 has index 3, but there are 3 clips"),
        ({"hands": [-1, -1, 1]}, "hands: 'wave' is also used as a clip. List it twice in clips"),
        ({"method": "splise"}, "method: expected one of splice, naive, none, found 'splise'"),
        ({"posture": 3}, "posture: expected one of relative, absolute, off, found 3"),
        ({"posture": "running"}, "posture: expected one of relative, absolute, off, found 'running'"),
        ({"postur": "off"}, "unknown key 'postur'. Did you mean 'posture'"),
    ],
)
@pytest.mark.parametrize("form", ["msgpack", "json"])
def test_an_error_names_the_key(change: dict[str, Any], words: str, form: str) -> None:
    batch = GOOD | change
    read, body = (_from_json, _json(batch)) if form == "json" else (Batch.from_msgpack, as_msgpack(batch))
    with pytest.raises(RequestError) as caught:
        read(body, MOST)
    assert words in str(caught.value) or "not a MessagePack map of names" in str(caught.value)


def test_lists_of_numbers_in_messagepack_are_refused_with_what_to_send() -> None:
    with pytest.raises(RequestError, match="Send each array as one blob of little-endian numbers"):
        Batch.from_msgpack(msgpack.packb(GOOD), MOST)


@pytest.mark.parametrize("key", ["clips", "locomotion", "time"])
def test_a_missing_key_is_named(key: str) -> None:
    less = {name: value for name, value in GOOD.items() if name != key}
    with pytest.raises(RequestError, match=f"{key}: missing"):
        Batch.from_msgpack(as_msgpack(less), MOST)
    with pytest.raises(RequestError, match=f"{key}: missing"):
        _from_json(_json(less), MOST)


@pytest.mark.parametrize("times", [[0.5, 1.0, "2"], [0.5, None, 1.0], [True, 1.0, 1.0], 3])
def test_json_must_have_numbers(times: Any) -> None:
    with pytest.raises(RequestError, match="time: expected a list of numbers"):
        _from_json(_json(GOOD | {"time": times}), MOST)
    with pytest.raises(RequestError, match="locomotion: expected a list of whole numbers"):
        _from_json(_json(GOOD | {"locomotion": [0, 1.5, 0]}), MOST)
    with pytest.raises(RequestError, match="too large"):
        _from_json(_json(GOOD | {"locomotion": [0, 2**40, 0]}), MOST)


def test_blobs_of_wrong_size_are_refused() -> None:
    packed = msgpack.packb(GOOD | {"locomotion": b"123"} | dict.fromkeys(("time", "action", "start"), b""))
    with pytest.raises(RequestError, match="locomotion: expected a blob of 4 bytes for each character"):
        Batch.from_msgpack(packed, MOST)


def test_too_many_are_refused() -> None:
    many = {"clips": ["walk"], "locomotion": [0] * 51, "time": [0.0] * 51}
    with pytest.raises(LimitError, match="more than 50"):
        Batch.from_msgpack(as_msgpack(many), MOST)
    with pytest.raises(LimitError, match="more than 50"):
        Batch.from_msgpack(as_msgpack(GOOD | {"clips": ["walk"] * 51}), MOST)


def test_an_error_about_an_unknown_clip_suggests_similar_names(bank: Bank) -> None:
    batch = _from_json(_json(GOOD | {"clips": ["wlak", "wave", "run"]}), MOST)
    with pytest.raises(UnknownClipError, match="Did you mean 'walk'"):
        batch.requests(bank)


@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(body: bytes) -> None:
    for read in (Batch.from_msgpack, _from_json):
        with suppress(RequestError, LimitError):
            read(body, MOST)


@given(st.data())
def test_a_damaged_body_is_read_or_refused(data: st.DataObject) -> None:
    body = bytearray(as_msgpack(GOOD))
    for _ in range(data.draw(st.integers(1, 4))):
        body[data.draw(st.integers(0, len(body) - 1))] = data.draw(st.integers(0, 255))
    body = body[: data.draw(st.integers(0, len(body)))]
    with suppress(RequestError, LimitError):
        Batch.from_msgpack(bytes(body), MOST)


@pytest.mark.parametrize("prefix", [b"\x81\xa5clips\xdd\x7f\xff\xff\xff", b"\xdf\x7f\xff\xff\xff", b"\x81\xa4time"])
def test_a_small_body_does_not_grow_in_memory(prefix: bytes) -> None:
    body = prefix + 100_000 * b"\x91"
    tracemalloc.start()
    with pytest.raises(MotionError):
        Batch.from_msgpack(body, 10_000)
    grown = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert grown < 3_000_000
