"""Where in the row of a character its slots begin, and how far a slot is faded in.

`s` is the flat state of all characters, and `c` is where the row of one of them begins.
"""

from __future__ import annotations

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.simd.compiled import Array, inlined


@inlined
def locomotion_slot(c: int, number: int) -> int:
    """Where slot `number` of the locomotions begins."""
    return c + col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS


@inlined
def action_slot(c: int, number: int) -> int:
    """Where slot `number` of the actions begins."""
    return c + col.FIRST_ACTION + number * col.ACTION_COLUMNS


@inlined
def hands_slot(c: int, number: int) -> int:
    """Where slot `number` of the hands begins."""
    return c + col.FIRST_HANDS + number * col.HANDS_COLUMNS


@inlined
def fade_of(s: Array, slot: int) -> float:
    """How far a slot is faded in, from 0 to 1."""
    elapsed, lasting, curve = s[slot + col.ELAPSED], s[slot + col.LASTING], s[slot + col.CURVE]
    if elapsed >= lasting:
        return 1.0
    t = elapsed / lasting
    if curve == col.SMOOTH:
        return t * t * (3.0 - 2.0 * t)
    if curve == col.EASE_IN:
        return t * t
    if curve == col.EASE_OUT:
        return t * (2.0 - t)
    return t
