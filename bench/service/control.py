"""What the service is compared with: the same server, which sends constant bytes and evaluates nothing.

`python -m bench.service.control SIZE RATE` answers each HTTP request with SIZE bytes, and sends as many to each
WebSocket RATE times a second, all at the same moments.
"""

from __future__ import annotations

import asyncio
import math
import socket
import sys
from typing import Any

import uvicorn


class Control:
    """An ASGI application."""

    def __init__(self, size: int, rate: float) -> None:
        self.body = bytes(size)
        self.rate = rate
        self.tick = asyncio.Event()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "lifespan":
            ticking = None
            while (message := await receive())["type"] == "lifespan.startup":
                ticking = asyncio.create_task(self.run())
                await send({"type": "lifespan.startup.complete"})
            if ticking is not None:
                ticking.cancel()
            await send({"type": message["type"] + ".complete"})
        elif scope["type"] == "http":
            length = str(len(self.body)).encode()
            headers = [(b"content-type", b"application/msgpack"), (b"content-length", length)]
            await send({"type": "http.response.start", "status": 200, "headers": headers})
            await send({"type": "http.response.body", "body": self.body})
        else:
            await receive()
            await send({"type": "websocket.accept"})
            while True:
                await self.tick.wait()
                await send({"type": "websocket.send", "bytes": self.body})

    async def run(self) -> None:
        """Lets all send at once, at multiples of 1 / rate."""
        loop = asyncio.get_running_loop()
        while True:
            alarm = loop.create_future()
            loop.call_at((math.floor(loop.time() * self.rate) + 1) / self.rate, alarm.set_result, None)
            await alarm
            tick, self.tick = self.tick, asyncio.Event()
            tick.set()


def main() -> None:
    listener = socket.create_server(("127.0.0.1", 0), backlog=1024)
    print(f"port {listener.getsockname()[1]}", flush=True)
    config = uvicorn.Config(
        Control(int(sys.argv[1]), float(sys.argv[2])),
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        access_log=False,
        log_level="error",
        proxy_headers=False,
        server_header=False,
    )
    uvicorn.Server(config).run(sockets=[listener])


if __name__ == "__main__":
    main()
