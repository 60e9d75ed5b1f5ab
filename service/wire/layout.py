"""Where a MessagePack message has its arrays: each begins at a multiple of 4 bytes, so that a client needs no copy.

MessagePack lets a writer choose between forms of a head that differ in length, as between `fixstr`, `str 8` and
`str 16` for a key. So a message is aligned by its heads, without padding. All blobs are `bin 32`, and all arrays have a
multiple of 4 bytes.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

ALIGNED = 4  # bytes
FIXMAP, MAP16, MOST_KEYS = 0x80, b"\xde", 15
FIXSTR, MOST_FIXSTR, STR8, STR16 = 0xA0, 31, b"\xd9", b"\xda"
BIN32, LENGTH = b"\xc6", 4  # a blob's first byte, and the bytes of the length that follow
BANK = "bank"


class Layout(NamedTuple):
    """The bytes between the values of a message.

    Attributes:
        starts: The map's head and the first array's, up to its length, by the length of the fields modulo 4.
        heads: What follows each array: the next one's head, up to its length, and nothing after the last. The field
            `bank` precedes the last array.
    """

    starts: tuple[tuple[bytes, bytes], ...]
    heads: tuple[bytes, ...]


@lru_cache(maxsize=256)
def layout(bank: str, arrays: tuple[str, ...], fields: int) -> Layout:
    """Returns the layout of a message of some fields, then arrays of these names, at least two."""
    count = fields + 1 + len(arrays)
    assert count <= MOST_KEYS
    first, *between, last = arrays
    maps = bytes((FIXMAP | count,)), MAP16 + count.to_bytes(2, "big")
    starts = tuple(_aligned(length, maps, _keys(first)) for length in range(ALIGNED))
    banks = tuple(key + _text(bank) for key in _texts(BANK))
    heads = [b"".join(_aligned(0, (b"",), _keys(name))) for name in between]
    return Layout(starts, (*heads, b"".join(_aligned(0, banks, _keys(last))), b""))


def _aligned(before: int, some: tuple[bytes, ...], others: tuple[bytes, ...]) -> tuple[bytes, bytes]:
    """Returns the first pair after which, and after a blob's length, `before` bytes more are aligned."""
    return next(pair for pair in product(some, others) if (before + sum(map(len, pair)) + LENGTH) % ALIGNED == 0)


def _keys(name: str) -> tuple[bytes, ...]:
    """Returns the forms of an array's key, and the first byte of its blob."""
    return tuple(key + BIN32 for key in _texts(name))


def _texts(text: str) -> tuple[bytes, bytes, bytes]:
    """Returns the forms of a short text, each a byte longer than the one before."""
    data = text.encode()
    size = len(data)
    assert size <= MOST_FIXSTR
    return bytes((FIXSTR | size,)) + data, STR8 + size.to_bytes(1) + data, STR16 + size.to_bytes(2, "big") + data


def _text(text: str) -> bytes:
    """Returns a text of at most 255 bytes."""
    data = text.encode()
    return STR8 + len(data).to_bytes(1) + data
