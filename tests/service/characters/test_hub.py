"""Ticks of the hub at moments that these tests choose, without sockets."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import Any, cast

import msgpack
import numpy as np
import pytest

from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.service.characters import lateness
from motionsplice.service.characters.commands import checked, parse
from motionsplice.service.characters.connection import Connection, State
from motionsplice.service.characters.ensemble import Ensemble
from motionsplice.service.characters.frame_format import frame_format
from motionsplice.service.characters.hub import CHARACTERS, TURNS, Hub, _serve_others
from motionsplice.service.characters.play import Play
from motionsplice.service.characters.scene import Scene
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition, Serving
from motionsplice.service.settings import Settings
from motionsplice.service.shared import Shared
from motionsplice.service.turns import Turns

TICK = 1.0 / 60.0


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


class Wire:
    """A client whose send buffer is free, or not."""

    def __init__(self) -> None:
        self.is_free = True
        self.sent: list[bytes] = []
        self.events: list[dict[str, Any]] = []

    def send_at_once(self, message: bytes, *, text: bool) -> bool:
        self.sent.append(message)
        return True

    async def nothing_waits(self) -> None:
        raise AssertionError("no test waits")

    @property
    def numbers(self) -> list[int]:
        return [msgpack.unpackb(message)["frame"] for message in self.sent]


class Room:
    """A hub with connections, whose clock begins at 0."""

    def __init__(self, edition: Edition) -> None:
        serving = Serving(edition.bank)
        serving.exchange(edition)
        shared = SimpleNamespace(settings=Settings(), metrics=Metrics(), serving=serving, turns=Turns())
        self.hub, self.shared = Hub(cast("Shared", shared)), shared
        self.edition = edition
        self.wires: dict[Connection, Wire] = {}

    def connect(self, *commands: dict[str, Any], query: str = "rate=60") -> Connection:
        values = CHARACTERS.read(query.encode())
        scene = Scene(self.edition, values["rate"], 10_000)
        for command in checked(parse(json.dumps(commands or [{"do": "create", "id": 1, "locomotion": "walk"}])),
                               AXES["gltf"]):  # fmt: skip
            scene.do(command)
        wire, play = Wire(), Play(scene, 0, 0.0, values["rate"], values["ahead"])
        one = Connection(play, frame_format(values), self.shared.metrics, wire)
        self.wires[one] = wire
        self.hub.connections.add(one)
        return one

    def tick(self, *moments: float) -> None:
        """Lets the clock make frames at these moments."""

        async def run() -> None:
            for moment in moments:
                self.hub._tick(moment)
                for one in self.wires:
                    self.send(one)

        asyncio.run(run())

    def send(self, one: Connection) -> None:
        """Sends what waits, as `Connection.send` does."""
        wire = self.wires[one]
        wire.events += map(json.loads, one._events)
        one._events.clear()
        one._wake.clear()
        if one._message is not None:
            wire.sent.append(one._message[1])
            one._message, one.state = None, State.READY

    def numbers(self, one: Connection) -> list[int]:
        return self.wires[one].numbers


def test_all_clients_get_the_same_frames_when_there_is_too_much_work(edition: Edition) -> None:
    room = Room(edition)
    many = [room.connect() for _ in range(20)]
    crowd = room.connect({"do": "create", "id": list(range(100)), "locomotion": "run"})
    paired = room.connect(query="rate=60&ahead=2")
    room.tick(*(0.001 + 2.5 * TICK * tick for tick in range(40)))
    made = room.numbers(many[0])
    assert len(made) == 40
    assert np.diff(made[10:]).tolist() == [3 - number % 2 for number in range(made[10] % 2, 29 + made[10] % 2)]
    assert all(room.numbers(one) == made for one in [*many, crowd])
    assert len(room.numbers(paired)) == pytest.approx(40, abs=4)
    assert room.shared.metrics.frames_skipped._value.get() > 0


def test_clients_of_each_rate_get_the_frame_that_is_newest(edition: Edition) -> None:
    room = Room(edition)
    fast, slow = room.connect(), room.connect(query="rate=10")
    room.tick(*(0.05 + 2.5 * TICK * tick for tick in range(60)))
    end = 0.05 + 2.5 * TICK * 59
    assert room.numbers(fast)[-1] == int(end * 60)
    assert room.numbers(slow) == list(range(int(end * 10) + 1))


def test_a_client_that_reads_slowly_does_not_make_others_miss_frames(edition: Edition) -> None:
    room = Room(edition)
    one, slow = room.connect(), room.connect()
    room.wires[slow].is_free = False
    room.tick(*(tick * TICK for tick in range(60)))
    assert slow.state is State.DEFERRED
    slow.state, slow.wanted, room.wires[slow].is_free = State.READY, 60 * TICK, True
    room.tick(*[60 * TICK + 0.04] * 20, *(tick * TICK + 0.04 for tick in range(61, 70)))
    assert room.numbers(one) == list(range(72))
    assert room.numbers(slow) == list(range(62, 72))
    assert not room.hub._lateness.sheds


def test_frames_that_are_left_out_have_moved_characters_as_if_they_had_been_sent(edition: Edition) -> None:
    create = {"do": "create", "id": [3, 4], "locomotion": "walk"}
    act = {"do": "act", "id": 4, "action": "wave"}
    late, punctual = Room(edition), Room(edition)
    one, other = late.connect(create, act), punctual.connect(create, act)
    for _ in range(3):
        late.connect()
    late.tick(0.0, 50.5 * TICK)
    punctual.tick(*(tick * TICK for tick in range(51)))
    last, expected = (msgpack.unpackb(room.wires[it].sent[-1]) for room, it in ((late, one), (punctual, other)))
    assert last["frame"] == expected["frame"] == 50
    for name in ("root_positions", "rotations"):
        assert last[name] == expected[name]


def test_events_of_frames_that_are_left_out_are_sent(edition: Edition) -> None:
    create = {"do": "create", "id": [3, 4], "locomotion": "walk"}
    act = {"do": "act", "id": 4, "action": "wave", "when": "left_foot", "loop": False}
    late, punctual = Room(edition), Room(edition)
    found = []
    for room, moments in ((late, [0.0, 0.9, 1.8, 5.5]), (punctual, [tick * TICK for tick in range(331)])):
        for one in (room.connect(create, act), room.connect(), room.connect(create, act)):
            one.play.scene.subscribe(["left_down", "right_down", "action_began", "action_ended"])
        room.tick(*moments)
        found.append([wire.events for wire in room.wires.values()])
    for events, expected in zip(*found, strict=True):
        assert [one for one in events if one["frame"] <= 108] == [one for one in expected if one["frame"] <= 108]
        last = [one["frame"] for one in events if one["frame"] > 108]
        assert last
        assert min(last) > 330 - 60  # by more than a second, characters do not move on
    assert "action_began" in {one["event"] for one in found[0][0]}


def test_what_all_connections_miss_counts_against_one_budget(edition: Edition, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each misses little, but together they miss too much to advance frame by frame."""
    steps: list[tuple[int, int]] = []
    leave_out = Ensemble.leave_out

    def noted(self: Any, frames: int, step: int) -> Any:
        steps.append((frames, step))
        return leave_out(self, frames, step)

    monkeypatch.setattr(Ensemble, "leave_out", noted)
    monkeypatch.setattr(lateness, "FEW", 100)
    room = Room(edition)
    for _ in range(10):
        room.connect()
    room.tick(0.0, 11.5 * TICK)
    assert steps == [(10, 1)]
    room.connect()
    room.tick(22.5 * TICK)
    assert [step for _, step in steps[1:]] == [6, 6]


