"""What the service is compared with: `python -m bench.service.control KIND BYTES`, on a free port.

uvicorn   a bare application on the same loop and the same protocols. It answers any request with so many bytes, and one
          ticker sends as many to all WebSockets, 60 times a second.
bytes     no server at all: whatever arrives is answered with so many bytes. That is as fast as a client can ask.
"""

from __future__ import annotations

import asyncio
import socket
import sys
from contextlib import AbstractContextManager, suppress
from typing import Any, Literal, cast

import uvicorn
import uvloop
from starlette.types import Receive, Scope, Send

from bench.rounds import TICK
from bench.service.servers import MARK, Endpoint, started


def control(kind: Literal["uvicorn", "bytes"], size: int) -> AbstractContextManager[Endpoint]:
    """A control server, which sends `size` bytes a message."""
    return started("-m", "bench.service.control", kind, str(size))


class Bare:
    """An ASGI application that computes nothing."""

    def __init__(self, size: int) -> None:
        self.constant = bytes(size)
        self.headers = [(b"content-type", b"application/msgpack"), (b"content-length", str(size).encode())]
        self.sends: list[Send] = []

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._live(receive, send)
        elif scope["type"] == "websocket":
            await self._stream(receive, send)
        else:
            await send({"type": "http.response.start", "status": 200, "headers": self.headers})
            await send({"type": "http.response.body", "body": self.constant})

    async def _live(self, receive: Receive, send: Send) -> None:
        await receive()
        ticking = asyncio.create_task(self._tick())
        await send({"type": "lifespan.startup.complete"})
        await receive()
        ticking.cancel()
        await send({"type": "lifespan.shutdown.complete"})

    async def _stream(self, receive: Receive, send: Send) -> None:
        await receive()
        await send({"type": "websocket.accept"})
        self.sends.append(send)
        while (await receive())["type"] != "websocket.disconnect":
            pass
        self.sends.remove(send)

    async def _tick(self) -> None:
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            due += TICK
            await asyncio.sleep(max(0.0, due - loop.time()))
            for send in tuple(self.sends):
                with suppress(OSError):  # which is that the client went
                    await send({"type": "websocket.send", "bytes": self.constant})


class Constant(asyncio.Protocol):
    """Answers each piece that arrives, as if it were one request."""

    def __init__(self, size: int) -> None:
        self._answer = b"HTTP/1.1 200 OK\r\ncontent-length: %d\r\n\r\n" % size + bytes(size)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.Transport", transport)

    def data_received(self, data: bytes) -> None:
        self._transport.write(self._answer)


async def _answer_all(listener: socket.socket, size: int) -> None:
    server = await asyncio.get_running_loop().create_server(lambda: Constant(size), sock=listener)
    await server.serve_forever()


def main(kind: str, size: int) -> None:
    """Says the port, and serves until ended."""
    listener = socket.create_server(("127.0.0.1", 0), backlog=2048)
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    print(f"{MARK}{listener.getsockname()[1]}/", flush=True)
    if kind == "bytes":
        uvloop.run(_answer_all(listener, size))
        return
    options: dict[str, Any] = {"http": "httptools", "ws": "websockets-sansio", "loop": "uvloop"}
    config = uvicorn.Config(
        Bare(size), ws_per_message_deflate=False, access_log=False, log_level="warning", server_header=False, **options
    )
    uvicorn.Server(config).run(sockets=[listener])


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
