"""Finds the rows of a bank that a later character is going to read.

Those of its first slots are prefetched while the characters before it are sampled (`kernels.fetching`), others at once.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.bounds_kernels import keep_in_bounds
from motionsplice.runtime.characters.half_kernels import is_added, row_of_action
from motionsplice.runtime.characters.slots import (
    action_slot,
    hands_slot,
    locomotion_slot,
)
from motionsplice.runtime.characters.upper_kernels import is_plain
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.fetching import fetch_rows
from motionsplice.runtime.kernels.lookup import fetch_hands
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.simd.compiled import Array, Index, inlined


@inlined
def fetch_slots(bank: BankArrays, s: Array, c: int) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Returns rows that are to be prefetched, and prefetches those of all further slots of a character.

    These are rows of the first locomotion's lower half, of the first action, and of the first locomotion's own upper
    half; one of the latter two in place of the other, if it is not needed. Keeps the character's row in bounds first.
    """
    keep_in_bounds(bank, s, c)
    own, lower = shows_own(bank, s, c), np.uint64(0)
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion_slot(c, number)
        clip = int(s[slot + col.CLIP])
        row, _ = row_of(bank, clip, s[slot + col.FRAME])
        if number == 0:
            lower = row
        else:
            fetch_rows(bank.lower, row)
            if own:
                fetch_rows(bank.upper, row)
        if own:
            fetch_worn(bank, s, c, clip, row)
    first = True
    upper = lower
    for number in range(int(s[c + col.ACTIONS])):
        slot = action_slot(c, number)
        if s[slot + col.KIND] != col.OWN:
            row, _ = row_of_action(bank, s, slot)
            if first:
                upper, first = row, False
            else:
                fetch_rows(bank.upper, row)
            fetch_worn(bank, s, c, int(s[slot + col.CLIP]), row)
    return lower, upper, lower if own else upper


@inlined
def shows_own(bank: BankArrays, s: Array, c: int) -> bool:
    """Whether the locomotions' own upper halves are likely to be sampled: no action covers all of them."""
    covered = False
    for number in range(int(s[c + col.ACTIONS])):
        slot = action_slot(c, number)
        if s[slot + col.KIND] == col.OWN or is_added(bank, s, slot):
            return True
        covered |= (
            s[slot + col.MASK] == col.UPPER_BODY
            and s[slot + col.ELAPSED] >= s[slot + col.LASTING]
            and s[slot + col.WEIGHT] == 1.0
        )
    return not covered


@inlined
def fetch_unlike(bank: BankArrays, s: Array, c: int, upper: Index, own: Index) -> None:
    """Prefetches what a character ahead reads, but this one does not, so that it would not prefetch it."""
    if upper != own:
        if s[c + col.ACTIONS] == 0.0:
            fetch_rows(bank.upper, upper)
        elif is_plain(s, c):
            fetch_rows(bank.upper, own)


@inlined
def fetch_worn(bank: BankArrays, s: Array, c: int, clip: int, row: Index) -> None:
    """Prefetches the rows of all hands that a character wears on a clip."""
    for number in range(int(s[c + col.HANDS])):
        fetch_hands(bank, int(s[hands_slot(c, number) + col.CLIP]), clip, row)
