"""A transport that joins everything written in one turn of the event loop.

uvicorn writes a response's head and body separately, each with its own system call and packet.
"""

from __future__ import annotations

import asyncio
from typing import Any

LARGE = 16 * 1024  # bytes; copying more takes longer than sending the pieces


class Corked(asyncio.Transport):
    """Wraps the real transport."""

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop) -> None:
        self.transport = transport
        self._loop = loop
        self._pieces: list[bytes] = []

    def write(self, data: bytes | bytearray | memoryview[Any]) -> None:
        if not self._pieces:
            self._loop.call_soon(self.flush)
        self._pieces.append(bytes(data))

    def flush(self) -> None:
        """Sends everything written so far."""
        if self._pieces:
            pieces, self._pieces = self._pieces, []
            if sum(map(len, pieces)) > LARGE:
                self.transport.writelines(pieces)
            else:
                self.transport.write(b"".join(pieces))

    def write_now(self, data: bytes) -> None:
        """Sends data that nothing will follow in this turn, after everything written so far."""
        self.flush()
        self.transport.write(data)

    def close(self) -> None:
        self.flush()
        self.transport.close()

    def is_closing(self) -> bool:
        return self.transport.is_closing()

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return self.transport.get_extra_info(name, default)

    def pause_reading(self) -> None:
        self.transport.pause_reading()

    def resume_reading(self) -> None:
        self.transport.resume_reading()

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        self.transport.set_protocol(protocol)
