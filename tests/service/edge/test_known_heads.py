"""Requests for poses that are answered without the parser, because they differ from earlier ones only in their time."""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.edge.known_heads import LONGEST, MOST, AnswerHead, KnownHeaders
from motionsplice.service.front import Front
from motionsplice.service.settings import Settings
from tests.service.running import Running, running

HEADERS = b"Host: 127.0.0.1\r\nAccept: */*\r\n\r\n"
POSES = [f"/v1/pose?locomotion=run&action=wave&time={time}&format=msgpack".encode() for time in (0.1, 0.25, 1.5)]
REQUESTS = {  # and the statuses of their answers
    **{b"GET %s HTTP/1.1\r\n%s" % (pose, HEADERS): 200 for pose in POSES},
    b"GET %s HTTP/1.1\r\nconnection: keep-alive\r\n%s" % (POSES[0], HEADERS): 200,
    b"GET /v1/pose?locomotion=run&action=wave&time=0.1 HTTP/1.1\r\n" + HEADERS: 200,
    b"GET /v1/pose?locomotion=run&action=wave&time=99&format=msgpack HTTP/1.1\r\n" + HEADERS: 422,
    b"GET /v1/pose?locomotion=run&action=wave&time=soon&format=msgpack HTTP/1.1\r\n" + HEADERS: 422,
    b"GET /healthz HTTP/1.1\r\n" + HEADERS: 204,
    b"POST /v1/pose?locomotion=run&time=1 HTTP/1.1\r\nContent-Length: 3\r\n" + HEADERS + b"GET": 405,
}


@pytest.fixture(scope="module")
def impatient(bank: Bank) -> Iterator[Running]:
    with running(bank.path, Settings(idle_seconds=0.3)) as service:
        yield service


def answers(peer: socket.socket, count: int) -> list[tuple[int, bytes]]:
    """Returns the statuses and bodies of the next answers on a connection."""
    found: list[tuple[int, bytes]] = []
    data = b""
    while len(found) < count:
        head, end, rest = data.partition(b"\r\n\r\n")
        length = re.search(rb"content-length: (\d+)", head)
        size = int(length[1]) if length else 0
        if not end or len(rest) < size:
            more = peer.recv(65536)
            assert more, data
            data += more
            continue
        found.append((int(head.split()[1]), rest[:size]))
        data = rest[size:]
    assert not data
    return found


