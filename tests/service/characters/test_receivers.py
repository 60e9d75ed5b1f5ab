"""Characters that are sent to receivers of VMC and JSON Live Link (docs/sending.md)."""

from __future__ import annotations

import json
import re
import socket
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle

from motionsplice.motion.axes import AXES
from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.sending.live_link import ORDER, SIGNS
from motionsplice.sending.vmc import Vmc
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import PATIENCE, Running, eventually, running

PAGE = (Path(__file__).parents[3] / "docs" / "sending.md").read_text()
WALK = {"do": "create", "id": 7, "locomotion": "walk"}
RUN = {"do": "create", "id": 8, "locomotion": "run"}


class Listener:
    """A receiver on loopback."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.socket.settimeout(PATIENCE)

    def empty(self) -> None:
        """Drops what has arrived."""
        self.socket.setblocking(False)
        try:
            while True:
                self.socket.recv(65536)
        except BlockingIOError:
            self.socket.settimeout(PATIENCE)

    def vmc(self) -> dict[str, list[float]]:
        """Returns the numbers of the next whole frame by bone; its time is that of the bone ''."""
        found: dict[str, list[float]] = {}
        while True:
            for one in OscBundle(self.socket.recv(65536)):
                if one.address == "/VMC/Ext/Root/Pos":
                    found = {}
                elif one.address == "/VMC/Ext/Bone/Pos":
                    found[one.params[0]] = list(one.params[1:])
                elif one.address == "/VMC/Ext/T" and found:
                    return {**found, "": list(one.params)}

    def subjects(self, count: int) -> dict[str, Any]:
        """Returns the bones of the next `count` subjects, by subject."""
        found: dict[str, Any] = {}
        while len(found) < count:
            found |= json.loads(self.socket.recv(65536))
        return found


@pytest.fixture(scope="module")
def listeners() -> Iterator[dict[str, Listener]]:
    found = {"vmc": Listener(), "livelink": Listener()}
    yield found
    for one in found.values():
        one.socket.close()


@pytest.fixture(scope="module")
def sending(bank: Bank, listeners: dict[str, Listener]) -> Iterator[Running]:
    settings = Settings(vmc=listeners["vmc"].address, livelink=listeners["livelink"].address)
    with running(bank.path, settings) as service:
        yield service


@pytest.fixture
def vmc(listeners: dict[str, Listener]) -> Listener:
    listeners["vmc"].empty()
    return listeners["vmc"]


@pytest.fixture
def livelink(listeners: dict[str, Listener]) -> Listener:
    listeners["livelink"].empty()
    return listeners["livelink"]


def send(*ids: int, to: list[str]) -> dict[str, Any]:
    return {"do": "send", "id": list(ids), "to": to}


def test_vmc_has_the_frames_of_the_websocket(sending: Running, bank: Bank, vmc: Listener) -> None:
    with Player(sending) as player:
        assert player.welcome["receivers"] == ["vmc", "livelink"]
        player.do(RUN, {**WALK, "position": [2, 0, 1]}, {"do": "act", "id": 7, "action": "wave"}, send(7, to=["vmc"]))
        packs = Vmc(bank.motion(bank.baseline.clip), bank.roles)
        first = player.frame()
        for number in range(20):
            found, frame = vmc.vmc(), player.frame() if number else first
            rows = frame["root_positions"][0, 1], frame["rotations"][0, 1]
            messages = [one for datagram in packs.datagrams(0.0, *rows) for one in OscBundle(bytes(datagram))]
            expected = {one.params[0]: one.params[1:] for one in messages if one.address == "/VMC/Ext/Bone/Pos"}
            for bone, numbers in expected.items():
                np.testing.assert_allclose(found[bone], numbers, atol=1e-6)
            assert found[""] == pytest.approx([(frame["frame"] - first["frame"]) / 60.0], abs=1e-4)


def test_live_link_has_a_subject_for_each_character(sending: Running, bank: Bank, livelink: Listener) -> None:
    with Player(sending, "?axes=unity") as player:
        player.do(WALK, RUN, send(7, 8, to=["livelink"]))
        subjects = livelink.subjects(2)
        assert subjects.keys() == {"motionsplice-7", "motionsplice-8"}
        frame = player.frame()
        signs = np.array([*AXES["unity"].turns, 1.0])  # back to ours
        for row, bones in enumerate(subjects.values()):
            assert [bone["Name"] for bone in bones] == list(bank.skeleton.names)
            turned = [bone["Rotation"] for bone in bones]
            ours = frame["rotations"][0, row] * signs
            np.testing.assert_allclose(turned, ours[:, ORDER] * SIGNS, atol=1e-6)
        player.do(send(7, to=[]))
        livelink.empty()
        assert livelink.subjects(1).keys() == {"motionsplice-8"}
        player.do({"do": "remove", "id": 8}, {"do": "create", "id": 8, "locomotion": "run"})
        player.do(send(7, to=["livelink", "vmc"]))
        livelink.empty()
        assert livelink.subjects(1).keys() == {"motionsplice-7"}


def test_a_receiver_takes_the_characters_of_the_last_connection_that_asked(sending: Running, vmc: Listener) -> None:
    with Player(sending) as first:
        first.do({**WALK, "position": [10, 0, 0]}, send(7, to=["vmc"]))
        with Player(sending) as second:
            second.do({**WALK, "position": [-10, 0, 0]}, send(7, to=["vmc"]))
            ended = first.event("sending_ended")
            assert ended == {
                "event": "sending_ended",
                "to": "vmc",
                "ids": [7],
                "reason": "another connection sends to it",
            }
            vmc.empty()
            assert vmc.vmc()["Hips"][0] > 5.0  # to Unity's left, which is -X
            first.do({"do": "speed", "id": 7, "speed": 0.5})  # does not take it back
            vmc.empty()
            assert vmc.vmc()["Hips"][0] > 5.0
        first.do(send(7, to=["vmc"]))
        vmc.empty()
        assert vmc.vmc()["Hips"][0] < -5.0
        assert not [event for event in first.events if event["event"] == "sending_ended"]


def test_the_program_of_the_page_moves_a_character(sending: Running, vmc: Listener, livelink: Listener) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(program.replace("127.0.0.1:8000", f"127.0.0.1:{sending.port}").replace("range(600)", "range(60)"), {})
    hands = [vmc.vmc()["LeftUpperArm"] for _ in range(20)]
    assert np.ptp(hands, axis=0).max() > 0.1
    assert livelink.subjects(1).keys() == {"motionsplice-1"}


def test_vmc_goes_to_the_last_character_of_a_connection(sending: Running, vmc: Listener) -> None:
    with Player(sending) as player:
        player.do({**WALK, "position": [10, 0, 0]}, {**RUN, "position": [-10, 0, 0]}, send(7, to=["vmc"]))
        player.do(send(8, to=["vmc"]))
        vmc.empty()
        assert vmc.vmc()["Hips"][0] > 5.0


def test_a_client_that_goes_through_many_ids_leaves_nothing_behind(sending: Running, livelink: Listener) -> None:
    with Player(sending) as player:
        for number in range(6):
            made = {"do": "create", "id": number, "locomotion": "walk"}
            player.do(made, *([{"do": "remove", "id": number - 1}] if number else []), send(number, to=["livelink"]))
            livelink.empty()
            assert livelink.subjects(1).keys() == {f"motionsplice-{number}"}
        outputs = sending.config.front.hub._receivers._outputs
        assert outputs["livelink"].packers.keys() == {5}


def test_it_goes_on_with_a_new_bank(sending: Running, bank: Bank, vmc: Listener) -> None:
    with Player(sending) as player:
        player.do(WALK, send(7, to=["vmc"]))
        serving = sending.config.front.shared.serving
        loop = sending.server.servers[0].get_loop()
        loop.call_soon_threadsafe(serving.exchange, Edition.warm(Bank.open(bank.path)))
        player.event("bank")
        vmc.empty()
        assert len(vmc.vmc()) > 15


def test_what_ends_sends_no_more(sending: Running, vmc: Listener) -> None:
    with Player(sending) as player:
        player.do(WALK, send(7, to=["vmc"]))
        vmc.vmc()
    eventually(lambda: not sending.config.front.hub.connections)
    vmc.empty()
    vmc.socket.settimeout(0.1)
    with pytest.raises(TimeoutError):
        vmc.socket.recv(65536)


@pytest.mark.parametrize(
    ("query", "commands", "detail"),
    [
        ("", [WALK, RUN, send(7, 8, to=["vmc"])], "to: vmc takes at most 1, found 2 characters. Send fewer"),
        ("", [WALK, send(7, to=["osc"])], "to: expected a list of vmc, livelink"),
        ("", [WALK, send(8, to=["vmc"])], "id: character 8 not found"),
        ("?ahead=2", [WALK, send(7, to=["vmc"])], "ahead: 2 frames at once cannot be sent to vmc. Set ahead to 1"),
    ],
)
def test_it_refuses_what_cannot_be_sent(sending: Running, query: str, commands: list[Any], detail: str) -> None:
    with Player(sending, query) as player:
        reply = player.do(*commands)
        assert reply["event"] == "refused"
        assert detail in reply["detail"]


def test_a_connection_that_sends_cannot_look_ahead(sending: Running) -> None:
    with Player(sending) as player:
        player.do(WALK, send(7, to=["vmc"]))
        assert "Set ahead to 1" in player.do({"do": "set", "ahead": 4})["detail"]
        player.do(send(7, to=[]))
        assert player.do({"do": "set", "ahead": 4})["event"] == "done"


def test_a_service_without_receivers_says_how_to_name_one(service: Running) -> None:
    with Player(service) as player:
        assert player.welcome["receivers"] == []
        detail = player.do(WALK, send(7, to=["vmc"]))["detail"]
        assert detail == "to: this service has no receiver of vmc. Start it with --vmc HOST:PORT"


def test_a_receiver_that_does_not_run_is_reported_once(bank: Bank) -> None:
    listener = Listener()
    listener.socket.close()
    with running(bank.path, Settings(vmc=listener.address)) as service, Player(service) as player:
        player.do(WALK, send(7, to=["vmc"]))
        event = player.event("undelivered")
        assert event == {"event": "undelivered", "to": "vmc", "reason": "Connection refused"}
        player.frames_until(player.frame()["frame"] + 10)
        assert not [event for event in player.events if event["event"] == "undelivered"]
        metrics = urllib.request.urlopen(f"{service.url}/metrics", timeout=PATIENCE).read().decode()
        (refused,) = re.findall(r'motionsplice_datagrams_total{receiver="vmc",result="refused"} (\S+)', metrics)
        assert float(refused) > 0.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"vmc": "nowhere:0"},
            "MOTIONSPLICE_VMC nowhere:0: the port 0 is not from 1 to 65535. Write HOST or HOST:PORT",
        ),
        ({"livelink": "[::1"}, r"MOTIONSPLICE_LIVELINK \[::1: this is not an address"),
        ({"vmc": "127.0.0.1", "workers": 2}, "MOTIONSPLICE_WORKERS is 2, but only one process can send to a receiver"),
    ],
)
def test_wrong_settings_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        Settings(**values)
