"""Tables of banks with sound digests: headers of the npy format by its grammar, and contents that are damaged."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from bench.hostile.damage import damage_bytes
from motionsplice.runtime.format.manifest import TABLES
from tests.hardening.fuzz.banks import body_with, manifest_of, small_tables, use_bank
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw

MAGIC, LENGTH = b"\x93NUMPY", struct.Struct("<H")
HEADER = re.compile(rb"\{'descr': '(?P<descr>[^']*)', 'fortran_order': False, 'shape': \((?P<shape>[^)]*)\), \}")
KINDS = ("<f4", "<f8", ">f8", "|u1", "<i4", "|O", "<U5", "|V8", "<f2", "<c16", "<M8[s]", "f4,f4", "x", "<f99999999")
SHAPES = (
    *("(0,)", "()", "(-1,)", "(1,)", "(2, 3)", "(1, 2, 3, 4)", "(9" + "9" * 30 + ",)", "(3.0,)", "('a',)", "(True,)"),
    *("(4294967296, 4294967296)", "(" + "1, " * 40 + ")", "[1]", "None", "(1", "(-1, 6)", "(0, 4)"),
)
TEXTS = ("", "{", "{}", "'x' * 9", "(" * 500, "{'a': 1}", "[]", "1e999", "\x00", "__import__('os')", "{'descr': " * 80)
SIZES = {"<f4": 4, "<f8": 8, "<i4": 4, "|u1": 1}


def _header(draw: Draw, text: bytes) -> bytes:
    match = HEADER.match(text)
    if match is None:  # it was changed before
        return text
    kind, shape = match["descr"].decode(), f"({match['shape'].decode()})"
    kind = draw.choice(KINDS) if draw.rarely(2) else kind
    shape = draw.choice(SHAPES) if draw.rarely(2) else shape
    order = draw.choice(("True", "0", "None")) if draw.rarely(8) else "False"
    more = draw.choice((", 'x': 1", ", 'descr': '<f4'", " # }")) if draw.rarely(12) else ""
    made = f"{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}{more}, }}"
    if draw.rarely(12):
        made = draw.choice((made[: draw.randrange(len(made))], *TEXTS, made * 120))
    return made.encode() + b" " * (-len(made) % 64) + b"\n"


def _table(draw: Draw, data: bytes) -> bytes:
    (size,) = LENGTH.unpack_from(data, 8)
    header, contents = data[10 : 10 + size], data[10 + size :]
    if draw.randrange(2):
        header = _header(draw, header)
    if draw.randrange(2) and contents:
        contents = damage_bytes(contents, contents, draw)
    if draw.rarely(12):
        contents = draw.choice((b"", contents * 2, contents + b"\0", contents[:-1], bytes(300_000)))
    version = draw.choice((b"\x02\x00", b"\x03\x00", b"\x00\x01", b"\xff\xff")) if draw.rarely(12) else b"\x01\x00"
    length = LENGTH.pack(draw.choice((0, 1, 65535, len(header) - 1)) if draw.rarely(20) else min(len(header), 65535))
    return MAGIC + version + length + header + contents


def make(draw: Draw) -> Files:
    """Returns one or two tables that are not those of the small bank."""
    tables: dict[str, bytes] = {}
    for _ in range(draw.choice((0, 1, 1, 2))):
        name = draw.choice(tuple(TABLES))
        tables[name] = _table(draw, tables.get(name, small_tables()[name]))
    return tables


def enter(files: Files, folder: Path) -> None:
    """Uses the small bank with these tables."""
    use_bank(folder, manifest_of(body_with(files)), files)


EARLY = re.compile(".*(is cut short or not an array|is missing)")
DOOR = Door(make, enter, EARLY)
