from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import suppress

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import Running, eventually, received, running

HANDSHAKE = (
    b"GET /v1/characters HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@pytest.fixture(scope="module")
def impatient(bank: Bank) -> Iterator[Running]:
    settings = Settings(stall_seconds=0.4, request_seconds=5.0, max_connections_per_address=4)
    with running(bank.path, settings) as service:
        yield service


def text(message: str) -> bytes:
    """A text frame, masked with zeros."""
    data = message.encode()
    size = bytes([0x80 | len(data)]) if len(data) < 126 else b"\xfe" + len(data).to_bytes(2, "big")
    return b"\x81" + size + bytes(4) + data


def handshake(service: Running, *sent: bytes, receive_buffer: int | None = None) -> socket.socket:
    peer = service.connect(HANDSHAKE, receive_buffer=receive_buffer)
    assert peer.recv(12) == b"HTTP/1.1 101"
    for one in sent:
        peer.sendall(one)
    return peer


@pytest.mark.parametrize("characters", [1, 2000])
def test_a_client_that_reads_nothing_is_cut_off_even_if_little_is_sent(impatient: Running, characters: int) -> None:
    create = text(f'{{"do": "create", "id": {list(range(characters))}, "locomotion": "walk"}}')
    peer = handshake(impatient, create, receive_buffer=4096)
    eventually(lambda: len(impatient.config.front.hub.connections) == 1)
    eventually(lambda: impatient.held == (0, 0, 0, 0))
    peer.close()


def test_a_client_that_reads_is_not_cut_off(impatient: Running) -> None:
    with Player(impatient) as player:
        first = player.do({"do": "create", "id": 1, "locomotion": "walk"})["frame"]
        assert player.frames_until(first + 90)[-1]["frame"] >= first + 90


def test_pongs_do_not_pile_up_for_a_client_that_reads_nothing(impatient: Running) -> None:
    peer = handshake(impatient, receive_buffer=4096)
    peer.settimeout(0.5)
    ping = b"\x89\xfd" + bytes(4) + bytes(125)
    sent = 0
    with suppress(OSError):  # it is cut off, or its pings are no longer read
        while sent < 1_000_000_000:
            peer.sendall(1000 * ping)
            sent += 1000 * len(ping)
    assert sent < 1_000_000_000
    eventually(lambda: impatient.held == (0, 0, 0, 0))
    peer.close()


@pytest.mark.parametrize("fields", [200 * b"X: y\r\n", b"X: " + 9000 * b"y" + b"\r\n"])
def test_a_handshake_that_is_too_large_is_refused(impatient: Running, fields: bytes) -> None:
    answer = received(impatient.connect(HANDSHAKE.replace(b"Host: 127.0.0.1\r\n", b"Host: 127.0.0.1\r\n" + fields)))
    assert answer.startswith(b"HTTP/1.1 431 ")
    assert b"urn:motionsplice:too-large" in answer


def test_a_websocket_counts_as_one_connection(impatient: Running) -> None:
    players = [Player(impatient) for _ in range(4)]
    assert len(impatient.config.ledger) == 4
    assert impatient.connect().recv(12) == b"HTTP/1.1 429"
    for player in players:
        player.__exit__(None, None, None)
    eventually(lambda: len(impatient.config.ledger) == 0)


def test_a_client_that_disconnects_at_any_stage_leaves_nothing(impatient: Running) -> None:
    create = text('{"do": "create", "id": 1, "locomotion": "walk"}')
    for number in range(100):
        handshake(impatient, *((), (create,), (create, create[:20]), (b"\x81\xfe",))[number % 4]).close()
        eventually(lambda: len(impatient.config.ledger) < 4)


def test_a_service_stops_in_spite_of_clients_that_read_nothing(bank: Bank) -> None:
    with running(bank.path, Settings(stop_seconds=0.5, stall_seconds=30.0)) as service:
        create = text(f'{{"do": "create", "id": {list(range(3000))}, "locomotion": "walk"}}')
        peers = [handshake(service, create, receive_buffer=4096) for _ in range(3)]
        eventually(lambda: sum(len(one.play.scene) for one in service.config.front.hub.connections) == 9000)
    for peer in peers:
        peer.close()
