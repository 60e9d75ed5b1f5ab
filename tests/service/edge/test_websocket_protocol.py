from __future__ import annotations

import json
import logging
import socket
from collections.abc import Callable, Iterator
from contextlib import suppress
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import Mock

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.service.edge.websocket_protocol import MOST_FRAMES, PIECE, WebSocketProtocol
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


def test_text_that_is_not_utf8_closes_the_connection_and_is_no_error_of_the_service(
    impatient: Running, caplog: pytest.LogCaptureFixture
) -> None:
    answer = received(handshake(impatient, b"\x81\x81" + bytes(4) + b"\xff"))
    assert answer.endswith(b"\x88\x14\x03\xeftext must be UTF-8")
    eventually(lambda: impatient.held == (0, 0, 0, 0))
    assert not [one for one in caplog.records if one.levelno >= logging.ERROR]


def test_a_handshake_that_is_refused_is_no_error_of_the_service(
    impatient: Running, caplog: pytest.LogCaptureFixture
) -> None:
    twice = HANDSHAKE.replace(b"Connection", b"Host: other\r\nConnection", 1)
    assert received(impatient.connect(twice + text("{}"))).startswith(b"HTTP/1.1 400")
    eventually(lambda: impatient.held == (0, 0, 0, 0))
    assert not [one for one in caplog.records if one.levelno >= logging.ERROR]


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


def ping(data: bytes) -> bytes:
    return bytes((0x89, 0x80 | len(data))) + bytes(4) + data


class Counted:
    """Notes how many frames each turn parses, and the seconds of waiting that are asked for after them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.frames: list[int] = []
        self.waits: list[float] = []
        parse, later = WebSocketProtocol._parse, WebSocketProtocol._parse_later

        def counted(protocol: WebSocketProtocol) -> None:
            parse(protocol)
            self.frames.append(protocol._frames)

        def noted(protocol: WebSocketProtocol, seconds: float = 0.0) -> None:
            self.waits.append(seconds)
            later(protocol, seconds)

        monkeypatch.setattr(WebSocketProtocol, "_parse", counted)
        monkeypatch.setattr(WebSocketProtocol, "_parse_later", noted)


@pytest.fixture(scope="module")
def patient(bank: Bank) -> Iterator[Running]:
    with running(bank.path, Settings(max_commands=10_000)) as service:
        yield service


def read_head(peer: socket.socket) -> None:
    head = b""
    while not head.endswith(b"\r\n\r\n"):
        head += peer.recv(1)


def frames_of(peer: socket.socket, last: Callable[[bytes], bool]) -> list[tuple[int, bytes]]:
    """Returns the kinds and contents of the frames that arrive, up to one for which `last` holds."""
    found: list[tuple[int, bytes]] = []
    data = b""
    while not (found and last(found[-1][1])):
        size, head = (data[1], 2) if len(data) > 1 else (0, 2)
        if size == 126:
            size, head = int.from_bytes(data[2:4], "big"), 4
        if len(data) < max(2, head + size):
            more = peer.recv(65536)
            assert more
            data += more
            continue
        found.append((data[0] & 15, data[head : head + size]))
        data = data[head + size :]
    return found


def test_pings_are_answered_in_small_numbers_a_turn_and_commands_among_them_are_done(
    patient: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted, peer = Counted(monkeypatch), patient.connect(HANDSHAKE)
    read_head(peer)
    pings = [ping(b"%d" % number) for number in range(2000)]
    peer.sendall(b"".join([*pings[:1000], text('{"do": "create", "id": 1, "locomotion": "walk"}'), *pings[1000:]]))
    found = frames_of(peer, lambda content: content == b"1999")
    assert [content for kind, content in found if kind == 10] == [b"%d" % number for number in range(2000)]
    assert any(b'"done"' in content for _, content in found)
    assert max(counted.frames) <= MOST_FRAMES + PIECE // 6
    assert max(counted.waits) > 0.0  # they are charged
    peer.close()


def test_messages_are_parsed_one_at_a_time_and_none_is_lost(patient: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    counted, peer = Counted(monkeypatch), patient.connect(HANDSHAKE)
    read_head(peer)
    long = json.dumps([{"do": "speed", "id": 1, "speed": 1}] * 1000)
    sent = ['{"do": "create", "id": 1, "locomotion": "walk", "ref": 0}']
    sent += [json.dumps({"do": "stop", "id": 1, "ref": number}) for number in range(1, 500)]
    peer.sendall(b"".join(map(text, [*sent, long, '{"do": "remove", "id": 1, "ref": 500}'])))
    found = frames_of(peer, lambda content: b'"ref":500' in content)
    replies = [json.loads(content) for kind, content in found if kind == 1 and b'"done"' in content]
    assert [reply["ref"] for reply in replies] == [*range(500), None, 500]
    assert max(counted.frames) <= 1 + PIECE // 30
    peer.close()


def test_a_client_whose_commands_wait_is_not_cut_off_for_its_pong(bank: Bank) -> None:
    """Its pong is behind commands, which wait for longer than an unanswered ping may."""
    with running(bank.path, Settings(stall_seconds=2.0, max_commands=1000)) as service, Player(service) as player:
        player.do({"do": "create", "id": 1, "locomotion": "walk"})
        stop = json.dumps({"do": "stop", "id": 1})
        for _ in range(8):
            player.socket.send(f"[{','.join([stop] * 1600)}]")
        assert [player.event("done", "refused")["event"] for _ in range(8)] == ["done"] * 8


@pytest.mark.parametrize(("seconds", "is_cut_off"), [(0.0, False), (1.0, True)])
def test_a_client_is_cut_off_for_its_pong_only_if_that_is_behind_its_own_flood(
    seconds: float, is_cut_off: bool
) -> None:
    calls = list[str]()
    one = WebSocketProtocol.__new__(WebSocketProtocol)
    one.transport = cast("Any", SimpleNamespace(pause_reading=lambda: None, abort=lambda: calls.append("abort")))
    one.loop = cast("Any", SimpleNamespace(call_later=lambda *_: calls.append("later")))
    one.config = cast("Any", SimpleNamespace(front=SimpleNamespace(shared=SimpleNamespace(turns=Mock()))))
    one.read_paused = one._will_parse = one._waits_for_allowance = False
    one.ping_timeout = 1.0
    one._parse_later(seconds)
    calls.clear()
    one.keepalive_timeout()
    assert calls == ["abort" if is_cut_off else "later"]
