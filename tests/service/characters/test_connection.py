"""The states of a connection, without a socket."""

from __future__ import annotations

import asyncio
import itertools
import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from starlette.types import Message

from motionsplice.runtime.bank import Bank
from motionsplice.service.characters.connection import MOST_EVENTS, TOO_SLOW, Connection, State
from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.characters.play import Play
from motionsplice.service.characters.scene import Scene
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition
from motionsplice.service.wire.encoding import Encoding


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


class Buffer:
    """A transport whose send buffer is emptied by hand."""

    def __init__(self) -> None:
        self.emptied = asyncio.Event()
        self.sent: list[bytes] = []

    @property
    def is_free(self) -> bool:
        return self.emptied.is_set()

    def send_at_once(self, message: bytes, *, text: bool) -> bool:
        if self.is_free:
            self.sent.append(message)
        return self.is_free

    async def nothing_waits(self) -> None:
        await self.emptied.wait()


class Client:
    """A connection whose messages are kept in a list; `freed` counts calls of `free`."""

    def __init__(self, edition: Edition, transport: Buffer | None = None) -> None:
        play = Play(Scene(edition, 60.0, 100), 10, 5.0, 60.0, 1)
        self.connection = Connection(play, FrameFormat(Encoding()), Metrics(), transport)
        self.messages: list[Message] = []
        self.freed = 0

    async def send(self, message: Any) -> None:
        self.messages.append(message)

    def free(self) -> None:
        self.freed += 1

    def start(self) -> asyncio.Task[None]:
        return asyncio.ensure_future(self.connection.send(self.send, self.free))


def play(connection: Connection, frame: int) -> Play:
    """The same scene at another frame."""
    return connection.play.after(frame - connection.play.frame)


async def turns() -> None:
    """Lets other tasks run until they wait."""
    for _ in range(10):
        await asyncio.sleep(0)


def test_a_message_that_cannot_be_sent_at_once_is_kept(edition: Edition) -> None:
    async def run() -> None:
        buffer = Buffer()
        client = Client(edition, buffer)
        connection, sending = client.connection, client.start()
        assert connection.send_frames(1, b"a") == 0
        assert (connection.state, connection.is_free) == (State.HOLDING, False)
        await turns()
        assert connection.state is State.HOLDING
        buffer.emptied.set()
        await turns()
        assert (connection.state, connection.is_free, buffer.sent) == (State.READY, True, [b"a"])
        assert connection.send_frames(1, b"b") == 1
        assert (connection.state, buffer.sent) == (State.READY, [b"a", b"b"])
        sending.cancel()

    asyncio.run(run())


def test_deferred_frames_are_wanted_again_when_the_client_is_free(edition: Edition) -> None:
    async def run() -> None:
        buffer = Buffer()
        client = Client(edition, buffer)
        connection, sending = client.connection, client.start()
        connection.send_frames(1, b"a")
        connection.defer()
        connection.go_on(play(connection, 11))
        assert (connection.state, connection.wanted) == (State.DEFERRED, math.inf)
        await turns()
        assert (connection.state, client.freed) == (State.DEFERRED, 0)
        buffer.emptied.set()
        await turns()
        assert (connection.state, client.freed, buffer.sent) == (State.READY, 1, [b"a"])
        assert connection.play.due < connection.wanted <= asyncio.get_running_loop().time()
        sending.cancel()

    asyncio.run(run())


@pytest.mark.parametrize("deferred", [False, True])
@pytest.mark.parametrize(("frame", "state", "sent"), [(9, State.READY, []), (10, State.HOLDING, [b"a"])])
def test_a_command_drops_a_message_that_it_makes_out_of_date(
    edition: Edition, deferred: bool, frame: int, state: State, sent: list[bytes]
) -> None:
    async def run() -> None:
        buffer = Buffer()
        client = Client(edition, buffer)
        connection, sending = client.connection, client.start()
        connection.send_frames(1, b"a")
        if deferred:
            connection.defer()
        await turns()  # the message waits for the buffer
        connection.change(play(connection, frame), 4.0)
        assert connection.state is state
        assert connection.wanted == (4.0 if frame < 10 else 5.0)
        buffer.emptied.set()
        await turns()
        assert (connection.state, buffer.sent, sending.done()) == (State.READY, sent, False)
        sending.cancel()

    asyncio.run(run())


