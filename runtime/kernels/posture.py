"""Turns the pelvis of a splice: spatial alignment and posture transfer, across a block of characters."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.format.rows import CLOUD, PELVIS, POSTURE_FRAME, SIZE, TORSO_OFFSET
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import (
    ALIGNED,
    BLOCK,
    BOUND,
    CORRELATION,
    FRAME,
    GAP,
    OWN,
    ROW_L,
    ROW_U,
    SHARE_L,
    SHARE_U,
    SPLICED,
    THEIRS,
    TURN,
    BankArrays,
)
from motionsplice.runtime.kernels.lookup import SPLICE, as_index, between_rows, is_mirrored
from motionsplice.runtime.kernels.mirror import correlate_mirrored, point_between
from motionsplice.runtime.kernels.rotations import BACK, ONE, ONWARD, horn, multiply, normalise, product, rotated
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.lanes import copy_down, load, spread, store_down, total, totals
from motionsplice.runtime.simd.width import LANES

OFF, RELATIVE, ABSOLUTE, RUNNING = 0, 1, 2, 3  # postures
GIVEN = 4  # absolute, but relative to the mean in memory: characters mix the postures of mixed locomotions there
LEAST_GAP = 1e-3  # of horn: below it, float32 clouds do not determine a rotation to 1e-4 radians
SLACK = 1.0 + 1e-6  # allows for rounding of a bound


@inlined
def correlate(
    bank: BankArrays,
    lower: Array,
    mirrored_l: bool,
    mirrored_u: bool,
    block: Array,
    k: int,
    lanes: Array,
    above: Index,
) -> None:
    """Writes a splice into lane k of the block: the correlation of its clouds, its bound, and four rotations.

    mirrored_l, mirrored_u: whether the clouds of the locomotion and of the action are to be mirrored.
    """
    row_l, t_l = as_index(block[ROW_L * BLOCK + k]), np.float32(block[SHARE_L * BLOCK + k])
    row_u, t_u = as_index(block[ROW_U * BLOCK + k]), np.float32(block[SHARE_U * BLOCK + k])
    if mirrored_l or mirrored_u:
        correlate_mirrored(bank, lower, row_l, t_l, mirrored_l, row_u, t_u, mirrored_u, block, k)
    else:
        correlate_clouds(bank, lower, row_l, t_l, row_u, t_u, block, k)
    # the square of a mean is at most the mean of squares
    size_l = between_rows(lower, row_l, np.uint64(SIZE), t_l)
    size_u = between_rows(bank.upper, row_u, np.uint64(SIZE), t_u)
    block[BOUND * BLOCK + k] = SLACK * (size_l + size_u)
    copy_down(lanes, np.uint64(4 * PELVIS), block, SPLICED * BLOCK + k, BLOCK)
    copy_down(lanes, np.uint64(4 * POSTURE_FRAME), block, FRAME * BLOCK + k, BLOCK)
    copy_down(lanes, np.uint64(4 * TORSO_OFFSET), block, OWN * BLOCK + k, BLOCK)
    copy_down(lanes, above + np.uint64(4 * TORSO_OFFSET), block, THEIRS * BLOCK + k, BLOCK)


@inlined
def correlate_clouds(
    bank: BankArrays, lower: Array, row_l: Index, t_l: Real, row_u: Index, t_u: Real, block: Array, k: int
) -> None:
    """Writes the correlation of two clouds, each between a row and the next, into lane k of the block."""
    width, first, after = bank.rig[arrays.CLOUD_WIDTH], np.uint64(CLOUD), np.uint64(CLOUD + LANES)
    lx, ly, lz = points_between(lower, row_l, first, width, t_l)
    ux, uy, uz = points_between(bank.upper, row_u, first, width, t_u)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = lx * ux, lx * uy, lx * uz, ly * ux, ly * uy, ly * uz, lz * ux, lz * uy, lz * uz
    for x in range(after, first + width, np.uint64(LANES)):
        lx, ly, lz = points_between(lower, row_l, x, width, t_l)
        ux, uy, uz = points_between(bank.upper, row_u, x, width, t_u)
        xx, xy, xz = xx + lx * ux, xy + lx * uy, xz + lx * uz
        yx, yy, yz = yx + ly * ux, yy + ly * uy, yz + ly * uz
        zx, zy, zz = zx + lz * ux, zy + lz * uy, zz + lz * uz
    at = CORRELATION * BLOCK + k
    store_down(block, at, BLOCK, totals(xx, xy, xz, yx, yy, yz, zx, zy))
    block[at + 8 * BLOCK] = total(zz)


@inlined
def points_between(table: Array, row: Index, x: Index, width: Index, t: Real) -> tuple[Array, Array, Array]:
    """Interpolates eight points `t` of the way from a row to the next; x is the column of the first one's x."""
    return mixed(table, row, x, t), mixed(table, row, x + width, t), mixed(table, row, x + width + width, t)


@inlined
def mixed(table: Array, row: Index, column: Index, t: Real) -> Array:
    """Interpolates eight neighbouring columns `t` of the way from a row to the next."""
    here, there = load(table, row, column), load(table, row + ONE, column)
    return here + spread(t) * (there - here)


