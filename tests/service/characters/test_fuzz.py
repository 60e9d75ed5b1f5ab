"""Random clients: any message is answered or closes the connection with a defined code, and the service lives."""

from __future__ import annotations

import json
import logging
import urllib.request
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test
from websockets.exceptions import ConnectionClosed

from motionsplice.runtime.bank import Bank
from motionsplice.service.characters.commands import NEEDED
from motionsplice.service.settings import Settings
from tests.service.characters.player import Player
from tests.service.running import Running, eventually, running

FORMATS = ["&axes=unreal&encoding=int16&parts=both", "&axes=blender&deltas=true&format=json"]
CODES = {1002, 1003, 1007, 1009, 4408}

ids = st.integers(0, 5) | st.lists(st.integers(0, 5), max_size=4) | st.integers() | st.none()
clips = st.sampled_from(["walk", "run", "wave", "counting", "counting_hands", "nobody"])
hands = st.sampled_from(["counting_hands", "other_hands", "walk", None, 3])
numbers = st.floats() | st.integers(-2, 10)
options = st.fixed_dictionaries(
    {},
    optional={
        "time": numbers,
        "speed": numbers,
        "start": numbers,
        "loop": st.booleans(),
        "method": st.sampled_from(["splice", "naive", "none", "x"]),
        "posture": st.sampled_from(["relative", "absolute", "running", "off", "x"]),
        "ref": st.integers(-(2**63), 2**63) | st.text(max_size=5) | st.none(),
        "locomotion": clips | st.dictionaries(clips, numbers, max_size=5),
        "action": clips,
        "hands": hands,
        "rate": numbers,
        "ahead": st.integers(-1, 130),
        "weights": st.dictionaries(clips, numbers, max_size=5),
        "weight": numbers,
        "blend": numbers,
        "when": st.sampled_from(["now", "phase", "foot", "x"]),
        "mask": st.sampled_from(["upper_body", "arms", "x"]),
        "own_clock": st.booleans() | st.lists(numbers, max_size=3),
        "position": st.lists(numbers, max_size=4),
        "point": st.none() | st.lists(numbers, max_size=4),
        "direction": st.none() | st.lists(numbers, max_size=4),
        "part": st.sampled_from(["chest", "right_arm", "x"]),
        "in_place": st.booleans(),
        "lock_feet": st.booleans(),
        "to": st.lists(st.sampled_from(["vmc", "livelink", "x"]), max_size=3),
    },
)
commands = st.builds(
    lambda do, id_, rest: {"do": do, "id": id_, **rest},
    st.sampled_from([*NEEDED, "x"]),
    ids,
    options,
)
likely = st.sampled_from(
    [
        {"do": "create", "id": 1, "locomotion": "walk"},
        {"do": "create", "id": [2, 3], "locomotion": "run", "loop": False, "speed": 8},
        {"do": "act", "id": 1, "action": "wave", "posture": "running"},
        {"do": "act", "id": 1, "action": "counting", "method": "naive", "start": 0.5},
        {"do": "play", "id": 1, "locomotion": "counting"},
        {"do": "play", "id": 1, "locomotion": {"walk": 1, "run": 2}, "blend": 0.1},
        {"do": "mix", "id": 1, "weights": {"run": 1}},
        {"do": "act", "id": 1, "action": "wave", "when": "foot", "mask": "left_arm", "loop": False},
        {"do": "set", "events": ["left_down", "right_up", "stride"]},
        {"do": "wear", "id": 1, "hands": "counting_hands"},
        {"do": "wear", "id": [1, 2], "hands": "other_hands", "blend": 0.1, "weight": 0.5},
        {"do": "wear", "id": 1, "hands": None, "blend": 0},
        {"do": "look", "id": [1, 2], "point": [1, 1.5, 3], "blend": 0.1},
        {"do": "look", "id": 1, "direction": None},
        {"do": "aim", "id": 1, "direction": [0, 0, -1], "part": "left_arm"},
        {"do": "aim", "id": [1, 2, 3], "point": [0, 0, 0], "steady": 1, "blend": 0},
        {"do": "stop", "id": 1},
        {"do": "remove", "id": 2},
        {"do": "send", "id": 1, "to": ["vmc", "livelink"]},
        {"do": "send", "id": [2, 3], "to": ["livelink"]},
        {"do": "set", "rate": 120, "ahead": 1},
        {"do": "set", "rate": 120, "ahead": 30},
    ]
)
junk = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


class Clients(RuleBasedStateMachine):
    """One client after the other, each with random messages."""

    service: Running

    def __init__(self) -> None:
        super().__init__()
        self.player: Player | None = None

    @precondition(lambda self: self.player is None)
    @rule(ahead=st.integers(1, 120), how=st.sampled_from(["", *FORMATS]))
    def connect(self, ahead: int, how: str) -> None:
        self.player = Player(self.service, f"?rate=120&ahead={ahead}{how}")

    @precondition(lambda self: self.player is not None)
    @rule(message=likely | commands | st.lists(likely | commands | junk, max_size=5) | junk)
    def command(self, message: Any) -> None:
        assert self.player is not None
        self.player.socket.send(json.dumps(message))
        answer = self.player.event("done", "refused")
        if answer["event"] == "refused":
            assert answer["type"].startswith("urn:motionsplice:")
            assert answer["detail"]

    @precondition(lambda self: self.player is not None)
    @rule(text=st.text(max_size=100))
    def text(self, text: str) -> None:
        assert self.player is not None
        self.player.socket.send(text)
        self.player.event("done", "refused")

    @precondition(lambda self: self.player is not None)
    @rule(sent=st.binary(min_size=1, max_size=40))
    def bytes_that_are_no_websocket(self, sent: bytes) -> None:
        assert self.player is not None
        self.player.socket.socket.sendall(sent)
        self.leave()

    @precondition(lambda self: self.player is not None)
    @rule()
    def binary(self) -> None:
        assert self.player is not None
        self.player.socket.send(b"x")
        with pytest.raises(ConnectionClosed) as caught:
            self.player.frames_until(10**9)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code in CODES
        self.leave()

    @precondition(lambda self: self.player is not None)
    @rule()
    def leave(self) -> None:
        assert self.player is not None
        self.player.socket.socket.close()
        self.player = None

    @invariant()
    def it_lives(self) -> None:
        assert urllib.request.urlopen(f"{self.service.url}/readyz", timeout=30).status == 204

    def teardown(self) -> None:
        if self.player is not None:
            self.leave()


@pytest.fixture(scope="module")
def service(hands_bank: Bank) -> Iterator[Running]:
    """A service with long timeouts, as the test takes time between messages."""
    with running(hands_bank.path, Settings(vmc="127.0.0.1:9", livelink="127.0.0.1:9")) as service:  # nobody listens
        yield service


@pytest.fixture
def failures(caplog: pytest.LogCaptureFixture) -> Iterator[list[str]]:
    """Messages that the service logged as errors."""
    messages: list[str] = []
    yield messages
    for record in caplog.records:
        if record.name.startswith(("motionsplice", "uvicorn", "asyncio")) and record.levelno >= logging.ERROR:
            messages.append(record.getMessage())
    assert not messages


def test_random_clients_do_no_harm(service: Running, failures: list[str]) -> None:
    Clients.service = service
    run_state_machine_as_test(
        Clients,
        settings=settings(
            max_examples=25, stateful_step_count=15, deadline=None, suppress_health_check=list(HealthCheck)
        ),
    )
    eventually(lambda: service.held[2:] == (0, 0))
