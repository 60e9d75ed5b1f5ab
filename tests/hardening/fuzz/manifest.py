"""Manifests of banks with sound digests: values of any kind anywhere in the body, and damage to its bytes."""

from __future__ import annotations

import re
from pathlib import Path

import msgpack

from bench.hostile.damage import damage_bytes, damage_value
from motionsplice.runtime.format.manifest import MANIFEST
from tests.hardening.fuzz.banks import manifest_of, small_body, use_bank
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw

LARGEST = 2**64 - 1
BULK = (b"\x90", b"\x80", b"\xc0", b"\x91", b"\xa0", b"\x93\x90\x90\x90", b"\xc4\x00", b"\x81\xa1a")


def _whole(number: int) -> int:
    """Returns a whole number that MessagePack can hold, in place of one that it cannot."""
    return min(max(number, -(2**63)), LARGEST)


def make(draw: Draw) -> Files:
    """Returns a manifest."""
    body = small_body()
    for _ in range(draw.choice((0, 1, 1, 1, 2, 3))):
        damage_value(body, draw)
    packed = msgpack.packb(body, default=_whole, unicode_errors="surrogatepass")
    if draw.rarely(8):
        packed = damage_bytes(packed, packed, draw)
    if draw.rarely(30):
        at, piece = draw.randrange(len(packed) + 1), draw.choice(BULK)
        packed = packed[:at] + piece * draw.choice((2, 100, 30_000)) + packed[at:]
    manifest = manifest_of(packed)
    return {MANIFEST: damage_bytes(manifest, packed, draw) if draw.rarely(60) else manifest}


def enter(files: Files, folder: Path) -> None:
    """Uses the bank of this manifest."""
    use_bank(folder, files[MANIFEST], {})


EARLY = re.compile("the manifest is cut short|expected version|the manifest was altered|the manifest is not a map")
DOOR = Door(make, enter, EARLY)
