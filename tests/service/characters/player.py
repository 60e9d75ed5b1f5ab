"""A client of the WebSocket, as docs/protocol.md describes it."""

from __future__ import annotations

import json
import time
from types import TracebackType
from typing import Any, Self

import msgpack
import numpy as np
from websockets.sync.client import connect

from tests.service.messages import arrays, blob_offsets
from tests.service.running import PATIENCE, Running


class Player:
    """Sends commands, and decodes events and frames."""

    def __init__(self, service: Running, query: str = "", **options: Any) -> None:
        url = f"ws://127.0.0.1:{service.port}/v1/characters{query}"
        self._connection = connect(url, compression=None, max_size=None, **options)
        self.socket = self._connection.__enter__()
        self.frames: list[dict[str, Any]] = []
        self.events: list[dict[str, Any]] = []
        self.welcome = self.event("welcome")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.__exit__(kind, error, trace)

    def take(self) -> None:
        """Receives the next message."""
        message = self.socket.recv(timeout=PATIENCE)
        if isinstance(message, bytes):
            frame = msgpack.unpackb(message)
            assert not any(offset % 4 for offset in blob_offsets(message).values())
            ids = np.frombuffer(frame["ids"], "<u4")
            short = self.welcome["encoding"] == "int16"
            decoded = arrays(frame, len(self.welcome["joints"]), frame["count"], len(ids), short=short)
            self.frames.append({**frame, **decoded, "ids": ids.tolist()})
        elif (event := json.loads(message))["event"] == "frames":
            self.frames.append({key: _array(value) for key, value in event.items()})
        else:
            self.events.append(event)

    def event(self, *kinds: str) -> dict[str, Any]:
        """Returns the next event of these kinds, and drops others before it."""
        deadline = time.monotonic() + PATIENCE
        while True:
            assert time.monotonic() < deadline, f"no {kinds}"
            while self.events:
                if (event := self.events.pop(0))["event"] in kinds:
                    return event
            self.take()

    def frame(self) -> dict[str, Any]:
        """Returns the next message of frames."""
        while not self.frames:
            self.take()
        return self.frames.pop(0)

    def do(self, *commands: dict[str, Any]) -> dict[str, Any]:
        """Sends a message of commands, and returns the reply. Frames before it stay in `frames`."""
        self.socket.send(json.dumps(commands[0] if len(commands) == 1 else commands))
        return self.event("done", "refused")

    def frames_until(self, number: int) -> list[dict[str, Any]]:
        """Returns all messages of frames up to the one that has frame `number`."""
        taken = [self.frame()]
        while taken[-1]["frame"] + taken[-1]["count"] <= number:
            taken.append(self.frame())
        return taken


def _array(value: Any) -> Any:
    """Returns nested lists as an array."""
    return np.array(value) if isinstance(value, list) and isinstance(value[0], list) else value
