"""Keeps kernels within their tables, whatever a row holds: counts of slots, sizes of groups, and numbers of clips.

Positions between rows of a table are clamped where they are looked up; other columns are no indices.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.slots import action_slot, hands_slot, locomotion_slot
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.simd.compiled import Array, inlined, kernel


@inlined
def keep_in_bounds(bank: BankArrays, s: Array, c: int) -> None:
    """Replaces what kernels use as an index or a count in a row, and is none. Changes no row that commands lead to."""
    last, actions = len(bank.clips) - 1.0, s[c + col.ACTIONS]
    clip, above = s[locomotion_slot(c, 0) + col.CLIP], s[action_slot(c, 0) + col.CLIP]
    acts = (actions == 0.0) | ((actions == 1.0) & (above >= 0.0) & (above <= last))
    waits = (s[c + col.NEXT_COUNT] != 0.0) | (s[c + col.WHEN] != 0.0) | (s[c + col.HANDS_WAIT] != 0.0)
    alone = (s[c + col.LOCOMOTIONS] == 1.0) & (s[locomotion_slot(c, 0) + col.HEAD] == 1.0)
    usual = alone & (clip >= 0.0) & (clip <= last) & acts & (s[c + col.HANDS] == 0.0)
    if waits | (not usual):
        keep_row(bank, s, c)


@kernel
def keep_row(bank: BankArrays, s: Array, c: int) -> None:
    last, left = len(bank.clips) - 1.0, 0
    keep(s, c + col.LOCOMOTIONS, 0.0, col.MOST_LOCOMOTIONS)
    keep(s, c + col.ACTIONS, 0.0, col.MOST_ACTIONS)
    keep(s, c + col.HANDS, 0.0, col.MOST_HANDS)
    keep(s, c + col.NEXT_COUNT, 0.0, col.MOST_MIXED)
    keep(s, locomotion_slot(c, 0) + col.CLIP, 0.0, last)  # is read even without a locomotion
    count = int(s[c + col.LOCOMOTIONS])
    for number in range(count):
        slot = locomotion_slot(c, number)
        keep(s, slot + col.CLIP, 0.0, last)
        if left > 0:
            s[slot + col.HEAD] = 0.0
        else:
            keep(s, slot + col.HEAD, 1.0, min(col.MOST_MIXED, count - number))
            left = int(s[slot + col.HEAD])
        left -= 1
    for number in range(int(s[c + col.ACTIONS])):
        keep(s, action_slot(c, number) + col.CLIP, 0.0, last)
    for number in range(int(s[c + col.HANDS])):
        keep(s, hands_slot(c, number) + col.CLIP, col.BARE, len(bank.hand_rows) - 1.0)
    for number in range(int(s[c + col.NEXT_COUNT])):
        keep(s, c + col.NEXT_CLIPS + number, 0.0, last)
    if s[c + col.WHEN] > col.NEVER:
        keep(s, c + col.NEXT_ACTION + col.CLIP, 0.0, last)
    if s[c + col.HANDS_WAIT] > 0.0:
        keep(s, c + col.NEXT_HANDS + col.CLIP, col.BARE, len(bank.hand_rows) - 1.0)


@inlined
def keep(s: Array, at: int, least: float, most: float) -> None:
    """Replaces a number that is not a whole one from least to most by the least; NaN too."""
    if not (least <= s[at] <= most and s[at] == np.floor(s[at])):
        s[at] = least