def test_closing_sends_the_queued_events_and_no_frames(edition: Edition) -> None:
    async def run() -> None:
        client = Client(edition)
        connection = client.connection
        connection.queue_event("done", ref=1)
        connection.send_frames(1, b"a")
        connection.close(4000, "first")
        connection.close(4001, "second")
        connection.queue_event("closing")
        assert (connection.state, connection.is_open, connection.wanted) == (State.CLOSING, False, math.inf)
        await client.start()
        assert connection.state is State.CLOSED
        *events, end = client.messages
        assert [json.loads(event["text"])["event"] for event in events] == ["done", "closing"]
        assert end == {"type": "websocket.close", "code": 4000, "reason": "first"}

    asyncio.run(run())


CALLS: list[Callable[[Connection], object]] = [
    lambda connection: connection.defer(),
    lambda connection: connection.send_frames(1, b"late"),
    lambda connection: connection.go_on(play(connection, 11)),
    lambda connection: connection.change(play(connection, 9), 4.0),
    lambda connection: connection.close(4001, "late"),
]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("closed", [False, True])
def test_a_connection_that_closes_stays_closed(edition: Edition, call: Any, closed: bool) -> None:
    async def run() -> None:
        client = Client(edition)
        client.connection.close(4000, "over")
        if closed:
            await client.start()
        call(client.connection)
        assert client.connection.state is (State.CLOSED if closed else State.CLOSING)
        assert client.connection.wanted == math.inf
        if not closed:
            await client.start()
        assert client.messages == [{"type": "websocket.close", "code": 4000, "reason": "over"}]

    asyncio.run(run())


def test_a_connection_that_is_cut_is_closed(edition: Edition) -> None:
    async def run() -> None:
        client = Client(edition)
        sending = client.start()
        await turns()
        sending.cancel()
        await turns()
        assert client.connection.state is State.CLOSED
        client.connection.queue_event("late")
        assert not client.messages

    asyncio.run(run())


def test_too_many_unread_events_close_it(edition: Edition) -> None:
    async def run() -> None:
        client = Client(edition)
        for number in range(MOST_EVENTS + 1):
            assert client.connection.is_open
            client.connection.queue_event("stride", frame=number)
        assert client.connection.state is State.CLOSING
        await client.start()
        assert client.messages[-1]["code"] == TOO_SLOW

    asyncio.run(run())


FORBIDDEN = {
    (State.CLOSING, State.READY), (State.CLOSING, State.HOLDING), (State.CLOSING, State.DEFERRED),
    (State.CLOSED, State.READY), (State.CLOSED, State.HOLDING), (State.CLOSED, State.DEFERRED),
    (State.CLOSED, State.CLOSING),
}  # fmt: skip


@pytest.mark.parametrize(("state", "wanted"), [*itertools.product(State, State)])
def test_a_closing_connection_never_opens_again(edition: Edition, state: State, wanted: State) -> None:
    connection = Client(edition).connection
    connection.state = state
    if (state, wanted) not in FORBIDDEN:
        connection._enter(wanted)
        assert connection.state is wanted
    else:
        with pytest.raises(RuntimeError, match=f"from {state.value} to {wanted.value}"):
            connection._enter(wanted)
        assert connection.state is state


def test_no_frame_overtakes_an_event_that_is_being_sent(edition: Edition) -> None:
    """The buffer empties while an event waits for it, and frames are made before the event goes on."""

    async def run() -> None:
        buffer = Buffer()
        client = Client(edition, buffer)
        order: list[str] = []

        async def send(message: Any) -> None:
            await buffer.emptied.wait()
            order.append("event" if "text" in message else "frames")

        client.connection.queue_event("bank")
        sending = asyncio.create_task(client.connection.send(send, client.free))
        await asyncio.sleep(0.01)
        buffer.emptied.set()
        assert client.connection.send_frames(1, b"frames") == 0
        assert not buffer.sent
        await asyncio.sleep(0.01)
        assert order == ["event"]
        assert buffer.sent == [b"frames"]
        sending.cancel()

    asyncio.run(run())
