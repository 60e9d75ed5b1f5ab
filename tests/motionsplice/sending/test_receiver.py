from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import closing

import pytest
from pythonosc.osc_bundle import OscBundle

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.sending.performance import perform
from motionsplice.sending.receiver import Receiver
from motionsplice.sending.schedule import Schedule
from motionsplice.sending.vmc import Vmc


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        one.settimeout(5.0)
        yield one


def address(listener: socket.socket, host: str = "127.0.0.1") -> str:
    return f"{host}:{listener.getsockname()[1]}"


def test_a_second_of_frames_arrives_in_order(bank: Bank, listener: socket.socket) -> None:
    vmc, schedule, found = Vmc(bank.motion("walk"), bank.roles), Schedule(60.0, 1.0), []
    with closing(Receiver(address(listener), 1, "--vmc")) as receiver:
        for frame in perform(bank, "walk", "wave", schedule):
            datagrams = vmc.datagrams(*frame)
            receiver.send(datagrams)
            found += [one for _ in datagrams for one in OscBundle(listener.recv(65536))]
    assert receiver.unsent == 0
    times = [one.params[0] for one in found if one.address == "/VMC/Ext/T"]
    assert times == sorted(times)
    assert (times[0], times[-1]) == (0.0, 1.0)
    assert len(times) == schedule.made == 61 - schedule.left_out
    assert sum(one.address == "/VMC/Ext/Bone/Pos" for one in found) == len(times) * len(vmc.bones)


def test_ipv4_comes_before_ipv6(listener: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    port = listener.getsockname()[1]
    six = (socket.AF_INET6, socket.SOCK_DGRAM, 17, "", ("::1", port, 0, 0))
    four = (socket.AF_INET, socket.SOCK_DGRAM, 17, "", ("127.0.0.1", port))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [six, four])
    with closing(Receiver(address(listener, "localhost"), 1, "--vmc")) as receiver:
        receiver.send([b"frame"])
    assert listener.recv(10) == b"frame"


def test_a_closed_port_is_counted_and_the_next_frames_arrive(listener: socket.socket) -> None:
    name, port = address(listener), listener.getsockname()[1]
    listener.close()
    with closing(Receiver(name, 1, "--vmc")) as receiver:
        receiver.send([b"lost"] * 4)
        assert receiver.unsent > 0
        assert receiver.reason == "Connection refused"
        assert receiver.sent + receiver.unsent == 4
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as later:
            later.bind(("127.0.0.1", port))
            later.settimeout(5.0)
            receiver.send([b"first", b"second"])  # the first may report the port as it was
            assert later.recv(10) in (b"first", b"second")


def test_a_datagram_that_is_too_large_is_counted(listener: socket.socket) -> None:
    with closing(Receiver(address(listener), 1, "--livelink")) as receiver:
        receiver.send([bytes(70_000), b"next"])
        assert (receiver.sent, receiver.unsent, receiver.reason) == (1, 1, "Message too long")


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("127.0.0.1", "127.0.0.1:39539"),
        ("127.0.0.1:5000", "127.0.0.1:5000"),
        ("[::1]", "[::1]:39539"),
        ("[::1]:5000", "[::1]:5000"),
        ("localhost:65535", "localhost:65535"),
    ],
)
def test_an_address_may_leave_out_the_port(text: str, name: str) -> None:
    with closing(Receiver(text, 39539, "--vmc")) as receiver:
        assert receiver.name == name


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "this is not an address"),
        (":39539", "this is not an address"),
        ("::1", "this is not an address"),
        ("[::1", "this is not an address"),
        ("127.0.0.1:http", "this is not an address"),
        ("127.0.0.1:-1", "this is not an address"),
        ("127.0.0.1:٣", "this is not an address"),
        ("127.0.0.1:0", "the port 0 is not from 1 to 65535"),
        ("127.0.0.1:65536", "the port 65536 is not"),
        ("nowhere.invalid", "unknown host 'nowhere.invalid'"),
        ("x" * 70, "unknown host"),
        ("255.255.255.255", "cannot send there"),
    ],
)
def test_other_addresses_are_refused(text: str, problem: str) -> None:
    with pytest.raises(SettingsError, match=problem) as error:
        Receiver(text, 39539, "--vmc")
    assert str(error.value).startswith(f"--vmc {text}: ")
