"""One WebSocket: its scene, the clock that numbers its frames, and what waits to be sent."""

from __future__ import annotations

import asyncio
import logging
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import orjson
from starlette.types import Receive, Send

from motionsplice.motion.errors import MotionError
from motionsplice.service.characters.commands import Command, checked, parse, ref_of
from motionsplice.service.characters.scene import Scene
from motionsplice.service.metrics import Metrics
from motionsplice.service.problems import URN, told
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from motionsplice.service.wire.encoding import Encoding

logger = logging.getLogger(__name__)

TRANSPORT = "motionsplice.transport"  # the name of the extension
BURST = 10_000.0  # commands that may come at once before they have to wait
COPIED = 100.0  # characters whose copy, which a message works on, costs about what a command does
MOST_EVENTS = 1000  # that may wait for a client
NO_TEXT, TOO_SLOW, FAILED, RESTART, IDLE = 1003, 1008, 1011, 1012, 4408


class Transport(Protocol):
    """What a server may put into a handshake's extensions, so that frames need not pass through a task each."""

    @property
    def is_free(self) -> bool:
        """Whether nothing waits to be sent."""

    def send_at_once(self, message: bytes) -> bool:
        """Sends a binary message if nothing waits to be sent before it, and says whether it did."""

    async def nothing_waits(self) -> None:
        """Returns when nothing waits to be sent. Raises OSError if the client has gone."""


@dataclass(frozen=True, eq=False)
class Play:
    """A scene at a frame, which is due at `due`, seconds of the event loop's clock; so many frames per second,
    `ahead` of them in a message."""

    scene: Scene
    frame: int
    due: float
    rate: float
    ahead: int

    def after(self, count: int) -> Play:
        """So many frames later, of a scene that was advanced by as many."""
        return Play(self.scene, self.frame + count, self.due + count / self.rate, self.rate, self.ahead)

    @property
    def load(self) -> float:
        """Characters to be evaluated per second."""
        return len(self.scene) * self.rate


Do = Callable[["Connection", list[Command]], None]  # raises MotionError if it did none of them


class Connection:
    """What one client sees.

    `play` is what the next message begins with, which is to be made at `wanted`. `sent` is what the last one began
    with, if it reaches into the future: a command leads back into it.
    """

    def __init__(
        self, play: Play, encoding: Encoding, settings: Settings, metrics: Metrics, transport: Transport | None
    ) -> None:
        self.play = play
        self.sent: Play | None = None
        self.wanted = play.due
        self.stayed_from: Edition | None = None  # the newer edition that it was told to have no place in
        self.encoding = encoding
        self.settings = settings
        self.metrics = metrics
        self._transport = transport
        self._deferred = False
        self._events: deque[bytes] = deque()
        self._message: tuple[int, bytes] | None = None
        self._waiting = asyncio.Event()
        self._closing: tuple[int, str] | None = None

    def tell(self, event: str, **values: Any) -> None:
        """Has an event sent, before any frame that is made from now on."""
        if len(self._events) >= MOST_EVENTS:
            self.close(TOO_SLOW, "too many events were left unread")
            return
        self._events.append(orjson.dumps({"event": event, **values}))
        self._waiting.set()

    @property
    def is_free(self) -> bool:
        """Whether a message would be sent at once: what is made for one who is slow would only grow stale."""
        return self._message is None and (self._transport is None or self._transport.is_free)

    def defer(self) -> None:
        """Wants its next message when it is free."""
        self._deferred, self.wanted = True, math.inf
        self._waiting.set()

    def show(self, count: int, message: bytes) -> int:
        """Has a message of `count` frames sent, at once if that can be. Returns how many frames were."""
        if self._transport is not None and not self._waiting.is_set() and self._transport.send_at_once(message):
            return count
        self._message = count, message
        self._waiting.set()
        return 0

    def close(self, code: int, reason: str) -> None:
        """Has the connection closed, after the events that wait."""
        if self._closing is None:
            self._closing = code, reason
            self._waiting.set()

    @property
    def is_closing(self) -> bool:
        return self._closing is not None

    async def send(self, send: Send, free: Callable[[], None]) -> None:
        """Sends what waits until the connection is to be closed, events first; calls `free` once a deferred one is."""
        while True:
            await self._waiting.wait()
            self._waiting.clear()
            while self._events:
                await send({"type": "websocket.send", "text": self._events.popleft().decode()})
            if self._closing is not None:
                code, reason = self._closing
                await send({"type": "websocket.close", "code": code, "reason": reason})
                return
            if self._message is not None:
                if self._transport is not None:
                    await self._transport.nothing_waits()
                (count, message), self._message = self._message, None
                if self._transport is None or not self._transport.send_at_once(message):
                    await send({"type": "websocket.send", "bytes": message})
                self.metrics.frames_sent.inc(count)
            if self._deferred:
                if self._transport is not None:
                    await self._transport.nothing_waits()
                self._deferred, self.wanted = False, self.play.due
                free()

    def rewound(self, now: float) -> Play:
        """A copy of what is to be shown from the first frame on that is not due yet."""
        sent = self.sent
        if sent is not None and now < self.play.due - 1.0 / sent.rate:
            past = max(0, math.floor((now - sent.due) * sent.rate) + 1)
            scene = sent.scene.copy()
            for _ in range(past):
                scene.pass_frame()
            return replace(sent, scene=scene).after(past)
        return replace(self.play, scene=self.play.scene.copy())

    def change(self, play: Play, now: float) -> None:
        """Goes on with another play, from its frame on: at once, if that was sent already."""
        sooner = play.frame < self.play.frame
        self.play, self.sent = play, None
        self.wanted = now if sooner else play.due
        if sooner:
            self._message = None

    async def receive(self, receive: Receive, do: Do) -> None:
        """Has the commands of each message done, until the client goes."""
        loop, most = asyncio.get_running_loop(), self.settings.max_commands
        allowance, since = BURST, loop.time()
        while not self.is_closing:
            try:
                async with asyncio.timeout(None if len(self.play.scene) else self.settings.idle_seconds):
                    message = await receive()
            except TimeoutError:
                self.close(IDLE, f"no characters and no command for {self.settings.idle_seconds:g} s")
                return
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if text is None:
                self.close(NO_TEXT, "commands are text")
                return
            spent, now = self._take(text, do), loop.time()
            allowance, since = min(BURST, allowance + (now - since) * most) - spent, now
            if allowance < 0.0:
                await asyncio.sleep(-allowance / most)

    def _take(self, text: str, do: Do) -> float:
        """Has all commands of a message done, or none, and answers. Returns what it cost, in commands."""
        ref = None
        try:
            listed = parse(text)
            ref = ref_of(listed)
            commands = checked(listed)
            do(self, commands)
        except MotionError as error:
            self.tell("refused", ref=ref, type=URN + told(error)[1], detail=str(error))
            return 1.0
        except Exception:
            logger.exception("commands could not be done")
            self.close(FAILED, "the service failed; its log says how")
            return 1.0
        self.tell("done", ref=ref, frame=self.play.frame)
        held = len(self.play.scene) / COPIED
        return held + sum(1.0 + len(command.ids) / 10.0 for command in commands)
