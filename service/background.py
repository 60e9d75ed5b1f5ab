"""Long work in a thread that does not delay the end of the service."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import TypeVar

Result = TypeVar("Result")


async def in_background(function: Callable[[], Result]) -> Result:
    """Runs a function in a thread, and returns its result. If cancelled, the thread goes on, and the result is lost."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[Result] = loop.create_future()

    def settle(
        put: Callable[[Result], None] | Callable[[BaseException], None], outcome: Result | BaseException
    ) -> None:
        if not future.done():
            put(outcome)  # type: ignore[arg-type]

    def work() -> None:
        try:
            put, outcome = future.set_result, function()
        except Exception as error:
            put, outcome = future.set_exception, error  # type: ignore[assignment]
        with suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(settle, put, outcome)

    Thread(target=work, daemon=True).start()
    return await future
