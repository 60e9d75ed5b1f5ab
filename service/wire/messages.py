"""Encodes maps of values and arrays: as MessagePack with a blob for each array, or as JSON for people."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import msgpack
import numpy as np
import orjson

from motionsplice.service.wire.encoding import Arrays

PROTOCOL = 3  # version of docs/protocol.md
JSON, MSGPACK = "application/json", "application/msgpack"
FIXMAP, MOST_KEYS, BIN32 = 0x80, 15, b"\xc6"  # MessagePack's format of small maps and of blobs
LENGTH = 4  # bytes of the length before a message of a stream, or before a blob


@cache
def _packer() -> msgpack.Packer:
    """Returns a shared packer: allocating its buffer takes longer than packing a message."""
    return msgpack.Packer()


@cache
def _blob_key(name: str) -> bytes:
    return bytes(_packer().pack(name)) + BIN32


def packed(fields: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Returns a map as MessagePack. Arrays become blobs of little-endian numbers in C order; they must be contiguous.

    The blobs are joined here rather than by msgpack, which would copy them twice more.
    """
    count = len(fields) + len(arrays)
    assert count <= MOST_KEYS
    parts: list[Any] = [bytes((FIXMAP | count,)), _packer().pack(fields)[1:]]
    for name, array in arrays.items():
        parts += (_blob_key(name), array.nbytes.to_bytes(LENGTH, "big"), array.data)
    return b"".join(parts)


def json(fields: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Returns a map as JSON. Arrays become nested lists."""
    contiguous = {name: np.ascontiguousarray(one) for name, one in arrays.items()}
    return orjson.dumps({**fields, **contiguous}, option=orjson.OPT_SERIALIZE_NUMPY)


class Form(NamedTuple):
    """A form of messages that clients can request."""

    media_type: bytes
    write: Callable[[Mapping[str, Any], Arrays], bytes]


FORMS = {"json": Form(JSON.encode(), json), "msgpack": Form(MSGPACK.encode(), packed)}


def frame_fields(bank: str, first: int, count: int, rate: float) -> dict[str, Any]:
    """Returns the fields of a message of frames: the bank's digest, number of the first frame, their count and rate."""
    return {"bank": bank, "frame": first, "count": count, "rate": rate}


def length_delimited(message: bytes) -> bytes:
    """Returns a message of a stream: its length in 4 bytes, big-endian, then the message."""
    return len(message).to_bytes(LENGTH, "big") + message
