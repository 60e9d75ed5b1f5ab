"""Work that takes long, in a thread that the end of the service does not wait for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import TypeVar

Made = TypeVar("Made")


async def in_background(function: Callable[[], Made]) -> Made:
    """What a function returns or raises. If this is cancelled the thread goes on, and nobody hears of what it makes."""
    loop = asyncio.get_running_loop()
    made: asyncio.Future[Made] = loop.create_future()

    def tell(give: Callable[[Made], None] | Callable[[BaseException], None], what: Made | BaseException) -> None:
        if not made.done():
            give(what)  # type: ignore[arg-type]

    def work() -> None:
        try:
            give, what = made.set_result, function()
        except Exception as error:
            give, what = made.set_exception, error  # type: ignore[assignment]
        with suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(tell, give, what)

    Thread(target=work, daemon=True).start()
    return await made
