"""Mixes rotations in lanes, and clouds, by weight.

Sources are added to a sum one after the other, with a weight for each lane. Rotations are added along the shorter arc;
the sum is normalised at the end.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters.arrays import Mixing
from motionsplice.runtime.format.rows import CLOUD, SIZE
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import between_rows
from motionsplice.runtime.kernels.mirror import point_between
from motionsplice.runtime.kernels.posture import mixed
from motionsplice.runtime.kernels.rotations import FOUR
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.lanes import interleave, load, root, separate, signed, spread, store
from motionsplice.runtime.simd.width import LANES


@inlined
def set_lane_weights(weights: Array, width: Index, weight: Real) -> None:
    """Sets the same weight for all lanes."""
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        store(weights, 0, lane, spread(weight))


@inlined
def add_lanes(lanes: Array, first: Index, width: Index, mixing: Mixing, new: bool) -> None:
    """Adds weighted rotations to the sum, along the shorter arc; starts the sum if `new`."""
    weights, total = mixing.lane_weights, mixing.sum
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = separate(lanes, first + FOUR * lane)
        weight = load(weights, 0, lane)
        if new:
            x, y, z, w = weight * x, weight * y, weight * z, weight * w
        else:
            sx, sy, sz, sw = load(total, 0, lane), load(total, 1, lane), load(total, 2, lane), load(total, 3, lane)
            weight = signed(weight, (sx * x + sy * y) + (sz * z + sw * w))
            x, y, z, w = sx + weight * x, sy + weight * y, sz + weight * z, sw + weight * w
        store(total, 0, lane, x)
        store(total, 1, lane, y)
        store(total, 2, lane, z)
        store(total, 3, lane, w)


@inlined
def normalise_lanes(total: Array, first: Index, width: Index, out: Array) -> None:
    """Normalises a sum of rotations into lanes."""
    one, least = spread(np.float32(1.0)), spread(np.float32(1e-30))
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = load(total, 0, lane), load(total, 1, lane), load(total, 2, lane), load(total, 3, lane)
        scale = one / root(least + ((x * x + y * y) + (z * z + w * w)))
        interleave(out, first + FOUR * lane, x * scale, y * scale, z * scale, w * scale)


@inlined
def add_cloud(bank: BankArrays, row: Index, t: Real, weight: Real, mirrored: bool, total: Array, new: bool) -> None:
    """Adds the weighted cloud and size of a row of `lower` to `total`, a row of the same layout; starts it if `new`."""
    size = weight * between_rows(bank.lower, row, np.uint64(SIZE), t)
    total[0, SIZE] = size if new else total[0, SIZE] + size
    if mirrored:
        add_mirrored_cloud(bank, row, t, weight, total, new)
        return
    for column in range(
        np.uint64(CLOUD), np.uint64(CLOUD) + np.uint64(3) * bank.rig[arrays.CLOUD_WIDTH], np.uint64(LANES)
    ):
        value = spread(weight) * mixed(bank.lower, row, column, t)
        store(total, 0, column, value if new else value + load(total, 0, column))


@kernel
def add_mirrored_cloud(bank: BankArrays, row: Index, t: Real, weight: Real, total: Array, new: bool) -> None:
    """Adds the mirror image of the weighted cloud of a row of `lower` to `total`."""
    width = bank.rig[arrays.CLOUD_WIDTH]
    for point in range(bank.rig[arrays.POINTS]):
        column = np.uint64(CLOUD) + np.uint64(point)
        for value in point_between(bank, bank.lower, row, t, np.uint64(point), True):
            total[0, column] = weight * value if new else total[0, column] + weight * value
            column += width
