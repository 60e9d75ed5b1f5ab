"""All WebSockets of a process: one clock, and one evaluation of all frames that are due."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

from starlette.types import Receive, Scope, Send

from motionsplice.runtime.requests import Poses
from motionsplice.service.admission import SUBPROTOCOL, address_of
from motionsplice.service.allowance import Allowances
from motionsplice.service.characters.commands import Command, in_pieces
from motionsplice.service.characters.connection import FAILED, RESTART, TRANSPORT, Connection, State
from motionsplice.service.characters.ensemble import MOST_JOINED, Ensemble
from motionsplice.service.characters.frame_format import PARAMETERS, FrameFormat, frame_format
from motionsplice.service.characters.groups import alike, catch_up, punctual_first, together
from motionsplice.service.characters.incoming import receive_commands
from motionsplice.service.characters.lateness import IN_A_TURN, Lateness, moved
from motionsplice.service.characters.play import Play, next_tick
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
EARLY = 0.0005  # seconds by which a frame may be made before it is due: the precision of the event loop's timers
TURNS, SHARE = 16, 0.5  # turns of the event loop after a late tick, and of its time the part that they may take


class Hub:
    """Holds the connections, and runs the clock that makes their frames."""

    def __init__(self, shared: Shared) -> None:
        self.connections: set[Connection] = set()
        self._shared = shared
        self._changed = asyncio.Event()
        self._lateness = Lateness()
        self._receivers = Receivers(shared.settings, shared.metrics)
        self._allowances = Allowances(shared.settings.max_commands)
        shared.serving.listeners.append(self._exchange)

    async def serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serves one WebSocket from its handshake to its end. Raises MotionError before the handshake is accepted."""
        values, loop = CHARACTERS.read(scope["query_string"]), asyncio.get_running_loop()
        edition, form, rate = self._shared.serving.edition, frame_format(values), values["rate"]
        scene = Scene(edition, rate, self._shared.settings.max_characters, rebased=form.origins)
        play = Play(scene, 0, next_tick(loop.time(), rate), rate, values["ahead"])
        transport = scope.get("extensions", {}).get(TRANSPORT)
        connection = Connection(play, form, self._shared.metrics, transport)
        self._check(connection, play)
        with (
            self._shared.admitted(),
            self._shared.metrics.connection("characters"),
            self._allowances.of(address_of(scope), loop.time) as allowance,
        ):
            await accept(scope, receive, send)
            connection.queue_event("welcome", **self._welcome(play, form))
            self.connections.add(connection)
            self._changed.set()
            sending = asyncio.create_task(connection.send(send, self._changed.set))
            idle_seconds, turns = self._shared.settings.idle_seconds, self._shared.turns
            receiving = asyncio.create_task(
                receive_commands(connection, receive, allowance, turns, self._do, idle_seconds)
            )
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
        loop, turns = asyncio.get_running_loop(), self._shared.turns
        while True:
            due, now = min((one.wanted for one in self.connections if not one.is_held), default=math.inf), loop.time()
            if due <= now + EARLY:
                self._tick(now)
                turns.ticked(loop.time())
                await _serve_others(loop, TURNS if self._lateness.sheds else 1, loop.time() - now)
                continue
            self._lateness.end()
            turns.next_tick(due)
            self._changed.clear()
            alarm = loop.call_at(due, self._changed.set) if due < math.inf else None
            await self._changed.wait()
            if alarm is not None:
                alarm.cancel()

    def _tick(self, now: float) -> None:
        groups = self._due(now)
        self._lateness.begin(late := _late(groups, now))
        missed = {one: self._lateness.missed(one.play.due, one.play.rate, now) for group in groups for one in group}
        ordered, most = list(punctual_first(groups, missed)), math.inf
        if not self._lateness.sheds and any(missed.values()):  # some waited for their own commands
            ordered, most = alike(ordered, missed), IN_A_TURN
        if most == math.inf or not missed[ordered[0][0]]:  # the clock does not wait for those that catch up
            self._shared.metrics.tick_lateness.observe(late)
        work = sum(moved(missed[one], one.play.rate) * len(one.play.scene) for group in ordered for one in group)
        for group in ordered:
            try:
                skipped, is_whole = catch_up(group, missed, work, most)
                self._shared.metrics.frames_skipped.inc(skipped)
                if is_whole:
                    self._make(group)
            except Exception:
                logger.exception("making frames failed")
                for one in group:
                    one.close(FAILED, "the service failed; see its log")
        newest = self._shared.serving.edition
        for one in self.connections:  # a clip that the newest bank lacks may have been faded out by now
            if one.play.scene.edition is not newest and not one.is_held and not one.play.scene.missing(newest):
                self._move(one, newest)

    def _due(self, now: float) -> list[list[Connection]]:
        """Returns the connections that are to have frames now, in groups that have them made together."""
        groups: dict[tuple[Any, ...], list[Connection]] = {}
        for one in self.connections:
            if one.wanted > now + EARLY or one.is_held:
                continue
            if not one.is_free:
                one.defer()
                continue
            play, scene = one.play, one.play.scene
            alone = None if 0 < len(scene) <= MOST_JOINED else one
            groups.setdefault((scene.edition, play.rate, play.ahead, one.format, alone), []).append(one)
        return list(groups.values())

    def _make(self, group: list[Connection]) -> None:
        """Makes a message of frames for each connection of a group, and advances the scenes."""
        play, form = group[0].play, group[0].format
        if not len(play.scene):
            group[0].sent = None
            group[0].go_on(play.after(play.ahead))
            return
        if play.ahead > 1:
            for one in group:
                one.sent = one.play._replace(scene=one.play.scene.copy())
        ensemble, frames = together(group), []
        for later in range(play.ahead):
            poses, arrays = self._evaluate(play.scene.edition, ensemble, form)
            frames.append(arrays)
            for one, (first, end) in zip(group, ensemble.rows, strict=True):
                if one.play.scene.sent:
                    self._receivers.send(one, poses.rows(first, end))
            for row, event in ensemble.advance():
                group[row].queue_event(frame=group[row].play.frame + later + 1, **event)
        write = form.writer(play.scene.edition.bank.digest, play.rate, frames)
        wall, sent = time.time() - asyncio.get_running_loop().time(), 0
        for one, (first, end) in zip(group, ensemble.rows, strict=True):
            now = one.play
            sent += one.send_frames(play.ahead, write(now.frame, wall + now.due, now.scene.ids, first, end))
            one.go_on(now.after(play.ahead))
        self._shared.metrics.frames_sent.inc(sent)

    def _evaluate(self, edition: Edition, ensemble: Ensemble, form: FrameFormat) -> tuple[Poses, Arrays]:
        """Evaluates all characters of an ensemble. Returns their poses, and as encoded arrays [n, ...]."""
        began = time.perf_counter()
        poses = edition.evaluator.poses(len(ensemble))
        ensemble.evaluate(poses)
        arrays = {**form.motion(ensemble.characters), **form.encoding.arrays(edition.evaluator, poses)}
        self._shared.metrics.evaluation.observe(time.perf_counter() - began)
        return poses, arrays

    async def _do(self, connection: Connection, commands: Iterable[Command]) -> None:
        """Does all commands of a message, or none of them. Raises MotionError.

        Those of a long list are done in several turns of the event loop, while the connection's next frame waits.
        """
        loop = asyncio.get_running_loop()
        play = connection.rewound(loop.time())
        try:
            with ExitStack() as stack:
                for number, piece in enumerate(in_pieces(commands)):
                    if number == 1:
                        stack.enter_context(connection.held())
                    if number:
                        await self._shared.turns.next()
                    play = play.done(piece, loop.time())
                self._check(connection, play)
                connection.change(play, loop.time())
            self._receivers.claim(connection)
        finally:
            self._changed.set()
            newest = self._shared.serving.edition
            if newest not in (connection.play.scene.edition, connection.refused):  # exchanged while it was held
                self._move(connection, newest)

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
        if load > cost * connection.play.load and self._load(connection) + load > settings.max_load:
            problem = f"this process evaluates at most {settings.max_load} characters per second"
            raise BusyError(problem, mend="Ask for fewer characters or a lower rate, or ask another process")

    def _load(self, apart: Connection) -> float:
        """Returns the characters evaluated per second for all connections but one, by what they cost."""
        return sum(one.format.cost * one.play.load for one in self.connections if one is not apart)

    def _exchange(self, edition: Edition) -> None:
        for connection in self.connections:
            if not connection.is_held:
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


def _late(groups: list[list[Connection]], now: float) -> float:
    """Returns how late the frames of some groups are, in seconds. Clients that could not take them do not count."""
    return now - min((one.wanted for group in groups for one in group), default=now)


async def _serve_others(loop: asyncio.AbstractEventLoop, turns: int, spent: float) -> None:
    """Lets other tasks and sockets have turns of the event loop, after a tick that took `spent` seconds.

    A handshake or a command takes several turns, and a clock that is always late would leave one a tick.
    """
    end = loop.time() + SHARE * spent
    for _ in range(turns):
        await asyncio.sleep(0)
        if loop.time() >= end:
            return
