"""Encodes many messages of frames at once, each of which has some rows of the same arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.service.wire.encoding import Arrays
from motionsplice.service.wire.layout import ALIGNED, LENGTH, layout
from motionsplice.service.wire.messages import frame_fields, packer

IDS = "ids"
Pieces = tuple[list[memoryview], int]  # an array of each frame as bytes, and the bytes of a row


class RowMessages:
    """Messages as MessagePack: the bytes of `packed`, at a third of the time for messages of one row.

    Args:
        bank: The bank's digest.
        rate: Frames per second.
        frames: For each frame of a message the arrays [n, ...], contiguous.
    """

    def __init__(self, bank: str, rate: float, frames: Sequence[Arrays]) -> None:
        self._pieces: list[Pieces] = [
            ([_bytes(frame[name]) for frame in frames], array.nbytes // max(1, len(array)))
            for name, array in frames[0].items()
        ]
        fields = {**frame_fields(0, len(frames), rate), "time": 0.0}
        self._starts, self._heads = layout(bank, (IDS, *frames[0]), len(fields))
        self._pack = pack = packer().pack
        self._before = pack("frame")
        self._between = b"".join(pack(one) for name in ("count", "rate") for one in (name, fields[name])) + pack("time")
        self._separators: dict[int, list[bytes]] = {}

    def message(self, first: int, time: float, ids: NDArray[np.uint32], row: int, end: int) -> bytes:
        """Returns the message of the rows from `row` to `end` - 1, whose characters are `ids`.

        `first` is the number of the first frame, and `time` when it is due, in seconds since 1970.
        """
        pack = self._pack
        values = self._before + pack(first) + self._between + pack(time)
        start, head = self._starts[len(values) % ALIGNED]
        separators = self._separators.get(end - row) or self._separate(end - row)
        parts: list[bytes | memoryview] = [start, values, head, separators[0], ids.tobytes()]
        for (frames, size), separator in zip(self._pieces, separators[1:], strict=True):
            parts.append(separator)
            parts += [one[size * row : size * end] for one in frames]
        return b"".join(parts)

    def _separate(self, rows: int) -> list[bytes]:
        """Returns what precedes each array of a message of so many rows."""
        sizes = [4 * rows, *(len(frames) * size * rows for frames, size in self._pieces)]
        heads = (b"", *self._heads)
        found = [head + size.to_bytes(LENGTH, "big") for head, size in zip(heads, sizes, strict=False)]
        self._separators[rows] = found
        return found


def _bytes(array: NDArray[Any]) -> memoryview:
    return array.reshape(-1).view(np.uint8).data
