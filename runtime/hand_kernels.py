"""Hands over the upper half of a body: rows that lie beside the body's own, of those joints that hands may drive.

As `runtime.kernels`: nothing here checks, allocates or holds the GIL.
"""

from __future__ import annotations

import numpy as np

from runtime import arrays
from runtime import character_state as col
from runtime.arrays import BankArrays
from runtime.compiled import Array, Index, Real, inlined, kernel
from runtime.lookup_kernels import row_of_hands
from runtime.rotation_kernels import ONE, sample
from runtime.transition_kernels import faded, hands


@inlined
def lay_hands(
    bank: BankArrays, worn: int, clip: int, row: Index, t: Real, weight: Real, lanes: Array, above: Index
) -> None:
    """Lays hands, as far as `weight` says, over the upper half at `above`, which is a clip's between row and the next.

    Where they are not aligned to the clip nothing is done. The lanes after the upper half's are room for them.
    """
    if bank.hand_rows[worn, clip] >= 0:
        width, at = bank.rig[arrays.HANDS_WIDTH], above + np.uint64(4) * bank.rig[arrays.UPPER_WIDTH]
        sample(bank.hands, row_of_hands(bank, worn, clip, row), np.uint64(0), width, t, lanes, at)
        for joint in range(np.uint64(len(bank.hand_lanes))):
            turn_to(lanes, above + bank.hand_lanes[joint], at, weight)
            at += np.uint64(4)


@inlined
def turn_to(lanes: Array, own: Index, other: Index, weight: Real) -> None:
    """A rotation in lanes, `weight` of the way to another, by the shorter way round."""
    b, c, d = ONE, ONE + ONE, ONE + ONE + ONE
    x, y, z, w = lanes[other], lanes[other + b], lanes[other + c], lanes[other + d]
    if weight < np.float32(1.0):
        ox, oy, oz, ow = lanes[own], lanes[own + b], lanes[own + c], lanes[own + d]
        near = (x * ox + y * oy) + (z * oz + w * ow)
        given, rest = weight if near >= np.float32(0.0) else -weight, np.float32(1.0) - weight
        x, y, z, w = rest * ox + given * x, rest * oy + given * y, rest * oz + given * z, rest * ow + given * w
        scale = np.float32(1.0) / np.sqrt(max((x * x + y * y) + (z * z + w * w), np.float32(1e-30)))
        x, y, z, w = scale * x, scale * y, scale * z, scale * w
    lanes[own], lanes[own + b], lanes[own + c], lanes[own + d] = x, y, z, w


@kernel
def wear_hands(bank: BankArrays, s: Array, c: int, clip: int, row: Index, t: Real, lanes: Array, above: Index) -> None:
    """Lays the hands that a character wears over the upper half of a clip that it plays, between row and the next.

    As they fade in they take the place of those below them, with whatever weight: what theirs leaves, hands that do not
    lie on the clip, and none, are the clip's own.
    """
    count = int(s[c + col.HANDS])
    for number in range(count):
        worn, weight = int(s[hands(c, number) + col.CLIP]), share_of(s, c, number, count)
        above_it = 0.0  # what those above give
        for over in range(number + 1, count):
            other = int(s[hands(c, over) + col.CLIP])
            if other != col.BARE and bank.hand_rows[other, clip] >= 0:
                above_it += share_of(s, c, over, count)
        if worn != col.BARE and weight > 0.0:
            lay_hands(bank, worn, clip, row, t, np.float32(weight / (1.0 - above_it)), lanes, above)


@inlined
def share_of(s: Array, c: int, number: int, count: int) -> float:
    """How much hands give of what is shown, of those that are worn."""
    share = risen(s, hands(c, number)) * s[hands(c, number) + col.WEIGHT]
    for over in range(number + 1, count):
        share *= 1.0 - risen(s, hands(c, over))
    return share


@inlined
def risen(s: Array, slot: int) -> float:
    """How far hands are faded in."""
    return faded(s[slot + col.ELAPSED], s[slot + col.LASTING], s[slot + col.CURVE])
