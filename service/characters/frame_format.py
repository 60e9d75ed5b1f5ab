"""How a WebSocket's client wants its frames: their encoding, with root motion or without, MessagePack or JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.character import Characters
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import JSON_SHARE, frame_fields, json
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import flag
from motionsplice.service.wire.rows import RowMessages

Writer = Callable[[int, float, NDArray[np.uint32], int, int], bytes]

PARAMETERS = (
    *HOW,
    flag("deltas", "whether frames have root motion: `root_steps` and `root_turns`"),
    flag("origins", "whether positions are relative to `root_origins`, which keeps them precise far from the world's"),
    format_parameter("msgpack", "json"),
)


@dataclass(frozen=True, eq=False)
class FrameFormat:
    """The format of a client's frames. Two of `frame_format` are equal only if they are the same object."""

    encoding: Encoding
    deltas: bool = False
    origins: bool = False
    form: str = "msgpack"

    @property
    def fields(self) -> dict[str, Any]:
        """The query parameters that ask for this format."""
        return {**self.encoding.fields, "deltas": self.deltas, "origins": self.origins, "format": self.form}

    @property
    def is_text(self) -> bool:
        """Whether frames are JSON."""
        return self.form == "json"

    @property
    def cost(self) -> int:
        """How many times as much as in MessagePack a character counts against the limits."""
        return JSON_SHARE if self.is_text else 1

    def motion(self, characters: Characters) -> Arrays:
        """Returns `root_steps` [n, 3] and `root_turns` [n], and `root_origins` [n, 3], as far as they are wanted."""
        axes, arrays = self.encoding.axes, Arrays()
        if self.deltas:
            arrays["root_steps"] = axes.positions(characters.deltas[:, :3]).astype(np.float32, "C")
            arrays["root_turns"] = (axes.turn * characters.deltas[:, 3]).astype(np.float32)
        if self.origins:
            arrays["root_origins"] = axes.positions(characters.origins).astype(np.float32, "C")
        return arrays

    def writer(self, bank: str, rate: float, frames: list[Arrays]) -> Writer:
        """Returns what writes messages of some frames of characters, each frame with arrays [n, ...].

        It takes the number of the first frame, when that is due in seconds since 1970, the ids of the message's
        characters, and the rows that they have: the first, and the one after the last.
        """
        if not self.is_text:
            return RowMessages(bank, rate, frames).message

        def write(first: int, time: float, ids: NDArray[np.uint32], row: int, end: int) -> bytes:
            fields = {"event": "frames", **frame_fields(first, len(frames), rate), "time": time}
            arrays = {name: np.stack([frame[name][row:end] for frame in frames]) for name in frames[0]}
            return json(bank, fields, {"ids": ids, **arrays})

        return write


def frame_format(values: Mapping[str, Any]) -> FrameFormat:
    """Returns the format of a query that has the parameters PARAMETERS: the same object for the same parameters."""
    return _shared(*(values[parameter.name] for parameter in PARAMETERS))


@cache
def _shared(*values: Any) -> FrameFormat:
    given = dict(zip((parameter.name for parameter in PARAMETERS), values, strict=True))
    return FrameFormat(encoding(given), given["deltas"], given["origins"], given["format"])