def counted(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Returns a list that grows by each query that is answered without the parser."""
    queries: list[bytes] = []
    answer_known = Front.answer_known

    def counting(front: Front, query: bytes) -> object:
        if (found := answer_known(front, query)) is not None:
            queries.append(query)
        return found

    monkeypatch.setattr(Front, "answer_known", counting)
    return queries


def test_from_the_second_on_a_pose_is_answered_without_the_parser_by_the_same_bytes(
    impatient: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    queries, peer = counted(monkeypatch), impatient.connect()
    found = []
    for pose in (*POSES, *POSES):
        peer.sendall(b"GET %s HTTP/1.1\r\nHost: 127.0.0.2\r\n\r\n" % pose)
        found += answers(peer, 1)
    assert found[:3] == found[3:]
    assert len(set(found)) == 3
    assert len(queries) >= 5
    fresh = impatient.connect(b"GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" % POSES[1])
    assert answers(fresh, 1) == found[1:2]
    peer.close()


@given(st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_answers_do_not_depend_on_how_requests_are_cut_into_pieces(impatient: Running, data: st.DataObject) -> None:
    requests = data.draw(st.lists(st.sampled_from(list(REQUESTS)), min_size=2, max_size=8), label="requests")
    sent = b"".join(requests)
    ends = {len(b"".join(requests[: number + 1])) for number in range(len(requests))}
    cuts = data.draw(st.sets(st.one_of(st.sampled_from(sorted(ends)), st.integers(1, len(sent)))), label="cuts")
    peer, begin = impatient.connect(), 0
    for cut in sorted(cuts | {len(sent)}):
        peer.sendall(sent[begin:cut])
        begin = cut
        time.sleep(0.001)
    found = answers(peer, len(requests))
    assert [status for status, _ in found] == [REQUESTS[one] for one in requests]
    bodies: dict[bytes, bytes] = {}
    for request, (status, body) in zip(requests, found, strict=True):
        assert status != 200 or bodies.setdefault(request, body) == body
    peer.close()


@pytest.mark.parametrize(
    "request_line",
    [
        b"GET %s  HTTP/1.1" % POSES[0],
        b"GET  %s HTTP/1.1" % POSES[0],
        b"GET %s \tHTTP/1.1" % POSES[0],
        b"GET %s HTTP/1.1" % POSES[0].replace(b"0.1", b" 0.1"),
        b"get %s HTTP/1.1" % POSES[0],
    ],
)
def test_a_line_that_the_parser_refuses_is_refused(impatient: Running, request_line: bytes) -> None:
    peer = impatient.connect(b"GET %s HTTP/1.1\r\n%s" % (POSES[0], HEADERS))
    expected = answers(peer, 1)
    fresh = impatient.connect(request_line + b"\r\n" + HEADERS)
    peer.sendall(request_line + b"\r\n" + HEADERS)
    alone, after = answers(fresh, 1)[0], answers(peer, 1)[0]
    assert alone[0] == after[0]
    assert alone[0] == 400 or [after] == expected
    for one in (peer, fresh):
        one.close()


def test_the_rest_of_another_request_is_not_answered_as_one(impatient: Running) -> None:
    known = b"GET %s HTTP/1.1\r\n%s" % (POSES[0], HEADERS)
    peer = impatient.connect(known)
    answers(peer, 1)
    peer.sendall(known + b"GET /healthz HTTP/1.1\r\nX: ")
    assert answers(peer, 1)[0][0] == 200
    peer.sendall(known)
    assert answers(peer, 1)[0][0] == 204
    peer.close()


def test_a_connection_that_is_used_stays_and_an_unused_one_is_closed(impatient: Running) -> None:
    peer, request = impatient.connect(), b"GET %s HTTP/1.1\r\n%s" % (POSES[0], HEADERS)
    for _ in range(6):
        peer.sendall(request)
        assert answers(peer, 1)[0][0] == 200
        time.sleep(0.1)
    peer.settimeout(2.0)
    assert peer.recv(100) == b""


def test_other_headers_need_the_token_again(bank: Bank) -> None:
    with running(bank.path, Settings(token=SecretStr("secret-token"))) as service:
        peer = service.connect()
        for header, status in ((b"secret-token", 200), (b"secret-token", 200), (b"secret-tokem", 401)):
            peer.sendall(b"GET %s HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer %s\r\n\r\n" % (POSES[0], header))
            assert answers(peer, 1)[0][0] == status
        peer.sendall(b"GET %s HTTP/1.1\r\n%s" % (POSES[0], HEADERS))
        assert answers(peer, 1)[0][0] == 401


def test_they_are_counted(impatient: Running) -> None:
    metrics = impatient.config.front.shared.metrics
    peer, counter = impatient.connect(), 'motionsplice_requests_total{route="/v1/pose",status="200"} '

    def count() -> float:
        lines = metrics.render()[0].decode().splitlines()
        return float(next(line for line in lines if line.startswith(counter)).removeprefix(counter))

    request = b"GET %s HTTP/1.1\r\n%s" % (POSES[0], HEADERS)
    peer.sendall(request)
    answers(peer, 1)
    before, total = count(), impatient.server.server_state.total_requests
    for _ in range(5):
        peer.sendall(request)
        answers(peer, 1)
    assert count() == before + 5
    assert impatient.server.server_state.total_requests == total + 5
    peer.close()


def test_few_headers_are_kept_and_no_large_ones() -> None:
    known = KnownHeaders()
    for number in range(MOST + 1):
        known.learn(b"GET /a HTTP/1.1\r\nX: %d\r\n\r\n" % number, b"/a")
    assert known.target(b"GET /b HTTP/1.1\r\nX: %d\r\n\r\n" % MOST) == b"/b"
    assert known.target(b"GET /b HTTP/1.1\r\nX: 0\r\n\r\n") == b""
    large = b"GET /a HTTP/1.1\r\nX: %s\r\n\r\n" % (LONGEST * b"x")
    known.learn(large, b"/a")
    assert known.target(large) == b""
    known.learn(b"\r\nGET /a HTTP/1.1\r\nY: 0\r\n\r\n", b"/a")
    assert known.target(b"GET /a HTTP/1.1\r\nY: 0\r\n\r\n") == b""


def test_the_servers_own_headers_are_renewed() -> None:
    head, first, second = AnswerHead(), [(b"date", b"now")], [(b"date", b"later")]
    assert b"date: now\r\ncontent-type: a/b\r\nvary: origin\r\nx-request-id: " in head.of(first, b"a/b")
    assert b"content-type: c/d" in head.of(first, b"c/d")
    assert b"date: later" in head.of(second, b"a/b")
