"""Mirrors what was sampled from a clip: rotations in lanes, and points of its cloud."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.format.rows import CLOUD
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, CORRELATION, BankArrays
from motionsplice.runtime.kernels.lookup import between_rows
from motionsplice.runtime.kernels.rotations import FOUR, ONE
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel


@inlined
def mirror_lower(bank: BankArrays, lanes: Array) -> None:
    """Mirrors the sampled lower half."""
    mirror_lanes(bank, lanes, np.uint64(0), np.uint64(0), bank.rig[arrays.LOWER_WIDTH])


@inlined
def mirror_upper(bank: BankArrays, lanes: Array, above: Index) -> None:
    """Mirrors the sampled upper half, which begins at `above`."""
    mirror_lanes(bank, lanes, above, bank.rig[arrays.LOWER_WIDTH], bank.rig[arrays.UPPER_WIDTH])


@kernel
def mirror_lanes(bank: BankArrays, lanes: Array, at: Index, first: Index, width: Index) -> None:
    """Mirrors a sampled half of `width` lanes from `at` on; `first` is its first row in the table `mirror`."""
    spare, mirror = FOUR * bank.rig[arrays.SPARE], bank.mirror
    for number in range(FOUR * width):
        lanes[spare + number] = lanes[at + number]
    for lane in range(width):
        row = first + lane
        twin = spare + FOUR * np.uint64(mirror[row, arrays.TWIN])
        x, y, z, w = lanes[twin], lanes[twin + ONE], lanes[twin + ONE + ONE], lanes[twin + ONE + ONE + ONE]
        for i in range(FOUR):
            column = np.uint64(arrays.MATRIX) + FOUR * i
            xy = mirror[row, column] * x + mirror[row, column + ONE] * y
            zw = mirror[row, column + ONE + ONE] * z + mirror[row, column + ONE + ONE + ONE] * w
            lanes[at + FOUR * lane + i] = xy + zw


@kernel
def correlate_mirrored(
    bank: BankArrays,
    lower: Array,
    row_l: Index,
    t_l: Real,
    mirrored_l: bool,
    row_u: Index,
    t_u: Real,
    mirrored_u: bool,
    block: Array,
    k: int,
) -> None:
    """Writes the correlation of two clouds, either of which may be mirrored, into lane k of the block."""
    for i in range(9):
        block[(CORRELATION + i) * BLOCK + k] = 0.0
    for point in range(bank.rig[arrays.POINTS]):
        theirs = point_between(bank, bank.upper, row_u, t_u, point, mirrored_u)
        for i, own in enumerate(point_between(bank, lower, row_l, t_l, point, mirrored_l)):
            for j, other in enumerate(theirs):
                block[(CORRELATION + 3 * i + j) * BLOCK + k] += own * other


@inlined
def point_between(
    bank: BankArrays, table: Array, row: Index, t: Real, point: Index, mirrored: bool
) -> tuple[Real, Real, Real]:
    """Interpolates a point of the upper cloud `t` of the way from a row to the next, and mirrors it if asked.

    The last two points, the shoulders, are each other's twins.
    """
    width, count, own = bank.rig[arrays.CLOUD_WIDTH], bank.rig[arrays.POINTS], np.uint64(point)
    if mirrored and own + ONE + ONE >= count:
        own = count + count - ONE - ONE - ONE - own
    x = between_rows(table, row, np.uint64(CLOUD) + own, t)
    y = between_rows(table, row, np.uint64(CLOUD) + width + own, t)
    z = between_rows(table, row, np.uint64(CLOUD) + width + width + own, t)
    if not mirrored:
        return x, y, z
    m, last = bank.mirror, np.uint64(len(bank.mirror)) - ONE
    a, b, c = np.uint64(arrays.MATRIX), np.uint64(arrays.MATRIX + 3), np.uint64(arrays.MATRIX + 6)
    return (
        m[last, a] * x + m[last, a + ONE] * y + m[last, a + ONE + ONE] * z,
        m[last, b] * x + m[last, b + ONE] * y + m[last, b + ONE + ONE] * z,
        m[last, c] * x + m[last, c + ONE] * y + m[last, c + ONE + ONE] * z,
    )
