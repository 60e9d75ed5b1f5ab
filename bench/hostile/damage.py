"""Damages files: their bytes, the lines of a text, and the JSON document of a glTF file."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from random import Random
from typing import Any

from motionsplice.motion.formats.gltf.container import CHUNK, HEAD, MAGIC, VERSION, read_document

Damage = Callable[[bytes, bytes, Random], bytes]  # of a file, with another file of its kind at hand

NUMBERS = (
    "0, 1, -1, 2, 3, 255, 65536, 2147483647, 4294967296, 9223372036854775808, 0.5, -0.5, 1e9, 1e300, NaN, Infinity"
)
TEXTS = r'"", "0", "node", "../x", "\ud800", "\u0000"'
OTHERS = 'true, false, null, [], [[]], [0, 0, 0, 0], {}, {"": 0}'
LARGE = f'1{"0" * 30}, "{"x" * 5000}", {"[" * 400 + "]" * 400}, [NaN{", NaN" * 15}], [1e300{", 1e300" * 15}]'
# As JSON: each is read anew, because damage changes it.
VALUES = tuple(map(json.dumps, json.loads(f"[{NUMBERS}, {TEXTS}, {OTHERS}, {LARGE}]")))
WORDS = ("0", "-1", "1e308", "-1e400", "nan", "inf", "1e-320", "9" * 400, "{", "}", "JOINT x", "End Site", ":", "\0")
INTEGERS = (0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
FLOATS = (float("nan"), float("inf"), -1.0, 0.0, 1e30, -1e30, 1e38, 1e-45)


def damage_bytes(data: bytes, other: bytes, draw: Random) -> bytes:
    """Flips bits, writes other numbers, cuts, repeats or removes a piece, or takes one from the other file."""
    damaged = bytearray(data)
    for _ in range(draw.choice((1, 1, 2, 4))):
        at = draw.randrange(len(damaged) + 1)
        size = min(int(2.0 ** draw.uniform(0.0, 12.0)), len(damaged))
        kind = draw.randrange(8)
        if kind == 0 and damaged:
            damaged[at % len(damaged)] ^= 1 << draw.randrange(8)
        elif kind == 1 and damaged:
            damaged[at % len(damaged)] = draw.randrange(256)
        elif kind == 2:
            _put(damaged, at, struct.pack("<I", draw.choice(INTEGERS)))
        elif kind == 3:
            _put(damaged, at, struct.pack("<f", draw.choice(FLOATS)))
        elif kind == 4:
            del damaged[at:]
        elif kind == 5:
            del damaged[at : at + size]
        elif kind == 6:
            damaged[at:at] = damaged[at : at + size]
        else:
            begin = draw.randrange(len(other))
            damaged[at : at + size] = other[begin : begin + size]
    return bytes(damaged)


def _put(damaged: bytearray, at: int, number: bytes) -> None:
    at -= at % 4
    damaged[at : at + 4] = number


def damage_text(data: bytes, other: bytes, draw: Random) -> bytes:
    """Replaces words, and removes, repeats, moves or swaps lines, or takes lines from the other file."""
    lines, others = data.split(b"\n"), other.split(b"\n")
    for _ in range(draw.randint(1, 2)):
        at, to = draw.randrange(len(lines)), draw.randrange(len(lines))
        kind = draw.randrange(6)
        if kind <= 1:
            words = lines[at].split(b" ")
            words[draw.randrange(len(words))] = draw.choice(WORDS).encode()
            lines[at] = b" ".join(words)
        elif kind == 2:
            del lines[at : at + draw.randint(1, 5)]
            lines = lines or [b""]
        elif kind == 3:
            lines[to:to] = lines[at : at + draw.randint(1, 5)] * draw.choice((1, 1, 1, 300))
        elif kind == 4:
            lines[at], lines[to] = lines[to], lines[at]
        else:
            begin = draw.randrange(len(others))
            lines[at:at] = others[begin : begin + draw.randint(1, 20)]
    return b"\n".join(lines)


def damage_gltf(data: bytes, other: bytes, draw: Random) -> bytes:
    """Changes values anywhere in the document of a GLB or glTF file, and keeps the container right."""
    document, binary = read_document(data)
    for _ in range(draw.randint(1, 3)):
        damage_value(document, draw)
    text = json.dumps(document).encode()
    if data[:4] != MAGIC:
        return text
    if draw.random() < 0.1:
        binary = damage_bytes(binary, read_document(other)[1] or other, draw)
    length = HEAD.size + 2 * CHUNK.size + len(text) + len(binary)
    head = HEAD.pack(MAGIC, VERSION, length)
    return head + CHUNK.pack(len(text), b"JSON") + text + CHUNK.pack(len(binary), b"BIN\0") + binary


def damage_value(document: dict[str, Any], draw: Random) -> None:
    """Goes down into the document at random, so that rare parts are met as often as common ones; changes one value."""
    inside: Any = document
    while True:
        keys: list[Any] = list(inside) if isinstance(inside, dict) else list(range(len(inside)))
        key = draw.choice(keys)
        value = inside[key]
        if not (isinstance(value, dict | list) and value and draw.random() < 0.9):
            break
        inside = value
    kind = draw.randrange(8)
    if kind == 0:
        del inside[key]
        if not inside:
            inside.update({"": 0}) if isinstance(inside, dict) else inside.append(0)
    elif kind == 1 and isinstance(value, int | float):
        inside[key] = value + draw.choice((-1, 1, 2, 4, 1000))
    elif kind == 2 and isinstance(inside, list):
        inside.extend([value] * draw.choice((1, 3, 300)))
    elif kind == 3:
        inside[key] = inside[draw.choice(keys)]
    elif kind == 4:
        inside[key] = draw.randrange(40)
    else:
        inside[key] = json.loads(draw.choice(VALUES))
