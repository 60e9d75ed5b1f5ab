"""How a WebSocket's client wants its frames: their encoding, with root motion or without, MessagePack or JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import JSON_SHARE, frame_fields, json, packed
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import flag

PARAMETERS = (
    *HOW,
    flag("deltas", "whether frames have root motion: `root_steps` and `root_turns`"),
    format_parameter("msgpack", "json"),
)


@dataclass(frozen=True, eq=False)
class FrameFormat:
    """The format of a client's frames. Two of `frame_format` are equal only if they are the same object."""

    encoding: Encoding
    deltas: bool = False
    form: str = "msgpack"

    @property
    def fields(self) -> dict[str, Any]:
        """The query parameters that ask for this format."""
        return {**self.encoding.fields, "deltas": self.deltas, "format": self.form}

    @property
    def is_text(self) -> bool:
        """Whether frames are JSON."""
        return self.form == "json"

    @property
    def cost(self) -> int:
        """How many times as much as in MessagePack a character counts against the limits."""
        return JSON_SHARE if self.is_text else 1

    def motion(self, deltas: NDArray[np.float64]) -> Arrays:
        """Returns the root motion [n, 4] of `Characters.deltas` as `root_steps` [n, 3] and `root_turns` [n]."""
        axes = self.encoding.axes
        return {
            "root_steps": axes.positions(deltas[:, :3]).astype(np.float32, "C"),
            "root_turns": (axes.turn * deltas[:, 3]).astype(np.float32),
        }

    def message(
        self, bank: str, first: int, rate: float, time: float, ids: NDArray[np.uint32], frames: list[Arrays]
    ) -> bytes:
        """Returns the message of some frames of the characters `ids`, each with arrays [n, ...].

        `first` is the number of the first frame, and `time` when it is due, in seconds since 1970.
        """
        fields = {**frame_fields(first, len(frames), rate), "time": time}
        arrays = {"ids": ids, **{name: _stacked([frame[name] for frame in frames]) for name in frames[0]}}
        return json(bank, {"event": "frames", **fields}, arrays) if self.is_text else packed(bank, fields, arrays)


def frame_format(values: Mapping[str, Any]) -> FrameFormat:
    """Returns the format of a query that has the parameters PARAMETERS: the same object for the same parameters."""
    return _shared(*(values[parameter.name] for parameter in PARAMETERS))


@cache
def _shared(*values: Any) -> FrameFormat:
    given = dict(zip((parameter.name for parameter in PARAMETERS), values, strict=True))
    return FrameFormat(encoding(given), given["deltas"], given["format"])


def _stacked(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    """Returns arrays [n, ...] of each frame as one array [F, n, ...]."""
    return arrays[0][None] if len(arrays) == 1 else np.stack(arrays)
