"""All WebSockets of a process: one clock, and one evaluation of all frames that are due."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
from starlette.types import Receive, Scope, Send

from motionsplice.runtime.requests import Poses
from motionsplice.service.admission import SUBPROTOCOL
from motionsplice.service.characters.commands import Command
from motionsplice.service.characters.connection import FAILED, RESTART, TRANSPORT, Connection, State
from motionsplice.service.characters.frame_format import PARAMETERS, FrameFormat, frame_format
from motionsplice.service.characters.play import Play
from motionsplice.service.characters.receivers import Receivers
from motionsplice.service.characters.scene import Scene
from motionsplice.service.problems import BusyError, LimitError, at_most
from motionsplice.service.serving import Edition
from motionsplice.service.shared import Shared
from motionsplice.service.wire.encoding import Arrays
from motionsplice.service.wire.messages import PROTOCOL
from motionsplice.service.wire.query import Query, integer, number

logger = logging.getLogger(__name__)

CHARACTERS = Query(
    number("rate", "frames per second", 60.0, least=1.0, most=1000.0),
    integer("ahead", "frames in a message", 1, least=1, most=1000),
    *PARAMETERS,
)
LEFT_OUT = 1.0  # seconds by which characters move on at most when frames are left out
BEHIND = 0.1  # seconds by which the clock may be late before frames are left out
EARLY = 0.0005  # seconds by which a frame may be made before it is due: the precision of the event loop's timers


class Hub:
    """Holds the connections, and runs the clock that makes their frames."""

    def __init__(self, shared: Shared) -> None:
        self.connections: set[Connection] = set()
        self._shared = shared
        self._changed = asyncio.Event()
        self._receivers = Receivers(shared.settings, shared.metrics)
        shared.serving.listeners.append(self._exchange)

    async def serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serves one WebSocket from its handshake to its end. Raises MotionError before the handshake is accepted."""
        values, loop = CHARACTERS.read(scope["query_string"]), asyncio.get_running_loop()
        edition, form, rate = self._shared.serving.edition, frame_format(values), values["rate"]
        scene = Scene(edition, rate, self._shared.settings.max_characters)
        play = Play(scene, 0, _next_tick(loop.time(), rate), rate, values["ahead"])
        transport = scope.get("extensions", {}).get(TRANSPORT)
        connection = Connection(play, form, self._shared.settings, self._shared.metrics, transport)
        self._check(connection, play)
        with self._shared.admitted(), self._shared.metrics.connection("characters"):
            await accept(scope, receive, send)
            connection.queue_event("welcome", **self._welcome(play, form))
            self.connections.add(connection)
            self._changed.set()
            sending = asyncio.create_task(connection.send(send, self._changed.set))
            receiving = asyncio.create_task(connection.receive(receive, self._do))
            try:
                await asyncio.wait((sending, receiving), return_when=asyncio.FIRST_COMPLETED)
                if connection.state is State.CLOSING:
                    await asyncio.wait((sending,), timeout=self._shared.settings.stall_seconds)
            finally:
                self.connections.discard(connection)
                self._receivers.release(connection)
                for task in (sending, receiving):
                    task.cancel()
                for result in await asyncio.gather(sending, receiving, return_exceptions=True):
                    if isinstance(result, Exception) and not isinstance(result, OSError):  # the client disconnected
                        logger.error("a connection failed", exc_info=result)

    async def stop(self) -> None:
        """Closes all connections, and waits up to `stop_seconds` until they are closed."""
        for connection in self.connections:
            connection.queue_event("closing", reason="the service stops")
            connection.close(RESTART, "the service stops")
        end = asyncio.get_running_loop().time() + self._shared.settings.stop_seconds
        while self.connections and asyncio.get_running_loop().time() < end:
            await asyncio.sleep(0.01)

    async def run(self) -> None:
        """Runs the clock: makes frames when they are due, until cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            due = min((one.wanted for one in self.connections), default=math.inf)
            if due <= loop.time() + EARLY:
                self._tick(loop.time())
                await asyncio.sleep(0)
                continue
            self._changed.clear()
            alarm = loop.call_at(due, self._changed.set) if due < math.inf else None
            await self._changed.wait()
            if alarm is not None:
                alarm.cancel()

    def _tick(self, now: float) -> None:
        groups: dict[tuple[Edition, float, int, FrameFormat], list[Connection]] = {}
        first, missed = now, 0
        for one in self.connections:
            if one.wanted > now + EARLY:
                continue
            if not one.is_free:
                one.defer()
                continue
            first = min(first, one.wanted)
            missed += _catch_up(one, now)
            play = one.play
            if len(play.scene):
                groups.setdefault((play.scene.edition, play.rate, play.ahead, one.format), []).append(one)
            else:
                one.sent = None
                one.go_on(play.after(play.ahead))
        self._shared.metrics.tick_lateness.observe(now - first)
        self._shared.metrics.frames_skipped.inc(missed)
        for (edition, rate, ahead, form), group in groups.items():
            try:
                self._make(edition, rate, ahead, form, group)
            except Exception:
                logger.exception("making frames failed")
                for one in group:
                    one.close(FAILED, "the service failed; see its log")
        newest = self._shared.serving.edition
        for one in self.connections:  # a clip that the newest bank lacks may have been faded out by now
            if one.play.scene.edition is not newest and not one.play.scene.missing(newest):
                self._move(one, newest)

    def _make(self, edition: Edition, rate: float, ahead: int, form: FrameFormat, group: list[Connection]) -> None:
        """Makes a message of `ahead` frames for each connection of a group, and advances the scenes."""
        scenes = [one.play.scene for one in group]
        if ahead > 1:
            for one in group:
                one.sent = replace(one.play, scene=one.play.scene.copy())
        ends = np.cumsum([len(scene) for scene in scenes]).tolist()
        frames: list[Arrays] = []
        for later in range(ahead):
            poses, arrays = self._evaluate(edition, scenes, form)
            frames.append(arrays)
            for one, first, end in zip(group, [0, *ends], ends, strict=False):
                if one.play.scene.sent:
                    self._receivers.send(one, poses.rows(first, end))
                for event in one.play.scene.advance():
                    one.queue_event(frame=one.play.frame + later + 1, **event)
        wall, loop = time.time(), asyncio.get_running_loop().time()
        sent = 0
        for one, first, end in zip(group, [0, *ends], ends, strict=False):
            play, time_due = one.play, wall + one.play.due - loop
            own = [{name: array[first:end] for name, array in frame.items()} for frame in frames]
            message = form.message(edition.bank.digest, play.frame, rate, time_due, play.scene.ids, own)
            sent += one.send_frames(ahead, message)
            one.go_on(play.after(ahead))
        self._shared.metrics.frames_sent.inc(sent)

    def _evaluate(self, edition: Edition, scenes: list[Scene], form: FrameFormat) -> tuple[Poses, Arrays]:
        """Evaluates all characters of some scenes. Returns their poses, and as encoded arrays [n, ...]."""
        began = time.perf_counter()
        poses, first = edition.evaluator.poses(sum(len(scene) for scene in scenes)), 0
        for scene in scenes:
            scene.evaluate(poses.rows(first, first + len(scene)))
            first += len(scene)
        motion = form.motion(np.concatenate([scene.characters.deltas for scene in scenes])) if form.deltas else {}
        arrays = {**motion, **form.encoding.arrays(edition.evaluator, poses)}
        self._shared.metrics.evaluation.observe(time.perf_counter() - began)
        return poses, arrays

    def _do(self, connection: Connection, commands: list[Command]) -> None:
        """Does all commands of a message, or none of them. Raises MotionError."""
        now = asyncio.get_running_loop().time()
        play = connection.rewound(now)
        for command in commands:
            if command.do == "set":
                rate, ahead = command.values.get("rate", play.rate), command.values.get("ahead", play.ahead)
                due = play.due if rate == play.rate else _next_tick(now, rate)
                play = replace(play, rate=float(rate), ahead=ahead, due=due)
                play.scene.keep_time(play.rate)
                if "events" in command.values:
                    play.scene.subscribe(command.values["events"])
            else:
                play.scene.do(command)
        self._check(connection, play)
        connection.change(play, now)
        self._receivers.claim(connection)
        self._changed.set()

    def _check(self, connection: Connection, play: Play) -> None:
        """Checks what a connection is to play. Raises LimitError for limits of a message or client, else BusyError."""
        settings, cost = self._shared.settings, connection.format.cost
        at_most("rate", play.rate, settings.max_rate)
        at_most("ahead", play.ahead, settings.max_ahead)
        self._receivers.check(play)
        if play.ahead * len(play.scene) > (most := settings.max_characters // cost):
            problem = f"{len(play.scene)} characters times {play.ahead} frames are too many for one message"
            raise LimitError(problem, mend=f"Ask for at most {most} characters times frames")
        load = cost * play.load
        others = sum(one.format.cost * one.play.load for one in self.connections if one is not connection)
        if load > cost * connection.play.load and others + load > settings.max_load:
            problem = f"this process evaluates at most {settings.max_load} characters per second"
            raise BusyError(problem, mend="Ask for fewer characters or a lower rate, or ask another process")

    def _exchange(self, edition: Edition) -> None:
        for connection in self.connections:
            self._move(connection, edition)

    def _move(self, connection: Connection, edition: Edition) -> None:
        """Moves a connection to another edition from its next frame on, if that has all clips and hands it plays."""
        now = asyncio.get_running_loop().time()
        play = connection.rewound(now)
        if missing := play.scene.missing(edition):
            if connection.refused is not edition:
                connection.refused = edition
                connection.queue_event("bank_kept", bank=edition.bank.digest, missing=missing)
            return
        play.scene.move(edition)
        connection.change(play, now)
        axes = connection.format.encoding.axes
        connection.queue_event("bank", frame=play.frame, **edition.rig(axes), clips=edition.clips)
        self._changed.set()

    def _welcome(self, play: Play, form: FrameFormat) -> dict[str, Any]:
        edition = play.scene.edition
        return {
            "protocol": PROTOCOL,
            **edition.rig(form.encoding.axes),
            "clips": edition.clips,
            **form.fields,
            "rate": play.rate,
            "ahead": play.ahead,
            "max_characters": self._shared.settings.max_characters // form.cost,
            "receivers": self._receivers.kinds,
        }


async def accept(scope: Scope, receive: Receive, send: Send) -> None:
    """Accepts a handshake."""
    await receive()
    offered = SUBPROTOCOL if SUBPROTOCOL in scope["subprotocols"] else None
    await send({"type": "websocket.accept", "subprotocol": offered})


def _next_tick(now: float, rate: float) -> float:
    """Returns the next moment at which all connections of this rate have a frame."""
    return math.ceil(now * rate) / rate


def _catch_up(connection: Connection, now: float) -> int:
    """Leaves frames out if the clock is more than BEHIND late. Returns how many."""
    play = connection.play
    missed = math.floor((now - play.due) * play.rate) if now - play.due > BEHIND else 0
    if missed:
        play.scene.leave_out(min(missed, math.ceil(LEFT_OUT * play.rate)))
        connection.play = play.after(missed)
    return missed
