"""Decodes messages of the service as docs/protocol.md describes, without the service's own code."""

from __future__ import annotations

from typing import Any

import msgpack
import numpy as np


def framed(stream: bytes) -> list[bytes]:
    """Returns the messages of a length-delimited stream."""
    read = []
    while stream:
        size = int.from_bytes(stream[:4], "big")
        assert len(stream) >= 4 + size
        read.append(stream[4 : 4 + size])
        stream = stream[4 + size :]
    return read


def unpacked(stream: bytes) -> list[dict[str, Any]]:
    """Returns the messages of a length-delimited stream, decoded."""
    return [msgpack.unpackb(message) for message in framed(stream)]


def arrays(message: dict[str, Any], joints: int, *leading: int, short: bool = False) -> dict[str, Any]:
    """Returns a message's blobs as arrays with leading dimensions; int16 is converted to -1 to 1."""
    found = {}
    for name, inner in (
        ("root_positions", (3,)),
        ("root_origins", (3,)),
        ("root_steps", (3,)),
        ("root_turns", ()),
        ("rotations", (joints, 4)),
        ("world_positions", (joints, 3)),
    ):
        if name in message:
            kind = "<i2" if short and name == "rotations" else "<f4"
            numbers = np.frombuffer(message[name], kind).reshape(*leading, *inner)
            found[name] = np.maximum(numbers / 32767.0, -1.0) if kind == "<i2" else numbers
    return found


def blob_offsets(message: bytes) -> dict[str, int]:
    """Returns where each blob of a MessagePack map begins, in bytes from the start of the message."""
    unpacker = msgpack.Unpacker(max_buffer_size=len(message))
    unpacker.feed(message)
    found = {}
    for _ in range(unpacker.read_map_header()):
        name, value = unpacker.unpack(), unpacker.unpack()
        if isinstance(value, bytes):
            found[name] = unpacker.tell() - len(value)
    assert unpacker.tell() == len(message)
    return found
