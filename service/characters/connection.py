"""One WebSocket: its scene, the clock that numbers its frames, and the messages that wait to be sent."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from typing import Any, Protocol

import orjson
from starlette.types import Send

from motionsplice.service.characters.ensemble import Ensemble
from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.characters.play import Play
from motionsplice.service.metrics import Metrics
from motionsplice.service.serving import Edition

TRANSPORT = "motionsplice.transport"  # name of the ASGI extension
MOST_EVENTS = 1000  # unsent events of one client
NO_TEXT, TOO_SLOW, FAILED, RESTART, IDLE = 1003, 1008, 1011, 1012, 4408
REFUSED = 4000  # and the status of the problem: close codes of WebSockets that are refused


class Transport(Protocol):
    """An object that a server may put into a handshake's extensions, to send frames without a task switch."""

    @property
    def is_free(self) -> bool:
        """Whether the send buffer is empty."""

    def send_at_once(self, message: bytes, *, text: bool) -> bool:
        """Sends a message, text or binary, if the send buffer is empty. Returns whether it did."""

    async def nothing_waits(self) -> None:
        """Waits until the send buffer is empty. Raises OSError if the client has disconnected."""


def event_message(event: str, **values: Any) -> bytes:
    """Returns an event as a text message."""
    return orjson.dumps({"event": event, **values})


class State(Enum):
    """Whether a connection can take frames. Events are queued independently, in any state but CLOSED."""

    READY = "ready"  # the next frames are made when they are due
    HOLDING = "holding"  # a message of frames waits to be sent
    DEFERRED = "deferred"  # frames were due while a message waited or the client was slow: the next wait for it
    CLOSING = "closing"  # the queued events and the close code are still to be sent
    CLOSED = "closed"  # nothing is sent any more


OPEN = State.READY, State.HOLDING, State.DEFERRED
NEXT: Mapping[State, frozenset[State]] = {
    State.READY: frozenset(State),
    State.HOLDING: frozenset(State),
    State.DEFERRED: frozenset(State),
    State.CLOSING: frozenset({State.CLOSING, State.CLOSED}),
    State.CLOSED: frozenset({State.CLOSED}),
}


