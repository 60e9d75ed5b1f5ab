"""Maps of numbers and arrays as bytes: MessagePack with one blob per array for engines, JSON for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgpack
import numpy as np
import orjson

from service.wire.encoding import Arrays

JSON, MSGPACK = "application/json", "application/msgpack"
MEDIA_TYPES = {"json": JSON, "msgpack": MSGPACK}
LENGTH = 4  # bytes of a message's length in a stream


def packed(told: Mapping[str, Any], arrays: Arrays) -> bytes:
    """A map as MessagePack: arrays are blobs of little-endian numbers, in C order."""
    blobs = {name: np.ascontiguousarray(one).data.cast("B") if one.size else b"" for name, one in arrays.items()}
    message: bytes = msgpack.packb({**told, **blobs})
    return message


def json(told: Mapping[str, Any], arrays: Arrays) -> bytes:
    """A map as JSON: arrays are nested lists."""
    contiguous = {name: np.ascontiguousarray(one) for name, one in arrays.items()}
    return orjson.dumps({**told, **contiguous}, option=orjson.OPT_SERIALIZE_NUMPY)


def length_delimited(message: bytes) -> bytes:
    """A message of a stream, with its length before it."""
    return len(message).to_bytes(LENGTH, "big") + message
