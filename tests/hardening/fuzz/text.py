"""What generators of text files share: numbers, repeated lines, encodings and damage."""

from __future__ import annotations

from collections.abc import Sequence

from bench.hostile.damage import WORDS, damage_bytes, damage_text
from tests.hardening.fuzz.draw import Draw

ENCODINGS = ("utf-8-sig", "utf-16", "cp932", "gb18030", "latin-1", "utf-16-le")
LARGE = 600  # bytes that a part may be repeated to


def odd_number(draw: Draw) -> str:
    """Returns a number as text, or none."""
    return draw.choice((str(draw.uniform(-1e3, 1e3)), str(draw.randint(-9, 9)), "1,5", "1e9", *WORDS))


def number(draw: Draw, sound: str) -> str:
    """Returns a number as text, rarely another or none."""
    return odd_number(draw) if draw.rarely(40) else sound


def repeated(draw: Draw, piece: list[str]) -> list[str]:
    """Returns lines more than once."""
    return piece * min(draw.choice((2, 30, 1000)), 2 + LARGE // (1 + sum(map(len, piece))))


def encoded(draw: Draw, lines: Sequence[str], ending: str = "\n") -> bytes:
    """Returns the bytes of a text, rarely in an unusual encoding, damaged or cut short."""
    encoding = draw.choice(ENCODINGS) if draw.rarely(12) else "utf-8"
    data = ("\n".join(lines) + ending).encode(encoding, "replace")
    if draw.rarely(6):
        data = draw.choice((damage_text, damage_text, damage_bytes))(data, data, draw)
    return data[: draw.randrange(len(data))] if data and draw.rarely(30) else data
