"""Long lists of commands: what they are charged, and the order in which they are done."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterable
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.service import turns
from motionsplice.service.allowance import Allowance
from motionsplice.service.characters.commands import MOST_IDS, PIECE, WHOLE, Command, checked, cost, in_pieces, parse
from motionsplice.service.characters.connection import Connection, State
from motionsplice.service.characters.incoming import receive_commands
from motionsplice.service.serving import Edition
from motionsplice.service.turns import Turns
from tests.service.characters.test_connection import Client
from tests.service.characters.test_hub import TICK, Room

WALK = {"do": "create", "id": 1, "locomotion": "walk"}


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


@pytest.mark.parametrize(
    ("commands", "wanted"),
    [
        (WALK, 1),
        ([WALK] * 1600, 1600),
        ({**WALK, "id": list(range(10_000))}, 1000.1),
        ({"do": "place", "id": 1, "position": [1, 2, 3], "heading": 1}, 1),
        ([0] * 5000, 499.9),
        ([[]] * 5000, 5001),
        (" " * 64 * 1024, 64),
    ],
)
def test_a_message_is_charged_by_its_text(commands: Any, wanted: float) -> None:
    assert cost(commands if isinstance(commands, str) else json.dumps(commands)) == pytest.approx(wanted)


COMMANDS = st.lists(
    st.builds(
        lambda do, count: Command(do, tuple(range(count)), {}),
        st.sampled_from(["act", "place", "send", "set"]),
        st.one_of(st.integers(0, 3), st.integers(0, 2000)),
    ),
    max_size=60,
)


@given(COMMANDS)
def test_pieces_are_the_commands_in_their_order_and_none_is_long(commands: list[Command]) -> None:
    pieces = list(in_pieces(commands))
    found = [(one.do, number) for piece in pieces for one in piece for number in one.ids or (None,)]
    assert found == [(one.do, number) for one in commands for number in one.ids or (None,)]
    for piece in pieces:
        assert 0 < len(piece) <= PIECE
        assert sum(len(one.ids) for one in piece if one.do not in WHOLE) <= 2 * MOST_IDS


def test_a_piece_is_made_when_it_is_done() -> None:
    made = iter(range(1000))
    next(in_pieces(Command("stop", (number,), {}) for number in made))
    assert next(made) <= PIECE + 1


class Counting(Allowance):
    """An allowance that notes what it is charged, and what was done by then."""

    def __init__(self, done: list[str], wait: float = 0.0) -> None:
        super().__init__(1000.0, 0.0, 0.0)
        self.charged: list[tuple[float, int]] = []
        self.wait = wait
        self._done = done

    def charge(self, cost: float, now: float) -> float:
        self.charged.append((cost, len(self._done)))
        return self.wait


def _received(client: Client, allowance: Allowance, done: list[str], *texts: str) -> None:
    """Lets a connection receive texts until it waits for more."""

    async def do(connection: Connection, commands: Iterable[Command]) -> None:
        done.append(next(iter(commands)).do)

    async def run() -> None:
        messages = [{"type": "websocket.receive", "text": text} for text in texts]

        async def receive() -> Any:
            return messages.pop(0) if messages else {"type": "websocket.disconnect"}

        task = asyncio.create_task(receive_commands(client.connection, receive, allowance, Turns(), do, 60.0))
        await asyncio.wait([task], timeout=0.2)
        task.cancel()

    asyncio.run(run())


def test_each_message_is_charged_before_it_is_done_also_if_it_is_refused(edition: Edition) -> None:
    done: list[str] = []
    allowance, client = Counting(done), Client(edition)
    wrong = [WALK] * 9 + [{"do": "fly"}]
    _received(client, allowance, done, json.dumps(WALK), json.dumps(wrong), "{" * 50, json.dumps([WALK] * 3))
    assert allowance.charged == [(1, 0), (10, 1), (50, 1), (3, 1)]
    assert done == ["create", "create"]
    assert [json.loads(one)["event"] for one in client.connection._events] == ["done", "refused", "refused", "done"]


def test_a_client_over_its_allowance_waits_before_anything_is_done(edition: Edition) -> None:
    done: list[str] = []
    allowance, client = Counting(done, wait=1000.0), Client(edition)
    _received(client, allowance, done, json.dumps(WALK), json.dumps(WALK))
    assert allowance.charged == [(1, 0)]
    assert not done
    assert not client.connection._events


def _commands(count: int) -> list[Command]:
    """Returns commands for character 1 that take several turns, and of which each shows."""
    moves = [{"do": "place", "id": 1, "position": [number, 0, 0]} for number in range(count)]
    return list(checked(parse(json.dumps([*moves, {"do": "act", "id": 1, "action": "wave"}])), AXES["gltf"]))


async def _turns(count: int) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


def test_a_long_list_takes_several_turns_and_shows_from_one_frame_on(edition: Edition) -> None:
    room = Room(edition)
    flooding, healthy = room.connect(), room.connect()

    async def run() -> None:
        moment = asyncio.get_running_loop().time()
        for one in (flooding, healthy):
            one.go_on(one.play._replace(due=moment))
        task = asyncio.create_task(room.hub._do(flooding, _commands(100)))
        await _turns(4)
        assert flooding.is_held
        assert not task.done()
        for tick in range(3):
            room.hub._tick(moment + tick * TICK)
        assert (room.numbers(healthy), room.numbers(flooding)) == ([0, 1, 2], [])
        await task
        assert not flooding.is_held
        assert flooding.wanted >= moment
        flooding.wanted = moment + 3 * TICK  # however long the list took here
        room.hub._tick(moment + 3 * TICK)
        assert (room.numbers(healthy), room.numbers(flooding)) == ([0, 1, 2, 3], [0])

    asyncio.run(run())
    at_once = Room(edition)
    twin = at_once.connect()
    for command in _commands(100):
        twin.play.scene.do(command)
    at_once.tick(0.0)
    found, expected = (msgpack.unpackb(one.sent[0]) for one in (room.wires[flooding], at_once.wires[twin]))
    assert found["rotations"] == expected["rotations"]
    assert found["root_positions"] == expected["root_positions"]
    assert flooding.play.scene.characters.state.tobytes() == twin.play.scene.characters.state.tobytes()


def test_a_long_list_that_is_refused_changes_nothing(edition: Edition) -> None:
    room = Room(edition)
    one = room.connect()
    before = one.play.scene.characters.state.copy()

    async def run() -> None:
        commands = [*_commands(50), Command("stop", (99,), {})]
        with pytest.raises(Exception, match="character 99 not found"):
            await room.hub._do(one, commands)

    asyncio.run(run())
    assert not one.is_held
    assert np.array_equal(one.play.scene.characters.state, before)


def test_a_connection_that_closes_during_a_long_list_stays_closed(edition: Edition) -> None:
    room = Room(edition)
    one = room.connect()

    async def run() -> None:
        task = asyncio.create_task(room.hub._do(one, _commands(100)))
        await _turns(4)
        one.close(1012, "the service stops")
        await task
        assert (one.state, one.is_held) == (State.CLOSING, False)

    asyncio.run(run())


def test_a_bank_that_is_exchanged_during_a_long_list_is_moved_to_after_it(edition: Edition) -> None:
    room = Room(edition)
    one, newer = room.connect(), Edition.warm(edition.bank)

    async def run() -> None:
        task = asyncio.create_task(room.hub._do(one, _commands(100)))
        await _turns(4)
        room.shared.serving.exchange(newer)
        assert one.play.scene.edition is edition
        await task
        assert one.play.scene.edition is newer
        assert [json.loads(event)["event"] for event in one._events] == ["bank"]

    asyncio.run(run())


def test_many_characters_of_one_command_are_done_in_parts(edition: Edition) -> None:
    room, whole = Room(edition), Room(edition)
    ids = list(range(2, 2002))
    fields = [{"do": "create", "id": ids, "locomotion": "run"}, {"do": "act", "id": ids, "action": "wave"}]
    one, twin = room.connect(), whole.connect()
    commands = list(checked(fields, AXES["gltf"]))
    asyncio.run(room.hub._do(one, commands))
    for command in commands:
        twin.play.scene.do(command)
    assert one.play.scene.ids.tolist() == twin.play.scene.ids.tolist()
    assert one.play.scene.characters.state.tobytes() == twin.play.scene.characters.state.tobytes()


def test_the_clock_bounds_the_pieces_between_two_frames(edition: Edition, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "SHARE", 0.0)
    room, done = Room(edition), list[str]()
    healthy, tick = room.connect(), room.hub._tick

    def ticked(now: float) -> None:
        done.append("tick")
        tick(now)

    monkeypatch.setattr(room.hub, "_tick", ticked)

    async def run() -> None:
        healthy.go_on(healthy.play._replace(due=asyncio.get_running_loop().time()))
        clock = asyncio.create_task(room.hub.run())
        await _turns(2)
        for _ in range(10 * turns.AT_ONCE):
            room.shared.turns.call(lambda: done.append("piece"))
        while done.count("piece") < 10 * turns.AT_ONCE:
            await asyncio.sleep(0.001)
        clock.cancel()

    asyncio.run(run())
    counts = [len(one) for one in "".join(one[0] for one in done).split("t")]
    assert max(counts) == turns.AT_ONCE
    assert room.numbers(healthy) == list(range(len(room.numbers(healthy))))
