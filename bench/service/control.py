"""The control: the same HTTP server as the service's, which sends constant bytes and evaluates nothing.

`python -m bench.service.control SIZE RATE` answers each HTTP request with SIZE bytes. It also sends SIZE bytes to each
WebSocket RATE times a second, to all at the same time.
"""

from __future__ import annotations

import asyncio
import math
import socket
import sys
from typing import Any

import uvicorn


class Control:
    """The ASGI application of the control."""

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
        """Wakes all WebSockets at the same time, at multiples of 1 / rate seconds."""
        loop = asyncio.get_running_loop()
        while True:
            alarm = loop.create_future()
            loop.call_at((math.floor(loop.time() * self.rate) + 1) / self.rate, alarm.set_result, None)
            await alarm
            tick, self.tick = self.tick, asyncio.Event()
            tick.set()


def main() -> None:
    """Serves on a free port, and prints it."""
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
