"""Encodes maps of values and arrays: as MessagePack with a blob for each array, or as JSON for people."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import msgpack
import numpy as np
import orjson

from motionsplice.service.wire.encoding import Arrays
from motionsplice.service.wire.layout import LENGTH, layout

PROTOCOL = 3  # version of docs/protocol.md
JSON, MSGPACK = "application/json", "application/msgpack"
JSON_SHARE = 16  # JSON is about this many times larger and slower than blobs, so its limits are lower
JSON_NUMBERS = 8192  # numbers that are written as JSON at once, within a few tenths of a millisecond


@cache
def packer() -> msgpack.Packer:
    """Returns a shared packer: allocating its buffer takes longer than packing a message."""
    return msgpack.Packer()


def packed_map(fields: Mapping[str, Any]) -> bytes:
    """Returns a map without arrays as MessagePack."""
    return bytes(packer().pack(fields))


def packed(bank: str, fields: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Returns a message of frames as MessagePack: some fields, arrays, and `bank`, the bank's digest.

    Arrays become blobs of little-endian numbers in C order; they must be contiguous. Each begins at a multiple of 4
    bytes (`layout`). The blobs are joined here rather than by msgpack, which would copy them twice more.
    """
    return b"".join(pieces(bank, fields, arrays))


def pieces(bank: str, fields: Mapping[str, Any], arrays: Arrays) -> list[Any]:
    """Returns the pieces of `packed`, the arrays among them, which may change before they are joined."""
    values = packer().pack(fields)[1:]
    starts, heads = layout(bank, tuple(arrays), len(fields))
    start, first = starts[len(values) % 4]
    found: list[Any] = [start, values, first]
    for array, next_head in zip(arrays.values(), heads, strict=True):
        found += (array.nbytes.to_bytes(LENGTH, "big"), array, next_head)
    return found


def json(bank: str, fields: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Returns a message of frames as JSON. Arrays become nested lists."""
    contiguous = {name: np.ascontiguousarray(one) for name, one in arrays.items()}
    return orjson.dumps({**fields, "bank": bank, **contiguous}, option=orjson.OPT_SERIALIZE_NUMPY)


def json_pieces(bank: str, fields: Mapping[str, Any], arrays: Arrays) -> Iterator[bytes]:
    """Yields the same as `json` in pieces of about JSON_NUMBERS."""
    written = json(bank, fields, {})[:-1]
    for name, array in arrays.items():
        written += b"," + orjson.dumps(name) + b":["
        rows = max(1, JSON_NUMBERS // math.prod(array.shape[1:]))
        for first in range(0, len(array), rows):
            some = np.ascontiguousarray(array[first : first + rows])
            yield written + orjson.dumps(some, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1]
            written = b"," if first + rows < len(array) else b""
        written += b"]"
    yield written + b"}"


class Form(NamedTuple):
    """A form of messages that clients can request."""

    media_type: bytes
    write: Callable[[str, Mapping[str, Any], Arrays], bytes]


FORMS = {"json": Form(JSON.encode(), json), "msgpack": Form(MSGPACK.encode(), packed)}


def frame_fields(first: int, count: int, rate: float) -> dict[str, Any]:
    """Returns the fields of a message of frames: number of the first frame, count of frames, and rate."""
    return {"frame": first, "count": count, "rate": rate}


def length_delimited(message: bytes) -> bytes:
    """Returns a message of a stream: its length in 4 bytes, big-endian, then the message."""
    return len(message).to_bytes(LENGTH, "big") + message
