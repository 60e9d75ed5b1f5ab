"""Unpacks MessagePack into no more memory than its size justifies."""

from __future__ import annotations

from typing import Any

import msgpack

BYTES = 16  # of data for each map or list, at least: an empty one takes a byte, and 64 or more in memory
FREE = 1000  # maps and lists that small data may have


def unpacked(data: bytes) -> Any:
    """Returns what `data` holds. Raises ValueError or msgpack.UnpackException if it is damaged or nothing but maps."""
    left = FREE + len(data) // BYTES

    def counted(container: Any) -> Any:
        nonlocal left
        left -= 1
        if left < 0:
            raise ValueError(f"more than one map or list in {BYTES} bytes")
        return container

    return msgpack.unpackb(data, object_hook=counted, list_hook=counted)
