"""Lays hands over the upper half of a body. Row by row, the table `hands` goes with the rows of the body."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import row_of_hands
from motionsplice.runtime.kernels.rotations import ONE, sample
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined


@inlined
def lay_hands(
    bank: BankArrays, worn: int, clip: int, row: Index, t: Real, weight: Real, lanes: Array, above: Index
) -> None:
    """Blends hands over the upper half at `above`, which was sampled from a clip `t` of the way from row to the next.

    Does nothing if the hands `worn` are not aligned to the clip. The lanes after the upper half are scratch memory.
    """
    if bank.hand_rows[worn, clip] >= 0:
        width, at = bank.rig[arrays.HANDS_WIDTH], above + np.uint64(4) * bank.rig[arrays.UPPER_WIDTH]
        sample(bank.hands, row_of_hands(bank, worn, clip, row), np.uint64(0), width, t, lanes, at)
        count = np.uint64(len(bank.rig))
        for joint in range(count - bank.rig[arrays.HANDS_COUNT], count):
            turn_to(lanes, above + bank.rig[joint], at, weight)
            at += np.uint64(4)


@inlined
def turn_to(lanes: Array, own: Index, other: Index, weight: Real) -> None:
    """Blends a rotation in lanes towards another, along the shorter arc."""
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