class Connection:
    """One client's side of the hub.

    Attributes:
        state: See State. Methods that send frames do nothing once the connection is closing.
        play: What the next message of frames begins with.
        wanted: When that message is to be made, in seconds of the event loop's clock: when it is due, or when the
            client could take it if that was later. Infinite unless the state is READY or HOLDING.
        sent: What the last message began with if it holds frames that are not due yet, else None. A command goes back
            into it.
        ensemble: The scenes that were last made together with this one, or None.
        refused: The newer edition that this connection cannot move to and that its client knows of, or None.
        is_held: Whether the next frames wait for a long list of commands that is being done on a copy of the scene.
        format: The format of the frames.
    """

    def __init__(self, play: Play, form: FrameFormat, metrics: Metrics, transport: Transport | None) -> None:
        self.state = State.READY
        self.play = play
        self.wanted = play.due
        self.sent: Play | None = None
        self.ensemble: Ensemble | None = None
        self.refused: Edition | None = None
        self.is_held = False
        self.format = form
        self.metrics = metrics
        self._transport = transport
        self._events: deque[bytes] = deque()
        self._message: tuple[int, bytes] | None = None  # number of frames and their bytes
        self._close = (RESTART, "")  # code and reason, once CLOSING
        self._wake = asyncio.Event()  # something for `send` to do

    @property
    def is_open(self) -> bool:
        """Whether frames are sent and commands are received."""
        return self.state in OPEN

    @property
    def is_free(self) -> bool:
        """Whether a message would be sent at once. Frames made for a slow client would be out of date on arrival."""
        return self.state is State.READY and (self._transport is None or self._transport.is_free)

    def _enter(self, state: State) -> None:
        """Changes the state. Raises RuntimeError if the current state does not allow that."""
        if state not in NEXT[self.state]:
            raise RuntimeError(f"a connection cannot go from {self.state.value} to {state.value}")
        self.state = state

    def queue_event(self, event: str, **values: Any) -> None:
        """Queues an event, which is sent before any frames made later. Closes the connection if too many are unsent."""
        if self.state is State.CLOSED:
            return
        if len(self._events) >= MOST_EVENTS:
            self.close(TOO_SLOW, f"more than {MOST_EVENTS} events were left unread")
            return
        self._events.append(event_message(event, **values))
        self._wake.set()

    def defer(self) -> None:
        """Puts off the next message of frames until the client is free."""
        if self.is_open:
            self._enter(State.DEFERRED)
            self.wanted = math.inf
            self._wake.set()

    def send_frames(self, count: int, message: bytes) -> int:
        """Sends a message of `count` frames, or keeps it for `send`. Returns how many frames were sent at once."""
        if not self.is_open:
            return 0
        nothing_before = self._message is None and not self._events and not self._wake.is_set()
        if nothing_before and self._send_at_once(message):
            return count
        self._enter(State.HOLDING)
        self._message = count, message
        self._wake.set()
        return 0

    def go_on(self, play: Play) -> None:
        """Continues with later frames of the same scene."""
        self.play = play
        if self.state is State.READY or self.state is State.HOLDING:
            self.wanted = play.due

    def change(self, play: Play, now: float) -> None:
        """Continues with a changed scene, from its frame on. Makes that frame at once if it was already sent."""
        sooner = play.frame < self.play.frame
        self.play, self.sent, self.ensemble = play, None, None
        if not self.is_open:
            return
        if sooner:
            self._message = None  # its frames are out of date
        self._enter(State.READY if self._message is None else State.HOLDING)
        self.wanted = now if sooner else play.due

    @contextmanager
    def held(self) -> Iterator[None]:
        """Lets no frames be made, so that a list of commands takes several turns but takes effect between two frames.

        Other connections are not late because this one was held: its frames are wanted from now on.
        """
        self.is_held = True
        try:
            yield
        finally:
            self.is_held = False
            self.wanted = max(self.wanted, asyncio.get_running_loop().time())

    def close(self, code: int, reason: str) -> None:
        """Closes the connection once the queued events are sent. A connection that is closing keeps its first code."""
        if self.is_open:
            self._enter(State.CLOSING)
            self._close, self._message, self.wanted = (code, reason), None, math.inf
            self._wake.set()

    async def send(self, send: Send, free: Callable[[], None]) -> None:
        """Sends what is queued, events first, until the connection is closed.

        Calls `free` when a client whose frames were deferred can take a message. Raises OSError if the client has
        disconnected.
        """
        try:
            while self.is_open:
                await self._wake.wait()
                self._wake.clear()
                await self._send_events(send)
                if self._message is not None:
                    await self._until_free()
                    await self._send_message(send)
                if self.state is State.DEFERRED:
                    await self._until_free()
                    if self.state is State.DEFERRED:  # unless a command or `close` has changed it meanwhile
                        self._enter(State.READY)
                        self.wanted = max(self.play.due, asyncio.get_running_loop().time())
                        free()
            await self._send_events(send)
            code, reason = self._close
            await send({"type": "websocket.close", "code": code, "reason": reason})
        finally:
            self._enter(State.CLOSED)
            self.wanted = math.inf

    async def _send_events(self, send: Send) -> None:
        """Sends the queued events. Each stays in the queue until it is sent, so that no frame overtakes it."""
        while self._events:
            await send({"type": "websocket.send", "text": self._events[0].decode()})
            self._events.popleft()

    async def _until_free(self) -> None:
        if self._transport is not None:
            await self._transport.nothing_waits()

    async def _send_message(self, send: Send) -> None:
        """Sends the message that waits, unless a command or `close` has dropped it meanwhile."""
        if self._message is None:
            return
        (count, message), self._message = self._message, None
        if self.state is State.HOLDING:
            self._enter(State.READY)
        if not self._send_at_once(message):
            content = {"text": message.decode()} if self.format.is_text else {"bytes": message}
            await send({"type": "websocket.send", **content})
        self.metrics.frames_sent.inc(count)

    def _send_at_once(self, message: bytes) -> bool:
        return self._transport is not None and self._transport.send_at_once(message, text=self.format.is_text)

    def rewound(self, now: float) -> Play:
        """Returns a copy of the play at the first frame that is not due yet, which may have been sent already."""
        sent = self.sent
        if sent is not None and now < self.play.due - 1.0 / sent.rate:
            past = max(0, math.floor((now - sent.due) * sent.rate) + 1)
            scene = sent.scene.copy()
            for _ in range(past):
                scene.pass_frame()
            return sent._replace(scene=scene).after(past)
        return self.play._replace(scene=self.play.scene.copy())
