"""Open Sound Control 1.0, as far as VMC uses it: messages, and bundles of a limited size."""

from __future__ import annotations

import struct
from collections.abc import Sequence

HEADER = b"#bundle\0" + struct.pack(">Q", 1)  # the time tag that means "at once"


def message(address: str, *arguments: str | int | float) -> bytes:
    """Returns a message with text, int32 and float32 arguments. Its length is a multiple of 4 bytes."""
    tags, data = ",", b""
    for argument in arguments:
        if isinstance(argument, str):
            tags, data = tags + "s", data + _text(argument)
        elif isinstance(argument, int):
            tags, data = tags + "i", data + struct.pack(">i", argument)
        else:
            tags, data = tags + "f", data + struct.pack(">f", argument)
    return _text(address) + _text(tags) + data


def bundled(messages: Sequence[bytes], most: int) -> tuple[list[bytes], list[int]]:
    """Puts messages, in order, into bundles of at most `most` bytes.

    Returns the bundles, and the byte at which each message ends, counted through all bundles one after another.
    """
    bundles, ends, before = [HEADER], list[int](), 0
    for content in messages:
        element = struct.pack(">i", len(content)) + content
        if len(bundles[-1]) + len(element) > most:
            before += len(bundles[-1])
            bundles.append(HEADER)
        bundles[-1] += element
        ends.append(before + len(bundles[-1]))
    return bundles, ends


def _text(text: str) -> bytes:
    """Returns text, ended by one to four zero bytes so that its length is a multiple of 4."""
    data = text.encode()
    return data + b"\0" * (4 - len(data) % 4)
