"""Lays the hands that a character wears over the upper half of a clip."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.slots import fade_of, hands_slot
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.hands import lay_hands
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel


@kernel
def wear_hands(bank: BankArrays, s: Array, c: int, clip: int, row: Index, t: Real, lanes: Array, above: Index) -> None:
    """Lays the hands that a character wears over the upper half of a clip, `t` of the way from row to the next.

    Each slot is mixed with the clip's own hands by its weight, and faded in over the slots below it. BARE slots, and
    hands that are not aligned to the clip, stand for the clip's own hands.
    """
    count = int(s[c + col.HANDS])
    for number in range(count):
        fade, given = fade_and_weight(bank, s, hands_slot(c, number), clip)
        weight = fade * given
        for over in range(number + 1, count):
            fade, covering = fade_and_weight(bank, s, hands_slot(c, over), clip)
            # laying the upper slot leaves 1 - fade * covering of this slot, where 1 - fade should be left
            weight *= (1.0 - fade) / (1.0 - fade * covering) if fade < 1.0 else 0.0
        if weight > 0.0:
            lay_hands(bank, int(s[hands_slot(c, number) + col.CLIP]), clip, row, t, np.float32(weight), lanes, above)


@inlined
def fade_and_weight(bank: BankArrays, s: Array, slot: int, clip: int) -> tuple[float, float]:
    """Returns the fade of a hands slot, and its weight on a clip: 0 if it is BARE or not aligned to the clip."""
    worn = int(s[slot + col.CLIP])
    lies = worn != col.BARE and bank.hand_rows[worn, clip] >= 0
    fade = fade_of(s, slot)
    return fade, s[slot + col.WEIGHT] if lies else 0.0
