"""How a splice's upper body comes to sit on its root: spatial alignment and posture, across a block of characters.

As `runtime.kernels`: nothing here checks, allocates or holds the GIL.
"""

from __future__ import annotations

import math

import numpy as np

from runtime import arrays
from runtime.arrays import (
    ALIGNED,
    BLOCK,
    BOUND,
    CORRELATION,
    FRAME,
    GAP,
    OWN,
    SPLICED,
    THEIRS,
    TURN,
    Array,
    BankArrays,
    MemoryArrays,
    Scratch,
)
from runtime.compiled import inlined
from runtime.lookup_kernels import SPLICE, between_rows
from runtime.rotation_kernels import ONE, horn, product, rotated
from runtime.rows import CLOUD, PELVIS, POSTURE_FRAME, TORSO_OFFSET

OFF, RELATIVE, ABSOLUTE, RUNNING = 0, 1, 2, 3  # postures
LEAST_GAP = 1e-4  # of horn: below it, clouds of 32 bits do not tell a rotation to a thousandth of a radian
BOUND_SHARE = 0.5 * (1.0 + 1e-6)  # a bound by as much too large as 32 bits may make it too small


@inlined
def correlate(bank: BankArrays, scratch: Scratch, thread: int, k: int) -> None:
    """What a block needs of a splice: how its clouds go together, its bound, and five of its rotations."""
    block, lower, upper = scratch.block[thread], bank.lower, bank.upper
    row_l, row_u = scratch.rows[thread, 0, k], scratch.rows[thread, 1, k]
    t_l, t_u = scratch.shares[thread, 0, k], scratch.shares[thread, 1, k]
    xx = xy = xz = yx = yy = yz = zx = zy = zz = squares = np.float32(0.0)
    for point in range(bank.rig[arrays.POINTS]):
        x = np.uint64(CLOUD) + point + point + point
        y, z = x + ONE, x + ONE + ONE
        lx, ux = between_rows(lower, row_l, x, t_l), between_rows(upper, row_u, x, t_u)
        ly, uy = between_rows(lower, row_l, y, t_l), between_rows(upper, row_u, y, t_u)
        lz, uz = between_rows(lower, row_l, z, t_l), between_rows(upper, row_u, z, t_u)
        xx, xy, xz = xx + lx * ux, xy + lx * uy, xz + lx * uz
        yx, yy, yz = yx + ly * ux, yy + ly * uy, yz + ly * uz
        zx, zy, zz = zx + lz * ux, zy + lz * uy, zz + lz * uz
        squares += lx * lx + ly * ly + lz * lz + ux * ux + uy * uy + uz * uz
    block[k], block[BLOCK + k], block[2 * BLOCK + k] = xx, xy, xz
    block[3 * BLOCK + k], block[4 * BLOCK + k], block[5 * BLOCK + k] = yx, yy, yz
    block[6 * BLOCK + k], block[7 * BLOCK + k], block[8 * BLOCK + k] = zx, zy, zz
    block[BOUND * BLOCK + k] = BOUND_SHARE * squares
    lanes_l, lanes_u = scratch.lanes[thread, 0], scratch.lanes[thread, 1]
    for i in range(4):
        block[(SPLICED + i) * BLOCK + k] = lanes_l[4 * PELVIS + i]
        block[(FRAME + i) * BLOCK + k] = lanes_l[4 * POSTURE_FRAME + i]
        block[(OWN + i) * BLOCK + k] = lanes_l[4 * TORSO_OFFSET + i]
        block[(THEIRS + i) * BLOCK + k] = lanes_u[4 * TORSO_OFFSET + i]


@inlined
def settle(requests: Array, memory: MemoryArrays, block: Array, first: int, count: int) -> None:
    """Where no alignment is clearly the best: the last one that was, if there is a memory; else none."""
    for k in range(count):
        if requests[first + k]["method"] == SPLICE:
            clear, remembered = block[GAP * BLOCK + k] >= LEAST_GAP, min(first + k, len(memory.turns) - 1)
            for i in range(4):
                at = (ALIGNED + i) * BLOCK + k
                if not clear:
                    block[at] = memory.turns[remembered, i] if remembered >= 0 else i // 3
                elif remembered >= 0:
                    memory.turns[remembered, i] = block[at]


@inlined
def other_postures(
    bank: BankArrays, requests: Array, memory: MemoryArrays, scratch: Scratch, thread: int, first: int, count: int
) -> None:
    """The turns of those splices whose posture is not relative."""
    block, turned = scratch.block[thread], 0
    for k in range(count):
        request = requests[first + k]
        if request["method"] != SPLICE or request["posture"] == RELATIVE:
            continue
        for i in range(4):
            block[(TURN + i) * BLOCK + k] = i // 3
        if request["posture"] != OFF:
            turned += 1
            remembered = min(first + k, len(memory.means) - 1)
            if request["posture"] == RUNNING:
                follow_posture(bank, memory.means[remembered], memory.share, request["locomotion"], scratch, thread, k)
            squares = 0.0
            for i in range(9):
                block[(CORRELATION + i) * BLOCK + k] = 0.0
            for point in range(2):
                for i in range(3):
                    wanted = bank.clips[request["action"], arrays.POSTURE + 3 * point + i]
                    squares += wanted * wanted
                    for j in range(3):
                        given = bank.clips[request["locomotion"], arrays.POSTURE + 3 * point + j]
                        if request["posture"] == RUNNING:
                            given = memory.means[remembered, point, j]
                        block[(CORRELATION + 3 * i + j) * BLOCK + k] += wanted * given
                        squares += given * given / 3.0
            block[BOUND * BLOCK + k] = BOUND_SHARE * squares
    if turned > 0:
        horn(block)
        for k in range(count):
            request = requests[first + k]
            clear = block[GAP * BLOCK + k] >= LEAST_GAP
            if (
                request["method"] == SPLICE
                and (request["posture"] == ABSOLUTE or request["posture"] == RUNNING)
                and clear
            ):
                for i in range(4):
                    block[(TURN + i) * BLOCK + k] = block[(ALIGNED + i) * BLOCK + k]


@inlined
def follow_posture(
    bank: BankArrays, mean: Array, share: float, clip_l: int, scratch: Scratch, thread: int, k: int
) -> None:
    """Takes the shoulders of the splice so far, as seen in the posture frame, into a running mean [2, 3]."""
    block, row, t = scratch.block[thread], scratch.rows[thread, 1, k], scratch.shares[thread, 1, k]
    frame, spliced = FRAME * BLOCK + k, SPLICED * BLOCK + k
    seen = product(
        -block[frame],
        -block[frame + BLOCK],
        -block[frame + 2 * BLOCK],
        block[frame + 3 * BLOCK],
        block[spliced],
        block[spliced + BLOCK],
        block[spliced + 2 * BLOCK],
        block[spliced + 3 * BLOCK],
    )
    first = np.uint64(CLOUD) + (ONE + ONE + ONE) * (bank.rig[arrays.POINTS] - ONE - ONE)
    for point in range(2):
        column = first + np.uint64(3 * point)
        x = between_rows(bank.upper, row, column, t)
        y = between_rows(bank.upper, row, column + ONE, t)
        z = between_rows(bank.upper, row, column + ONE + ONE, t)
        for i, value in enumerate(rotated(seen[0], seen[1], seen[2], seen[3], x, y, z)):
            if math.isnan(mean[point, i]):
                mean[point, i] = bank.clips[clip_l, arrays.POSTURE + 3 * point + i]
            mean[point, i] += share * (value - mean[point, i])
