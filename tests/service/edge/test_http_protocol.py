from __future__ import annotations

import json
import re
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import suppress

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, eventually, received, running

GET = b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
STREAM = b"GET /v1/stream?locomotion=walk&rate=1000&ahead=100 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"


@pytest.fixture(scope="module")
def impatient(bank: Bank) -> Iterator[Running]:
    """A service with short timeouts."""
    settings = Settings(
        request_seconds=0.3, idle_seconds=0.3, stall_seconds=0.3, max_header=2048, max_connections_per_address=8
    )
    with running(bank.path, settings) as service:
        yield service


def problem(answer: bytes) -> tuple[int, str]:
    head, _, body = answer.partition(b"\r\n\r\n")
    document = json.loads(body)
    assert b"application/problem+json" in head
    assert document["status"] == int(head.split()[1])
    return document["status"], document["type"].removeprefix("urn:motionsplice:")


@pytest.mark.parametrize("sent", [b"", b"GET /healthz HT", b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n"])
def test_a_request_that_does_not_arrive_times_out(impatient: Running, sent: bytes) -> None:
    assert problem(received(impatient.connect(sent))) == (408, "timeout")


def test_the_second_request_on_a_connection_times_out_too(impatient: Running) -> None:
    peer = impatient.connect(GET)
    assert peer.recv(1000).startswith(b"HTTP/1.1 204")
    peer.sendall(b"GET /heal")
    assert problem(received(peer)) == (408, "timeout")


def test_a_body_that_does_not_arrive_times_out(impatient: Running) -> None:
    head = (
        b"POST /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{"
    )
    assert problem(received(impatient.connect(head))) == (408, "timeout")


def test_an_unused_connection_is_closed(impatient: Running) -> None:
    assert received(impatient.connect(GET)).startswith(b"HTTP/1.1 204")


@pytest.mark.parametrize(
    "sent",
    [
        b"GET /healthz HTTP/1.1\r\nX: " + 3000 * b"a" + b"\r\n\r\n",
        b"GET /healthz HTTP/1.1\r\nX: " + 3000 * b"a",
        b"GET /" + 3000 * b"a",
        b"GET /healthz HTTP/1.1\r\n" + 800 * b"A: b\r\n",
    ],
)
def test_large_heads_are_refused(impatient: Running, sent: bytes) -> None:
    assert problem(received(impatient.connect(sent))) == (431, "too-large")


@pytest.mark.parametrize("sent", [b"\x16\x03\x01\x02\x00\x01", b"HELLO\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n"])
def test_data_that_is_not_http_is_a_problem(impatient: Running, sent: bytes) -> None:
    assert problem(received(impatient.connect(sent))) == (400, "http")


@pytest.mark.parametrize("length", [b"Content-Length: 9", b"Transfer-Encoding: chunked"])
def test_a_body_that_another_protocol_would_swallow_is_refused(impatient: Running, length: bytes) -> None:
    """Java's HttpClient asks for h2c unless it is told to speak HTTP/1.1."""
    head = b"POST /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: h2c\r\n" + length
    answer = received(impatient.connect(head + b"\r\n\r\n"))
    assert problem(answer) == (400, "http")
    assert b"without the header Upgrade" in answer


def test_a_request_without_a_body_may_ask_for_another_protocol(impatient: Running) -> None:
    upgrade = GET[:-2] + b"Connection: Upgrade\r\nUpgrade: h2c\r\n\r\n"
    assert received(impatient.connect(upgrade)).startswith(b"HTTP/1.1 204")


def test_connections_of_one_address_are_limited(impatient: Running) -> None:
    peers = [impatient.connect(b"GET") for _ in range(8)]
    eventually(lambda: len(impatient.config.ledger) == 8)
    assert problem(received(impatient.connect())) == (429, "busy")
    metrics = impatient.config.front.shared.metrics.render()[0].decode()
    assert 'motionsplice_requests_total{route="connection",status="429"} 1.0' in metrics
    for peer in peers:
        peer.close()
    eventually(lambda: len(impatient.config.ledger) == 0)
    assert received(impatient.connect(GET)).startswith(b"HTTP/1.1 204")


def test_a_client_that_stops_reading_is_cut_off(impatient: Running) -> None:
    peer = impatient.connect(STREAM, receive_buffer=4096)
    eventually(lambda: len(impatient.config.front.shared.streams) == 1)
    eventually(lambda: impatient.held == (0, 0, 0, 0))
    peer.close()


def test_a_client_that_reads_slowly_gets_all_of_a_large_answer(bank: Bank) -> None:
    sent = (
        b"GET /v1/splice?locomotion=walk&rate=1000&parts=both HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
    )
    with running(bank.path, Settings(stall_seconds=1.0)) as service:
        peer, got, began = service.connect(sent, receive_buffer=65536), bytearray(), time.monotonic()
        while more := peer.recv(65536):
            got += more
            time.sleep(max(0.0, began + len(got) / 4e6 - time.monotonic()))  # 4 MB/s: longer than `stall_seconds`
    head, _, body = bytes(got).partition(b"\r\n\r\n")
    length = re.search(rb"content-length: (\d+)", head)
    assert length is not None
    assert len(body) == int(length[1]) > 8_000_000


def test_endless_trailers_are_refused(impatient: Running) -> None:
    head = b"POST /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\nX: "
    peer = impatient.connect(head)
    with suppress(OSError):
        for _ in range(200):
            peer.sendall(bytes(1000).replace(b"\0", b"y"))
            time.sleep(0.001)
        pytest.fail("200 kB of a trailer were taken")
    peer.close()


def test_pipelined_requests_are_limited(impatient: Running) -> None:
    endless = b"GET /v1/stream?locomotion=walk&rate=1&pace=realtime HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    assert b"204" not in received(impatient.connect(endless + 100 * GET))


def test_no_websocket_begins_in_the_middle_of_an_answer(impatient: Running) -> None:
    endless = b"GET /v1/stream?locomotion=walk&rate=1&pace=realtime HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    upgrade = b"GET /v1/characters HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n"
    assert b"WebSocket" not in received(impatient.connect(endless + upgrade))


def test_a_client_that_disconnects_at_any_stage_leaves_nothing(impatient: Running) -> None:
    for number in range(200):
        sent = (b"", b"GET /v1", GET, STREAM, b"POST /v1/poses HTTP/1.1\r\nContent-Length: 9\r\n\r\n{")[number % 5]
        impatient.connect(sent).close()
        if number % 5 == 4:
            eventually(lambda: len(impatient.config.ledger) < 4)


def test_a_client_that_disconnects_between_frames_is_noticed_at_once(impatient: Running) -> None:
    peer = impatient.connect(
        b"GET /v1/stream?locomotion=walk&rate=0.3&pace=realtime HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    )
    assert peer.recv(12) == b"HTTP/1.1 200"
    eventually(lambda: len(impatient.config.front.shared.streams) == 1)
    peer.close()
    eventually(lambda: impatient.held == (0, 0, 0, 0))


def test_errors_of_the_application_reach_the_client(impatient: Running) -> None:
    with pytest.raises(urllib.error.HTTPError) as caught:
        urllib.request.urlopen(f"{impatient.url}/v1/pose?locomotion=wlak&time=0")
    assert caught.value.code == 404
    assert "Did you mean 'walk'" in json.load(caught.value)["detail"]