@inlined
def turn_pelves(
    bank: BankArrays, requests: Array, memory: Array, share: float, block: Array, first: int, count: int
) -> None:
    """Turns the pelvis of each splice of a block, in SPLICED: from the locomotion's rotation to the splice's."""
    horn(block)
    hold_unclear_alignments(bank, requests, memory, block, first, count)
    multiply(block, SPLICED, ALIGNED, SPLICED, ONWARD)
    multiply(block, THEIRS, OWN, TURN, BACK)
    other_postures(bank, requests, memory, share, block, first, count)
    multiply(block, FRAME, TURN, TURN, ONWARD)
    multiply(block, TURN, FRAME, TURN, BACK)
    multiply(block, TURN, SPLICED, SPLICED, ONWARD)
    normalise(block, SPLICED)


@inlined
def is_aligned(bank: BankArrays, request: Array) -> bool:
    """Whether a request's action is laid on the locomotion by its shoulders: spliced, and not added to a stance."""
    return request["method"] == SPLICE and not (
        request["posture"] == RELATIVE and bank.clips[request["action"], arrays.STANCE] >= 0.0
    )


@kernel
def hold_unclear_alignments(
    bank: BankArrays, requests: Array, memory: Array, block: Array, first: int, count: int
) -> None:
    """Replaces alignments that are not clearly the best by the last clear one in memory, or by the identity."""
    for k in range(count):
        if requests[first + k]["method"] == SPLICE:
            clear, remembered = block[GAP * BLOCK + k] >= LEAST_GAP, min(first + k, len(memory) - 1)
            for i in range(4):
                at, last = (ALIGNED + i) * BLOCK + k, arrays.LAST_TURN + i
                if not clear:
                    block[at] = memory[remembered, last] if remembered >= 0 else i // 3
                elif remembered >= 0 and is_aligned(bank, requests[first + k]):
                    memory[remembered, last] = block[at]


@kernel
def other_postures(
    bank: BankArrays, requests: Array, memory: Array, share: float, block: Array, first: int, count: int
) -> None:
    """Writes the posture turns, TURN, of splices whose posture is not relative."""
    turned = 0
    for k in range(count):
        request = requests[first + k]
        if request["method"] == SPLICE and request["posture"] != RELATIVE:
            for i in range(4):
                block[(TURN + i) * BLOCK + k] = i // 3
            if request["posture"] != OFF:
                turned += 1
                given, remembered = bank.clips[request["locomotion"], arrays.POSTURE :], first + k
                if request["posture"] >= RUNNING:
                    remembered = min(first + k, len(memory) - 1)
                    if request["posture"] == RUNNING:
                        mirrored = is_mirrored(bank, request["action"])
                        mean = memory[remembered, arrays.MEAN_POSTURE :]
                        follow_posture(bank, mean, share, given, mirrored, block, k)
                    given = memory[remembered, arrays.MEAN_POSTURE :]
                correlate_postures(bank.clips[request["action"], arrays.POSTURE :], given, block, k)
    if turned > 0:
        horn(block)
        for k in range(count):
            request = requests[first + k]
            clear, asked = block[GAP * BLOCK + k] >= LEAST_GAP, request["posture"] >= ABSOLUTE
            if request["method"] == SPLICE and asked and clear:
                for i in range(4):
                    block[(TURN + i) * BLOCK + k] = block[(ALIGNED + i) * BLOCK + k]


@inlined
def correlate_postures(wanted: Array, given: Array, block: Array, k: int) -> None:
    """Writes the correlation of two postures, six numbers each, and its bound into lane k of the block."""
    at, size = CORRELATION * BLOCK + k, 0.0
    for i in range(3):
        for j in range(3):
            block[at + (3 * i + j) * BLOCK] = wanted[i] * given[j] + wanted[3 + i] * given[3 + j]
    for i in range(6):
        size += 0.5 * (wanted[i] * wanted[i] + given[i] * given[i])
    block[BOUND * BLOCK + k] = SLACK * size


@inlined
def follow_posture(
    bank: BankArrays, mean: Array, share: float, stored: Array, mirrored: bool, block: Array, k: int
) -> None:
    """Updates a running mean of six numbers by the splice's shoulders in the posture frame."""
    row, t = as_index(block[ROW_U * BLOCK + k]), np.float32(block[SHARE_U * BLOCK + k])
    frame, spliced = FRAME * BLOCK + k, SPLICED * BLOCK + k
    turn = product(
        -block[frame],
        -block[frame + BLOCK],
        -block[frame + 2 * BLOCK],
        block[frame + 3 * BLOCK],
        block[spliced],
        block[spliced + BLOCK],
        block[spliced + 2 * BLOCK],
        block[spliced + 3 * BLOCK],
    )
    shoulders = bank.rig[arrays.POINTS] - ONE - ONE  # the last two points
    for point in range(2):
        x, y, z = point_between(bank, bank.upper, row, t, shoulders + np.uint64(point), mirrored)
        for i, value in enumerate(rotated(turn[0], turn[1], turn[2], turn[3], x, y, z)):
            if math.isnan(mean[3 * point + i]):
                mean[3 * point + i] = stored[3 * point + i]
            mean[3 * point + i] += share * (value - mean[3 * point + i])
