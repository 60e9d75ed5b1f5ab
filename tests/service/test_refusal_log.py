from __future__ import annotations

import logging
import re
from contextlib import suppress
from typing import Any

import pytest
from fastapi.testclient import TestClient
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from motionsplice.service import refusal_log
from motionsplice.service.refusal_log import MOST, MOST_OF_ALL, PERIOD, RefusalLog
from tests.service.running import PATIENCE, Running, received


class Now:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.seconds = 100.0

    def __call__(self) -> float:
        return self.seconds


@pytest.fixture(autouse=True)
def _all_lines(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)


def lines(caplog: pytest.LogCaptureFixture) -> list[Any]:
    return [record for record in caplog.records if record.message == "refused"]


@pytest.mark.parametrize(
    ("method", "path", "headers", "status", "words"),
    [
        ("GET", "/v1/nothing", {}, 404, "no such path '/v1/nothing'. GET /openapi.json lists all requests"),
        ("GET", "/v1/clips/wlak", {}, 404, "Did you mean 'walk'"),
        ("GET", "/v1/skeleton?axes=maya", {}, 422, "axes: "),
        ("GET", "/v1/skeleton?axis=unity", {}, 422, "Did you mean 'axes'"),
        ("GET", "/v1/tables/lowe", {}, 404, "Did you mean 'lower'"),
        ("GET", "/v1/tables/lower", {"range": "bytes=999999999-"}, 416, "the range is outside the file"),
        ("POST", "/v1/clips?name=jump.bvh", {}, 403, "Start it with --token"),
        ("POST", "/v1/clips", {}, 422, "name: "),
        ("POST", "/v1/bank", {}, 405, "/v1/bank does not have the method POST. Use GET"),
        ("GET", "/v1/pose?locomotion=wlak&time=0", {}, 404, "Did you mean 'walk'"),
    ],
)
def test_each_refusal_is_a_line_under_its_request_id(
    client: TestClient,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    path: str,
    headers: dict[str, str],
    status: int,
    words: str,
) -> None:
    monkeypatch.setattr(refusal_log, "MOST", MOST_OF_ALL)  # other tests share the client, and may have had its lines
    answer = client.request(method, path, headers=headers)
    (line,) = lines(caplog)
    assert answer.status_code == line.status == status
    assert words in line.detail
    assert (line.request_id, line.path) == (answer.json()["request_id"], path.partition("?")[0])


def test_refusals_of_the_http_server_are_lines_too(service: Running, caplog: pytest.LogCaptureFixture) -> None:
    for sent, status in (
        (b"GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n", 421),
        (b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: " + 20_000 * b"a" + b"\r\n\r\n", 431),
        (b"HELLO\r\n\r\n", 400),
    ):
        caplog.clear()
        answer = received(service.connect(sent))
        (line,) = lines(caplog)
        assert (line.status, line.address) == (status, "127.0.0.1")
        assert not [record for record in caplog.records if record.name.startswith("uvicorn")]  # which knows no limit
        assert answer.startswith(f"HTTP/1.1 {status} ".encode())
        assert f'"request_id":"{line.request_id}"'.encode() in answer


def test_a_flood_of_an_address_takes_no_lines_of_others(caplog: pytest.LogCaptureFixture) -> None:
    now = Now()
    log = RefusalLog(now)
    for _ in range(5000):
        log.note("1", "10.0.0.1", 429, "too many")
    assert len(lines(caplog)) == MOST
    log.note("2", "10.0.0.2", 404, "Not Found", "/v1/nothing")
    assert len(lines(caplog)) == MOST + 1
    assert lines(caplog)[-1].unlogged == 5000 - MOST
    now.seconds += PERIOD
    log.note("3", "10.0.0.1", 429, "too many")
    assert lines(caplog)[-1].request_id == "3"
    assert not hasattr(lines(caplog)[-1], "unlogged")


def test_a_flood_of_many_addresses_is_bounded(caplog: pytest.LogCaptureFixture) -> None:
    log = RefusalLog(Now())
    for number in range(5000):
        log.note("1", f"2001:db8::{number:x}", 429, "too many")
    assert len(lines(caplog)) == MOST_OF_ALL


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (b"GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n", 421),
        (b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: " + 20_000 * b"a" + b"\r\n\r\n", 431),
        (b"HELLO\r\n\r\n", 400),
    ],
)
def test_refusals_of_the_http_server_are_counted(service: Running, sent: bytes, status: int) -> None:
    before = counted(service, "connection", status)
    received(service.connect(sent))
    assert counted(service, "connection", status) == before + 1


@pytest.mark.parametrize(
    ("path", "route", "status"),
    [("/v1/characters?rate=0", "/v1/characters", 422), ("/v1/nothing", "other", 404), ("/v1/other", "other", 404)],
)
def test_refused_websockets_are_counted(service: Running, path: str, route: str, status: int) -> None:
    before = counted(service, route, status)
    with connect(f"ws://127.0.0.1:{service.port}{path}") as socket, suppress(ConnectionClosed):
        while True:
            socket.recv(timeout=PATIENCE)
    assert counted(service, route, status) == before + 1


def counted(service: Running, route: str, status: int) -> float:
    text = service.config.front.shared.metrics.render()[0].decode()
    found = re.search(rf'motionsplice_requests_total{{route="{route}",status="{status}"}} ([0-9.]+)', text)
    return float(found[1]) if found else 0.0
