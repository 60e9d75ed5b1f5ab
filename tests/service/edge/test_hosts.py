from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.edge.hosts import Hosts
from motionsplice.service.settings import Settings
from tests.service.running import Running, received, running

REBOUND = "evil.example:8000"
ACCEPTED = ("localhost", "LocalHost:8000", "127.0.0.1:80", "[::1]:8000", "[2001:db8::1]", "192.168.0.7", "localhost.")


def status(settings: Settings, *hosts: str) -> int | None:
    refusal = Hosts(settings).refusal([(b"accept", b"*/*"), *((b"host", host.encode()) for host in hosts)])
    return None if refusal is None else int(refusal[0])


@pytest.mark.parametrize("host", ACCEPTED)
def test_loopback_names_and_addresses_are_accepted(host: str) -> None:
    assert status(Settings(), host) is None


@pytest.mark.parametrize(
    "host", [REBOUND, "", "localhost.evil.example", "127.0.0.1.evil.example", "[evil.example]", "x"]
)
def test_other_names_are_refused(host: str) -> None:
    assert status(Settings(), host) == HTTPStatus.MISDIRECTED_REQUEST


def test_names_of_the_settings_are_accepted() -> None:
    assert status(Settings(hosts=("Evil.example",)), REBOUND) is None
    assert status(Settings(hosts=("*",)), REBOUND) is None
    assert status(Settings(host="evil.example"), REBOUND) is None
    assert status(Settings(token=SecretStr("open sesame")), REBOUND) is None


def test_a_missing_or_doubled_host_is_a_bad_request() -> None:
    for settings in (Settings(), Settings(hosts=("*",))):
        assert status(settings) == HTTPStatus.BAD_REQUEST
        assert status(settings, "localhost", "localhost") == HTTPStatus.BAD_REQUEST


def test_a_health_check_of_http_1_0_needs_no_host() -> None:
    assert Hosts(Settings()).refusal([], "1.0") is None
    assert Hosts(Settings()).refusal([(b"host", b"evil.example")], "1.0") is not None


@given(st.lists(st.sampled_from([*ACCEPTED, REBOUND]), max_size=200))
def test_what_came_before_does_not_change_the_answer(asked: list[str]) -> None:
    hosts = Hosts(Settings())
    for host in asked:
        assert (hosts.refusal([(b"host", host.encode())]) is None) == (host in ACCEPTED)


@pytest.fixture(scope="module")
def impatient(bank: Bank) -> Iterator[Running]:
    with running(bank.path, Settings()) as service:
        yield service


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        (b"Host: evil.example\r\n", b"421"),
        (b"", b"400"),
        (b"Host: localhost\r\nHost: evil.example\r\n", b"400"),
        (b"Host: localhost\r\n", b"200"),
    ],
)
def test_the_service_answers_only_to_its_names(impatient: Running, fields: bytes, expected: bytes) -> None:
    for upgrade in (b"", b"Upgrade: websocket\r\nConnection: Upgrade\r\n"):
        if upgrade and expected == b"200":
            continue
        sent = b"GET /v1/pose?locomotion=walk&time=0 HTTP/1.1\r\n" + fields + upgrade + b"Connection: close\r\n\r\n"
        assert received(impatient.connect(sent)).split()[1] == expected


def test_an_old_health_check_is_answered_and_the_connection_closed(impatient: Running) -> None:
    answer = received(impatient.connect(b"GET /healthz HTTP/1.0\r\n\r\n"))
    assert answer.startswith(b"HTTP/1.1 204")


@pytest.mark.parametrize("origin", [b"https://game.example", None])
def test_a_page_can_read_why_the_http_server_refuses_it(impatient: Running, origin: bytes | None) -> None:
    field = b"" if origin is None else b"Origin: " + origin + b"\r\n"
    answer = received(impatient.connect(b"GET /v1/bank HTTP/1.1\r\nHost: evil.example\r\n" + field + b"\r\n"))
    head = answer.partition(b"\r\n\r\n")[0].split(b"\r\n")
    assert head[0].startswith(b"HTTP/1.1 421")
    assert b"vary: origin" in head
    allowed = [line for line in head if line.startswith(b"access-control")]
    assert allowed == ([] if origin is None else [b"access-control-allow-origin: " + origin])
