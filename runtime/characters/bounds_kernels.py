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
    waits = (s[c + col.NEXT_COUNT] != 0.0) | (s[c + col.WHEN] != 0.0) | (s[c + col.HANDS_WAIT] != 0.0)
    acts = (actions == 0.0) | (fits(s, action_slot(c, 0), last) & (actions == 1.0))
    if actions == 2.0:
        acts = fits(s, action_slot(c, 0), last) & fits(s, action_slot(c, 1), last)
    if waits | (s[c + col.HANDS] != 0.0) | (not acts) | (not one_or_two_fit(s, c, last)):
        keep_row(s, c, last, len(bank.hand_rows) - 1.0)


@inlined
def one_or_two_fit(s: Array, c: int, last: float) -> bool:
    """Whether a character plays one locomotion, or two of one group or of two, and their clips are in bounds."""
    first, second = locomotion_slot(c, 0), locomotion_slot(c, 1)
    if s[c + col.LOCOMOTIONS] == 1.0:
        return fits(s, first, last) & (s[first + col.HEAD] == 1.0)
    one, other = s[first + col.HEAD], s[second + col.HEAD]
    heads = ((one == 1.0) & (other == 1.0)) | ((one == 2.0) & (other == 0.0))
    return (s[c + col.LOCOMOTIONS] == 2.0) & heads & fits(s, first, last) & fits(s, second, last)


@inlined
def fits(s: Array, slot: int, last: float) -> bool:
    """Whether a slot's clip is in bounds."""
    return (s[slot + col.CLIP] >= 0.0) & (s[slot + col.CLIP] <= last)


@kernel
def keep_row(s: Array, c: int, last: float, last_hands: float) -> None:
    left = 0
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
        keep(s, hands_slot(c, number) + col.CLIP, col.BARE, last_hands)
    for number in range(int(s[c + col.NEXT_COUNT])):
        keep(s, c + col.NEXT_CLIPS + number, 0.0, last)
    if s[c + col.WHEN] > col.NEVER:
        keep(s, c + col.NEXT_ACTION + col.CLIP, 0.0, last)
    if s[c + col.HANDS_WAIT] > 0.0:
        keep(s, c + col.NEXT_HANDS + col.CLIP, col.BARE, last_hands)


@inlined
def keep(s: Array, at: int, least: float, most: float) -> None:
    """Replaces a number that is not a whole one from least to most by the least; NaN too."""
    if not (least <= s[at] <= most and s[at] == np.floor(s[at])):
        s[at] = least
