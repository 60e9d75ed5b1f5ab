"""Turns of the event loop for work of unknown length that clients cause: one piece in each, whoever asks."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable

AT_ONCE = 12  # pieces between two ticks of the clock that are begun whenever they are asked for
SHARE = 0.5  # of the time between two ticks, in which further pieces are begun
MOST_FREE = 0.02  # seconds before a frame is due in which no further pieces are begun
LAST, LAST_SHARE = 0.003, 0.25  # seconds, and part of the time between two ticks, before a frame: none at all is begun


class Turns:
    """Gives each turn of the event loop to one piece of work, in the order of asking.

    However many clients flood the service, the clock of frames then waits for none: the last one that is begun before
    a frame is due has LAST to end. More than AT_ONCE pieces are begun in the first part of the time until the next
    frame only, so that the process sleeps for a part of the time: the system prefers those that do.
    """

    def __init__(self) -> None:
        self._waiting: deque[Callable[[], None]] = deque()
        self._will_give = False
        self._left = AT_ONCE
        self._ticked, self._until, self._last = 0.0, math.inf, math.inf

    def call(self, work: Callable[[], None]) -> None:
        """Calls a function in a later turn, which it has for itself."""
        self._waiting.append(work)
        self._give_later()

    async def next(self) -> None:
        """Waits for a turn. What the task does until it waits again is one piece."""
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()

        def give() -> None:
            if not turn.done():  # it is if the task was cancelled meanwhile
                turn.set_result(None)

        self.call(give)
        await turn

    def ticked(self, now: float) -> None:
        """Notes that the clock has made the frames that were due."""
        self._ticked, self._left, self._last = now, AT_ONCE, math.inf
        self._give_later()

    def next_tick(self, due: float) -> None:
        """Notes when the next frame is due, infinite if none is."""
        if math.isinf(self._until):  # none was, for however long
            self.ticked(asyncio.get_running_loop().time())
        between = due - self._ticked
        self._until = max(self._ticked + SHARE * between, due - MOST_FREE)
        self._last = due - min(LAST, LAST_SHARE * between)
        self._give_later()

    def _give_later(self) -> None:
        if self._waiting and not self._will_give and self._may_give():
            self._will_give = True
            asyncio.get_running_loop().call_soon(self._give)

    def _may_give(self) -> bool:
        now = asyncio.get_running_loop().time()
        return now < self._last and (self._left > 0 or now < self._until)

    def _give(self) -> None:
        self._will_give = False
        if self._may_give():
            self._left -= 1
            work = self._waiting.popleft()
            self._give_later()
            work()
