"""Offsets of a character's slots, the fade of a slot, the origin of a pose, and the prefetch of a row.

In all kernels of characters, `s` is the flat state of all characters and `c` the offset of a character's row in it.
"""

from __future__ import annotations

import math

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.kernels.arrays import BLOCK
from motionsplice.runtime.simd.compiled import Array, inlined
from motionsplice.runtime.simd.prefetch import prefetch_at

# characters by which what they read of the bank is prefetched, so that waits and arithmetic overlap, and by which their
# rows are, so that it is known what they are going to read
AHEAD, FARTHER = 3, 7
# metres between origins: a float32 still tells 0.01 mm apart in the middle between two, and multiples are exact in it
ORIGINS_APART = 256.0
# all bits of an offset: masked by it, an offset is known not to be negative, so the compiler leaves out the check for
# counting from the end at each access
OFFSET, LANE = (1 << 60) - 1, BLOCK - 1  # and of a number of a lane


@inlined
def fetch_state(s: Array, c: int) -> None:
    """Prefetches what each frame reads of a character's row: the first columns and the first slots."""
    fetch_head(s, c)
    fetch_action(s, c)


@inlined
def fetch_head(s: Array, c: int) -> None:
    """Prefetches the first columns of a character's row and its first locomotion slot."""
    for column in range(0, col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS, col.LINE):
        prefetch_at(s, c + column)


@inlined
def fetch_action(s: Array, c: int) -> None:
    """Prefetches the first action slot of a character's row."""
    for column in range(col.FIRST_ACTION, col.FIRST_ACTION + col.REMEMBERED, col.LINE):
        prefetch_at(s, c + column)


@inlined
def row_at(character: int) -> int:
    """Returns the offset of a character's row."""
    return character * col.COLUMNS & OFFSET


@inlined
def locomotion_slot(c: int, number: int) -> int:
    """Returns the offset of locomotion slot `number`."""
    return (c + col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS) & OFFSET


@inlined
def action_slot(c: int, number: int) -> int:
    """Returns the offset of action slot `number`."""
    return (c + col.FIRST_ACTION + number * col.ACTION_COLUMNS) & OFFSET


@inlined
def hands_slot(c: int, number: int) -> int:
    """Returns the offset of hands slot `number`."""
    return (c + col.FIRST_HANDS + number * col.HANDS_COLUMNS) & OFFSET


@inlined
def origin_of(s: Array, c: int, axis: int) -> float:
    """Returns a coordinate of the origin that a character's pose is relative to, unless it plays in place."""
    if s[c + col.REBASED] == 0.0:
        return 0.0
    return ORIGINS_APART * math.floor(s[c + col.PLACE + axis] / ORIGINS_APART + 0.5)


@inlined
def fade_of(s: Array, slot: int) -> float:
    """Returns how far a slot is faded in, 0 to 1."""
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
