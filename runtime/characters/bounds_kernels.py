"""Keeps kernels within their tables, whatever a row holds: counts of slots, sizes of groups, and numbers of clips."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.slots import action_slot, hands_slot, locomotion_slot
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import SPLICE
from motionsplice.runtime.kernels.posture import RUNNING
from motionsplice.runtime.simd.compiled import Array, inlined, kernel


@inlined
def keep_in_bounds(bank: BankArrays, s: Array, c: int) -> None:
    """Replaces what kernels use as an index or a count in a row, and is none. Changes no row that commands lead to.

    Positions between rows of a table are clamped where they are looked up.
    """
    last = len(bank.clips) - 1.0
    keep(s, c + col.LOCOMOTIONS, 0.0, col.MOST_LOCOMOTIONS)
    keep(s, c + col.ACTIONS, 0.0, col.MOST_ACTIONS)
    keep(s, c + col.STANDING, 0.0, 255.0)
    keep(s, locomotion_slot(c, 0) + col.CLIP, 0.0, last)  # is read even without a locomotion
    if s[c + col.LOCOMOTIONS] > 1.0 or s[locomotion_slot(c, 0) + col.HEAD] != 1.0:
        keep_groups(s, c, last)
    for number in range(int(s[c + col.ACTIONS])):
        keep_action(s, action_slot(c, number), last)
    if s[c + col.HANDS] != 0.0 or s[c + col.HANDS_WAIT] > 0.0:
        keep_hands(bank, s, c)
    if s[c + col.NEXT_COUNT] != 0.0:
        keep(s, c + col.NEXT_COUNT, 0.0, col.MOST_MIXED)
        for number in range(int(s[c + col.NEXT_COUNT])):
            keep(s, c + col.NEXT_CLIPS + number, 0.0, last)
    if s[c + col.WHEN] > col.NEVER:
        keep_action(s, c + col.NEXT_ACTION, last)


@inlined
def keep(s: Array, at: int, least: float, most: float) -> None:
    """Replaces a number that is not a whole one from least to most by the least; NaN too."""
    if not (least <= s[at] <= most and s[at] == np.floor(s[at])):
        s[at] = least


@kernel
def keep_groups(s: Array, c: int, last: float) -> None:
    """Keeps the numbers of clips of all locomotions, and the sizes of their groups, which follow on one another."""
    count, left = int(s[c + col.LOCOMOTIONS]), 0
    for number in range(count):
        slot = locomotion_slot(c, number)
        keep(s, slot + col.CLIP, 0.0, last)
        if left > 0:
            s[slot + col.HEAD] = 0.0
        else:
            keep(s, slot + col.HEAD, 1.0, min(col.MOST_MIXED, count - number))
            left = int(s[slot + col.HEAD])
        left -= 1


@inlined
def keep_action(s: Array, slot: int, last: float) -> None:
    keep(s, slot + col.CLIP, 0.0, last)
    keep(s, slot + col.KIND, 0.0, SPLICE)
    keep(s, slot + col.MASK, 0.0, col.UPPER_BODY)
    keep(s, slot + col.POSTURE, 0.0, RUNNING)


@kernel
def keep_hands(bank: BankArrays, s: Array, c: int) -> None:
    """Keeps the number of hands, and the numbers of those that are worn or wait."""
    last = len(bank.hand_rows) - 1.0
    keep(s, c + col.HANDS, 0.0, col.MOST_HANDS)
    for number in range(int(s[c + col.HANDS])):
        keep(s, hands_slot(c, number) + col.CLIP, col.BARE, last)
    keep(s, c + col.NEXT_HANDS + col.CLIP, col.BARE, last)
