"""Hands over the upper half of a body: rows that lie beside the body's own, of those joints that hands may drive."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.transition_kernels import faded, hands
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import row_of_hands
from motionsplice.runtime.kernels.rotations import ONE, sample
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel


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

    Each are mixed with the clip's own by their weight, and faded in over those below them. Hands that do not lie on the
    clip, and none, are the clip's own.
    """
    count = int(s[c + col.HANDS])
    for number in range(count):
        risen, given = shown(bank, s, hands(c, number), clip)
        weight = risen * given
        for over in range(number + 1, count):
            risen, covering = shown(bank, s, hands(c, over), clip)
            # what is laid over them leaves 1 - risen * covering of them, where 1 - risen should be left
            weight *= (1.0 - risen) / (1.0 - risen * covering) if risen < 1.0 else 0.0
        if weight > 0.0:
            lay_hands(bank, int(s[hands(c, number) + col.CLIP]), clip, row, t, np.float32(weight), lanes, above)


@inlined
def shown(bank: BankArrays, s: Array, slot: int, clip: int) -> tuple[float, float]:
    """How far hands are faded in, and how much of them is then shown on a clip."""
    worn = int(s[slot + col.CLIP])
    lies = worn != col.BARE and bank.hand_rows[worn, clip] >= 0
    risen = faded(s[slot + col.ELAPSED], s[slot + col.LASTING], s[slot + col.CURVE])
    return risen, s[slot + col.WEIGHT] if lies else 0.0
