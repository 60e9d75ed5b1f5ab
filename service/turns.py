"""Turns of the event loop for work of unknown length that clients cause: one piece in each, whoever asks."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable


class Turns:
    """Gives each turn of the event loop to one piece of work, in the order of asking.

    However many clients flood the service, the clock of frames then waits for one piece at most.
    """

    def __init__(self) -> None:
        self._waiting: deque[Callable[[], None]] = deque()

    def call(self, work: Callable[[], None]) -> None:
        """Calls a function in a later turn, which it has for itself."""
        self._waiting.append(work)
        if len(self._waiting) == 1:
            asyncio.get_running_loop().call_soon(self._give)

    async def next(self) -> None:
        """Waits for a turn. What the task does until it waits again is one piece."""
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()

        def give() -> None:
            if not turn.done():  # it is if the task was cancelled meanwhile
                turn.set_result(None)

        self.call(give)
        await turn

    def _give(self) -> None:
        work = self._waiting.popleft()
        if self._waiting:
            asyncio.get_running_loop().call_soon(self._give)
        work()