def test_a_command_between_ticks_changes_only_its_own_scene(edition: Edition) -> None:
    room, alone = Room(edition), Room(edition)
    first, second = room.connect(), room.connect()
    twin = alone.connect()
    room.tick(0.0, TICK)
    alone.tick(0.0, TICK)
    asyncio.run(_do(room.hub, second, {"do": "create", "id": 2, "locomotion": "run"}))
    room.tick(*(tick * TICK for tick in range(2, 30)))
    alone.tick(*(tick * TICK for tick in range(2, 30)))
    assert first.play.scene.characters.state.tobytes() == twin.play.scene.characters.state.tobytes()
    assert msgpack.unpackb(room.wires[second].sent[-1])["ids"] == np.array([1, 2], "<u4").tobytes()
    for message, expected in zip(room.wires[first].sent, alone.wires[twin].sent, strict=True):
        assert msgpack.unpackb(message)["rotations"] == msgpack.unpackb(expected)["rotations"]


async def _do(hub: Hub, connection: Connection, command: dict[str, Any]) -> None:
    await hub._do(connection, list(checked(parse(json.dumps(command)), AXES["gltf"])))


@pytest.mark.parametrize(("seconds", "taken"), [(0.0, 16), (0.02, 5), (1.0, 1)])
def test_other_tasks_have_turns_after_a_late_tick_but_not_all_the_time(seconds: float, taken: int) -> None:
    """After a tick of 0.2 s, each turn takes `seconds`."""
    turns = 0

    class Clock:
        def time(self) -> float:
            return turns * seconds

    async def handshake() -> None:
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async def run() -> None:
        task = asyncio.create_task(handshake())
        await _serve_others(cast("asyncio.AbstractEventLoop", Clock()), TURNS, 0.2)
        task.cancel()

    asyncio.run(run())
    assert turns == taken


