"""The messages of one WebSocket's client: received, charged, and done."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable

from starlette.types import Receive

from motionsplice.motion.errors import MotionError
from motionsplice.service.allowance import Allowance
from motionsplice.service.characters.commands import Command, checked, cost, parse, ref_of
from motionsplice.service.characters.connection import FAILED, IDLE, NO_TEXT, Connection
from motionsplice.service.problems import URN, kind_of
from motionsplice.service.turns import Turns

logger = logging.getLogger(__name__)

COPIED = 100.0  # copying this many characters costs about as much as one command; every message copies the scene
CHECKED = 64  # commands that are checked in a turn, within half a millisecond

Do = Callable[[Connection, Iterable[Command]], Awaitable[None]]  # raises MotionError if it did none of them


async def receive_commands(
    connection: Connection, receive: Receive, allowance: Allowance, turns: Turns, do: Do, idle_seconds: float
) -> None:
    """Receives messages and does their commands, until the client disconnects or the connection closes.

    Each message is charged before anything is done for it, and waits if the allowance is used up. A client without
    characters is closed after `idle_seconds` without a message.
    """
    loop = asyncio.get_running_loop()
    while connection.is_open:
        try:
            async with asyncio.timeout(None if len(connection.play.scene) else idle_seconds):
                message = await receive()
        except TimeoutError:
            connection.close(IDLE, f"no characters and no command for {idle_seconds:g} s")
            return
        if message["type"] == "websocket.disconnect":
            return
        text = message.get("text")
        if text is None:
            connection.close(NO_TEXT, "commands must be sent as text")
            return
        if wait := allowance.charge(cost(text) + len(connection.play.scene) / COPIED, loop.time()):
            await asyncio.sleep(wait)
        await turns.next()
        await _take(connection, text, turns, do)


async def _take(connection: Connection, text: str, turns: Turns, do: Do) -> None:
    """Does all commands of a message, or none, and queues the reply.

    All are checked before the first is done, and each again when it is done: the commands of long lists that are
    kept meanwhile would be many objects for the collector of garbage to visit.
    """
    ref, axes = None, connection.format.encoding.axes
    try:
        listed = parse(text)
        ref = ref_of(listed)
        for number, _ in enumerate(checked(listed, axes)):
            if number % CHECKED == CHECKED - 1:
                await turns.next()
        await do(connection, checked(listed, axes))
    except MotionError as error:
        connection.queue_event("refused", ref=ref, type=URN + kind_of(error)[1], detail=str(error))
    except Exception:
        logger.exception("commands failed")
        connection.close(FAILED, "the service failed; see its log")
    else:
        connection.queue_event("done", ref=ref, frame=connection.play.frame)
