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