def test_clients_that_miss_no_frames_do_not_wait_for_one_that_catches_up(
    edition: Edition, monkeypatch: pytest.MonkeyPatch
) -> None:
    room, done = Room(edition), list[object]()
    held, healthy = room.connect(), room.connect()
    leave_out, send = Ensemble.leave_out, Wire.send_at_once

    def left_out(ensemble: Ensemble, frames: int, step: int) -> Any:
        done.append(frames)
        return leave_out(ensemble, frames, step)

    def sent(wire: Wire, message: bytes, *, text: bool) -> bool:
        done.append(wire)
        return send(wire, message, text=text)

    monkeypatch.setattr(Ensemble, "leave_out", left_out)
    monkeypatch.setattr(Wire, "send_at_once", sent)
    healthy.go_on(healthy.play._replace(due=30 * TICK, frame=30))
    held.wanted = 30 * TICK  # its frames waited for a list of commands
    room.tick(30 * TICK)
    assert done == [room.wires[healthy]]
    room.tick(*[30 * TICK] * 6)
    assert done == [room.wires[healthy], *[4] * 5, 10, room.wires[held]]
    assert (room.numbers(healthy), room.numbers(held)) == ([30], [30])
    assert "tick_lateness_seconds_count 1.0" in room.shared.metrics.render()[0].decode()


def test_characters_that_catch_up_in_turns_move_as_if_in_one(edition: Edition) -> None:
    """They do not move on by more than a second, in either way."""
    found = []
    for is_alone in (True, False):  # alone it misses frames as the clock does, which then sheds them
        room = Room(edition)
        late, punctual = room.connect(), room.connect()
        if is_alone:
            room.hub.connections.discard(punctual)
        else:
            punctual.go_on(punctual.play._replace(due=90 * TICK, frame=90))
            late.wanted = 90 * TICK
        room.tick(*[90 * TICK] * 20)
        assert room.hub._lateness.sheds is is_alone
        assert room.numbers(late)[0] == 90
        found.append(room.wires[late].sent[0])
    alone, beside = map(msgpack.unpackb, found)
    for name in ("root_positions", "rotations"):
        assert alone[name] == beside[name]


def test_those_that_catch_up_take_turns(edition: Edition, monkeypatch: pytest.MonkeyPatch) -> None:
    room, frames = Room(edition), list[int]()
    leave_out = Ensemble.leave_out

    def left_out(ensemble: Ensemble, count: int, step: int) -> Any:
        frames.append(count)
        return leave_out(ensemble, count, step)

    monkeypatch.setattr(Ensemble, "leave_out", left_out)
    for number in range(3):
        one = room.connect()
        one.go_on(one.play._replace(due=number * TICK))
        one.wanted = 30 * TICK
    room.hub._tick(30 * TICK)
    assert frames == [4]
