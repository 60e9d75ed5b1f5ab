"""Maps of numbers and arrays as bytes: MessagePack with one blob per array for engines, JSON for people."""

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
FIXMAP, MOST_KEYS, BIN32 = 0x80, 15, b"\xc6"  # of MessagePack
LENGTH = 4  # bytes of the length of a message in a stream, or of a blob


@cache
def _packer() -> msgpack.Packer:
    """One for all: each has a buffer, which costs more to get than a message does to pack."""
    return msgpack.Packer()


@cache
def _blob_key(name: str) -> bytes:
    return bytes(_packer().pack(name)) + BIN32


def packed(told: Mapping[str, Any], arrays: Arrays) -> bytes:
    """A map as MessagePack: arrays are blobs of little-endian numbers, in C order.

    The blobs are joined here and not by msgpack, which would copy them twice more; so they must be contiguous.
    """
    count = len(told) + len(arrays)
    assert count <= MOST_KEYS
    parts: list[Any] = [bytes((FIXMAP | count,)), _packer().pack(told)[1:]]
    for name, array in arrays.items():
        parts += (_blob_key(name), array.nbytes.to_bytes(LENGTH, "big"), array.data)
    return b"".join(parts)


def json(told: Mapping[str, Any], arrays: Arrays) -> bytes:
    """A map as JSON: arrays are nested lists."""
    contiguous = {name: np.ascontiguousarray(one) for name, one in arrays.items()}
    return orjson.dumps({**told, **contiguous}, option=orjson.OPT_SERIALIZE_NUMPY)


class Form(NamedTuple):
    """A form of messages that clients may ask for."""

    media_type: bytes
    write: Callable[[Mapping[str, Any], Arrays], bytes]


FORMS = {"json": Form(JSON.encode(), json), "msgpack": Form(MSGPACK.encode(), packed)}


def frame_fields(bank: str, first: int, count: int, rate: float) -> dict[str, Any]:
    """What a message says of its frames: the bank's digest, the first one's number, how many, how many a second."""
    return {"bank": bank, "frame": first, "count": count, "rate": rate}


def length_delimited(message: bytes) -> bytes:
    """A message of a stream, with its length before it."""
    return len(message).to_bytes(LENGTH, "big") + message
