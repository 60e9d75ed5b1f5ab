from __future__ import annotations

import json
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.findings import Findings
from bench.service.clients import Taken, between, create
from bench.service.profile import costs
from bench.service.request_client import Client as Asker
from bench.service.statistics import intervals, jitter, lost, percentiles
from bench.service.stream_client import BINARY, PING, PONG, TEXT, Client, Job
from bench.service.streams import counted

RATE = 60.0


class Wire:
    """A transport that records all bytes written."""

    def __init__(self) -> None:
        self.written = b""

    def write(self, data: bytes) -> None:
        self.written += data

    def close(self) -> None:
        pass


def frame(opcode: int, payload: bytes) -> bytes:
    """A WebSocket frame as a server sends it."""
    size = len(payload)
    if size < 126:
        return bytes((0x80 | opcode, size)) + payload
    if size < 2**16:
        return bytes((0x80 | opcode, 126)) + size.to_bytes(2, "big") + payload
    return bytes((0x80 | opcode, 127)) + size.to_bytes(8, "big") + payload


def message(number: int, size: int) -> bytes:
    """A message as the service sends it, with a blob of `size` bytes."""
    return bytes(msgpack.packb({"bank": 32 * "a", "frame": number, "count": 1, "rotations": bytes(size)}))


def opened(**options: Any) -> tuple[Client, Wire]:
    client, wire = Client(Job(0, "/", 1, 1.0, **options)), Wire()
    client.connection_made(wire)
    client.data_received(b"HTTP/1.1 101 Switching Protocols\r\nupgrade: websocket\r\n\r\n")
    return client, wire


@given(
    st.lists(st.tuples(st.integers(0, 2**32 - 1), st.sampled_from([0, 30, 400, 70_000])), min_size=1, max_size=5),
    st.integers(1, 5000),
)
def test_messages_are_parsed_for_any_split_of_the_bytes(sent: list[tuple[int, int]], piece: int) -> None:
    client, _ = opened(keep=5)
    whole = b"".join(frame(BINARY, message(*one)) for one in sent)
    for at in range(0, len(whole), piece):
        client.data_received(whole[at : at + piece])
    assert client.numbers == [number for number, _ in sent]
    assert client.kept == [message(*one) for one in sent]
    assert client.bytes == sum(len(message(*one)) for one in sent)
    assert client.arrivals == sorted(client.arrivals)


def test_a_client_answers_pings_keeps_events_and_counts_messages_without_numbers() -> None:
    client, wire = opened()
    wire.written = b""
    client.data_received(frame(PING, b"abc") + frame(TEXT, b'{"event": "done"}') + frame(BINARY, bytes(300)))
    assert wire.written == bytes((0x80 | PONG, 0x80 | 3)) + bytes(4) + b"abc"
    assert client.events == ['{"event": "done"}']
    assert client.numbers == [-1]


def test_commands_are_sent_once_the_handshake_is_done() -> None:
    client, wire = Client(Job(0, "/", 1, 1.0, ["x" * 200])), Wire()
    client.connection_made(wire)
    before = wire.written
    client.data_received(b"HTTP/1.1 101 Switching")
    assert wire.written == before
    client.data_received(b" Protocols\r\n\r\n")
    assert wire.written[len(before) :] == bytes((0x81, 0x80 | 126, 0, 200)) + bytes(4) + 200 * b"x"


@pytest.mark.parametrize("piece", [1, 7, 1000])
def test_an_answer_ends_after_its_content_length_and_errors_are_counted(piece: int) -> None:
    asker, wire = Asker([b"first", b"second"], 0, float("inf")), Wire()
    asker.connection_made(wire)
    for status in (b"200 OK", b"404 Not Found"):
        answer = b"HTTP/1.1 " + status + b"\r\ncontent-length: 12\r\nx: y\r\n\r\n" + b"a\r\n\r\nbcdefgh"
        for at in range(0, len(answer), piece):
            asker.data_received(answer[at : at + piece])
    assert len(asker.latencies) == 2
    assert asker.failed == 1
    assert wire.written == b"firstsecondfirst"


@given(st.lists(st.integers(1, 4), min_size=2, max_size=30), st.floats(0.0, 1e5))
def test_frames_that_arrive_on_time_have_no_jitter(steps: list[int], began: float) -> None:
    numbers = np.cumsum(steps).tolist()
    arrivals = [began + number / RATE for number in numbers]
    assert jitter(arrivals, numbers, RATE) == pytest.approx(0.0, abs=1e-6)
    assert lost(numbers) == sum(step - 1 for step in steps[1:])


def test_only_the_late_frame_is_off_the_grid() -> None:
    arrivals = [number / RATE for number in range(9)]
    arrivals[0] += 0.005
    assert jitter(arrivals, range(9), RATE) == pytest.approx([5.0] + 8 * [0.0], abs=1e-9)
    assert intervals(arrivals, RATE) == pytest.approx([5.0] + 7 * [0.0], abs=1e-9)


def test_resent_frames_are_not_lost() -> None:
    assert lost([5, 6, 3, 4]) == 0
    assert lost([0, 1, 4, 5, 7]) == 3


def test_messages_of_the_control_are_numbered_by_their_arrival() -> None:
    assert counted([]) == []
    assert np.diff(counted([0.1, 0.1 + 1.1 / RATE, 0.1 + 2.0 / RATE, 0.1 + 4.9 / RATE])).tolist() == [1, 1, 3]


def test_percentiles_are_the_median_and_the_99th() -> None:
    assert percentiles(np.arange(101.0)) == (50.0, 99.0)


def test_messages_outside_the_window_are_left_out() -> None:
    taken = Taken([1.0, 2.0, 3.0, 4.0], [10, 11, 12, 13], [], [], 400, lost=False)
    some = between(taken, 2.0, 4.0)
    assert (some.arrivals, some.numbers, some.bytes) == ([2.0, 3.0], [11, 12], 200)


def test_every_character_is_created_and_acts_in_messages_below_the_size_limit() -> None:
    messages = create(1000, ["walk", "run"], ["wave"])
    assert all(len(one) < 64 * 1024 for one in messages)
    commands = [command for one in messages for command in json.loads(one)]
    for do in ("create", "act"):
        assert [one["id"] for one in commands if one["do"] == do] == list(range(1000))


def test_findings_list_missed_targets() -> None:
    found = Findings("it")
    found.add("few", 1.0, most=1.0)
    found.add("many", 2.0, most=1.0)
    found.add("too few", 0.5, least=1.0)
    found.add("anything", 9.0)
    assert [one.split(" is ")[0] for one in found.missed] == ["it: many", "it: too few"]
    assert len(found.rows) == 4


def test_costs_are_sorted_and_leave_out_the_event_loop() -> None:
    stats: dict[tuple[str, int, str], tuple[Any, ...]] = {
        ("/a/b/c.py", 7, "quick"): (1, 2, 0.5, 9.0, {}),
        ("~", 0, "<method 'run_until_complete' of 'uvloop.loop.Loop' objects>"): (1, 1, 50.0, 60.0, {}),
        ("~", 0, "<built-in method builtins.len>"): (3, 3, 1.5, 1.5, {}),
    }
    found = costs(stats)
    assert [(one.where, one.seconds, one.calls) for one in found] == [
        ("<built-in method builtins.len>", 1.5, 3),
        ("b/c.py:7 quick", 0.5, 2),
    ]
