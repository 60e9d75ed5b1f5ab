"""Rotations in kernels: sampling of rows, and products and best fits across a block of characters.

A block is a flat array of rows of BLOCK lanes, one lane for each character. The compiler knows the offsets of rows, so
it vectorises loops over lanes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from motionsplice.runtime.kernels.arrays import ALIGNED, BLOCK, BOUND, CORRELATION, GAP
from motionsplice.runtime.kernels.fetching import fetch_rotations
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.lanes import interleave, load, spread, store
from motionsplice.runtime.simd.width import LANES

Number = Any  # a float, or lanes
Coefficients = tuple[Array, Array, Array, Array, Array]  # of a polynomial, each in all lanes
ONWARD, BACK = 1.0, -1.0  # a rotation, or its inverse
ONE, FOUR = np.uint64(1), np.uint64(4)  # a column; the numbers of a rotation
TINY = 1e-300
# Eberly 2011: sin(t angle) / sin(angle) as a series in cos(angle) - 1, cut after four terms
SERIES = [(np.float32(1.0 / (i * (2 * i + 1))), np.float32(i / (2 * i + 1))) for i in range(1, 5)]
(P1, Q1), (P2, Q2), (P3, Q3), (P4, Q4) = SERIES
HALLEY_STEPS = 4
# rows of the block while roots are found: coefficients of polynomials, their largest roots, and the last steps
SQUARES, LINEAR, CONSTANT, ROOT, STEP = ALIGNED, ALIGNED + 1, ALIGNED + 2, ALIGNED + 3, GAP
SETTLED = 0.01  # largest last step, relative to the distance to the second root: the next is about its cube


@inlined
def sample(table: Array, row: Index, first: Index, width: Index, t: Real, out: Array, at: Index) -> None:
    """Writes all rotations of a row, `t` of the way to the next row, into `out` from `at` on, one after the other.

    first is the column of the first plane. Both keys lie in one hemisphere, so slerp can be Eberly's series (2011). Its
    error grows with the angle between the keys: 2e-7 rad at 60 degrees, 1e-5 at 90, 1e-3 (0.05 degrees) at 150, and
    0.0051 (0.3 degrees) at 180, the largest angle there can be. The result is nearly of unit length; one Newton step
    normalises it.
    """
    to, back = series(t), series(np.float32(1.0) - t)
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = sampled(table, row, first + lane, width, to, back)
        interleave(out, at + FOUR * lane, x, y, z, w)


@inlined
def sample_and_fetch(
    table: Array, row: Index, ahead: Index, first: Index, width: Index, t: Real, out: Array, at: Index
) -> None:
    """As `sample`; meanwhile prefetches the rotations of the row `ahead` and the next one."""
    to, back = series(t), series(np.float32(1.0) - t)
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        fetch_rotations(table, ahead, first, lane)
        x, y, z, w = sampled(table, row, first + lane, width, to, back)
        interleave(out, at + FOUR * lane, x, y, z, w)


@inlined
def sample_planes(
    table: Array, row: Index, ahead: Index, first: Index, width: Index, t: Real, planes: Array, plane: Index
) -> None:
    """As `sample_and_fetch`, but writes all x into the row `plane` of `planes`, all y into the next, and so on."""
    to, back = series(t), series(np.float32(1.0) - t)
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        fetch_rotations(table, ahead, first, lane)
        x, y, z, w = sampled(table, row, first + lane, width, to, back)
        store_planes(planes, plane, lane, x, y, z, w)


@inlined
def store_planes(planes: Array, plane: Index, lane: Index, x: Array, y: Array, z: Array, w: Array) -> None:
    """Stores eight rotations in four rows from `plane` on, at the column `lane`."""
    store(planes, plane, lane, x)
    store(planes, plane + ONE, lane, y)
    store(planes, plane + ONE + ONE, lane, z)
    store(planes, plane + ONE + ONE + ONE, lane, w)


@inlined
def sampled(
    table: Array, row: Index, x: Index, width: Index, to: Coefficients, back: Coefficients
) -> tuple[Array, Array, Array, Array]:
    """Returns eight rotations of a row on the way to the next; x is the column of the first one's x."""
    one, half, three_halves = spread(np.float32(1.0)), spread(np.float32(0.5)), spread(np.float32(1.5))
    after, y, z, w = row + ONE, x + width, x + width + width, x + width + width + width
    ax, bx = load(table, row, x), load(table, after, x)
    ay, by = load(table, row, y), load(table, after, y)
    az, bz = load(table, row, z), load(table, after, z)
    aw, bw = load(table, row, w), load(table, after, w)
    below = (ax * bx + ay * by) + (az * bz + (aw * bw - one))
    square = below * below
    t = (to[0] + to[1] * below) + square * ((to[2] + to[3] * below) + to[4] * square)
    s = (back[0] + back[1] * below) + square * ((back[2] + back[3] * below) + back[4] * square)
    qx, qy, qz, qw = s * ax + t * bx, s * ay + t * by, s * az + t * bz, s * aw + t * bw
    scale = three_halves - half * ((qx * qx + qy * qy) + (qz * qz + qw * qw))
    return qx * scale, qy * scale, qz * scale, qw * scale


@inlined
def series(t: Real) -> Coefficients:
    """Returns a key's weight at `t` as coefficients of a polynomial in cos(angle) - 1, each in all lanes."""
    square = t * t
    t1 = t * (P1 * square - Q1)
    t2 = t1 * (P2 * square - Q2)
    t3 = t2 * (P3 * square - Q3)
    return spread(t), spread(t1), spread(t2), spread(t3), spread(t3 * (P4 * square - Q4))


@inlined
def quaternion_in(lanes: Array, at: Index) -> tuple[Real, Real, Real, Real]:
    """Returns a rotation in lanes."""
    return lanes[at], lanes[at + ONE], lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE]


@inlined
def product(
    ax: Number, ay: Number, az: Number, aw: Number, bx: Number, by: Number, bz: Number, bw: Number
) -> tuple[Number, Number, Number, Number]:
    """Returns the quaternion product a b: turn by b, then by a."""
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


@inlined
def rotated(
    qx: Number, qy: Number, qz: Number, qw: Number, x: Number, y: Number, z: Number
) -> tuple[Number, Number, Number]:
    """Returns a vector rotated by q."""
    tx, ty, tz = qy * z - qz * y, qz * x - qx * z, qx * y - qy * x
    tx, ty, tz = tx + tx, ty + ty, tz + tz
    return x + qw * tx + qy * tz - qz * ty, y + qw * ty + qz * tx - qx * tz, z + qw * tz + qx * ty - qy * tx


@inlined
def multiply(block: Array, a: int, b: int, out: int, sense: float) -> None:
    """Writes out = a b, or a b^-1 if sense is BACK. Each is the first of four rows of the block; out may be a or b."""
    a, b, out = a * BLOCK, b * BLOCK, out * BLOCK
    for k in range(BLOCK):
        ax, ay, az, aw = block[a + k], block[a + BLOCK + k], block[a + 2 * BLOCK + k], block[a + 3 * BLOCK + k]
        bx, by, bz, bw = block[b + k], block[b + BLOCK + k], block[b + 2 * BLOCK + k], block[b + 3 * BLOCK + k]
        x, y, z, w = product(ax, ay, az, aw, sense * bx, sense * by, sense * bz, bw)
        block[out + k], block[out + BLOCK + k] = x, y
        block[out + 2 * BLOCK + k], block[out + 3 * BLOCK + k] = z, w


@inlined
def normalise(block: Array, q: int) -> None:
    """Scales a quaternion to unit length. Lanes without a character may be zero."""
    q = q * BLOCK
    for k in range(BLOCK):
        x, y, z, w = block[q + k], block[q + BLOCK + k], block[q + 2 * BLOCK + k], block[q + 3 * BLOCK + k]
        scale = 1.0 / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
        block[q + k], block[q + BLOCK + k] = x * scale, y * scale
        block[q + 2 * BLOCK + k], block[q + 3 * BLOCK + k] = z * scale, w * scale


@inlined
def minors(
    a: float, b: float, c: float, d: float, ab: float, ac: float, ad: float, bc: float, bd: float, cd: float
) -> tuple[float, ...]:
    """Returns 2x2 minors of the upper two rows of [[a, ab, ac, ad], [ab, b, bc, bd], ...], then of the lower two."""
    return (
        a * b - ab * ab,
        a * bc - ab * ac,
        a * bd - ab * ad,
        ab * bc - b * ac,
        ab * bd - b * ad,
        ac * bd - bc * ad,
        ac * bd - bc * ad,
        ac * cd - c * ad,
        ac * d - cd * ad,
        bc * cd - c * bd,
        bc * d - cd * bd,
        c * d - cd * cd,
    )


@kernel
def horn(block: Array) -> None:
    """Writes rotations ALIGNED that maximise sum target . q source, for CORRELATION 3 i + j = sum target_i source_j.

    Horn 1987, solved as by Theobald (2005). First the largest root of the characteristic polynomial of a traceless
    symmetric 4x4 matrix, by Halley's method from an upper bound. Then its eigenvector, as the largest column of the
    adjugate. All roots are real, so the method converges from above.

    GAP is roughly the difference between the two largest roots, divided by the largest. If it is small, no rotation is
    clearly the best. It is 0 if the steps have not settled: only where abc < 0 and -c is close to b (`characteristic`).

    Each step is done for all lanes before the next step, because each waits for the one before.
    """
    for k in range(BLOCK):
        squares, linear, constant, root = characteristic(block, k)
        block[SQUARES * BLOCK + k], block[LINEAR * BLOCK + k] = squares, linear
        block[CONSTANT * BLOCK + k], block[ROOT * BLOCK + k] = constant, root
    for _ in range(HALLEY_STEPS):
        for k in range(BLOCK):
            squares, linear = block[SQUARES * BLOCK + k], block[LINEAR * BLOCK + k]
            constant, root = block[CONSTANT * BLOCK + k], block[ROOT * BLOCK + k]
            value = ((root * root - 2.0 * squares) * root + linear) * root + constant
            slope = (4.0 * root * root - 4.0 * squares) * root + linear
            divisor = 2.0 * slope * slope - value * (12.0 * root * root - 4.0 * squares)
            step = 2.0 * value * slope / divisor if divisor > 0.0 else 0.0
            block[ROOT * BLOCK + k], block[STEP * BLOCK + k] = root - step, step
    for k in range(BLOCK):
        squares, linear = block[SQUARES * BLOCK + k], block[LINEAR * BLOCK + k]
        root, step = block[ROOT * BLOCK + k], block[STEP * BLOCK + k]
        x, y, z, w = eigenvector(block, k, root)
        scale = (1.0 if w >= 0.0 else -1.0) / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
        block[ALIGNED * BLOCK + k], block[(ALIGNED + 1) * BLOCK + k] = x * scale, y * scale
        block[(ALIGNED + 2) * BLOCK + k], block[(ALIGNED + 3) * BLOCK + k] = z * scale, w * scale
        slope, cube = (4.0 * root * root - 4.0 * squares) * root + linear, 4.0 * root * root * root
        gap = slope / cube if cube > 0.0 else 0.0
        block[GAP * BLOCK + k] = gap if abs(step) <= SETTLED * gap * root else 0.0


@inlined
def matrix_of(block: Array, k: int) -> tuple[float, ...]:
    """Returns the symmetric matrix of a correlation: a, b, c, d on its diagonal, then ab, ac, ad, bc, bd, cd."""
    at = CORRELATION * BLOCK + k
    xx, yx, zx = block[at], block[at + BLOCK], block[at + 2 * BLOCK]
    xy, yy, zy = block[at + 3 * BLOCK], block[at + 4 * BLOCK], block[at + 5 * BLOCK]
    xz, yz, zz = block[at + 6 * BLOCK], block[at + 7 * BLOCK], block[at + 8 * BLOCK]
    a, b, c, d = xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz
    return a, b, c, d, xy + yx, zx + xz, yz - zy, yz + zy, zx - xz, xy - yx


@inlined
def characteristic(block: Array, k: int) -> tuple[float, float, float, float]:
    """Returns squares, linear, constant, and a bound on the largest root of r^4 - 2 squares r^2 + linear r + constant.

    With singular values a >= b >= |c| of the correlation, c of the sign of its determinant, the root is a + b + c. So
    root^2 = squares + 2 sqrt(pairs + 2 abc root), with squares = a^2 + b^2 + c^2 and pairs = (ab)^2 + (bc)^2 + (ca)^2,
    if that root is not negative. On the right the root is replaced by an upper bound if abc > 0, which makes the result
    one: BOUND, (sum |target|^2 + sum |source|^2) / 2, or sqrt(3 squares). Else by a lower bound, a or less. This is
    exact for clouds in a plane. It is worst for clouds that are nearly mirror images.
    """
    at = CORRELATION * BLOCK + k
    xx, yx, zx = block[at], block[at + BLOCK], block[at + 2 * BLOCK]
    xy, yy, zy = block[at + 3 * BLOCK], block[at + 4 * BLOCK], block[at + 5 * BLOCK]
    xz, yz, zz = block[at + 6 * BLOCK], block[at + 7 * BLOCK], block[at + 8 * BLOCK]
    squares = xx * xx + xy * xy + xz * xz + yx * yx + yy * yy + yz * yz + zx * zx + zy * zy + zz * zz
    volume = xx * (yy * zz - yz * zy) - xy * (yx * zz - yz * zx) + xz * (yx * zy - yy * zx)
    a, b, c, d, ab, ac, ad, bc, bd, cd = matrix_of(block, k)
    s0, s1, s2, s3, s4, s5, c0, c1, c2, c3, c4, c5 = minors(a, b, c, d, ab, ac, ad, bc, bd, cd)
    constant = s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0
    pairs = max(0.25 * (squares * squares - constant), 0.0)
    root = min(block[BOUND * BLOCK + k], math.sqrt(3.0 * squares))
    least = math.sqrt(max(squares * squares - 2.0 * pairs, 0.0) / max(squares, TINY))
    other = max(pairs + 2.0 * volume * (root if volume > 0.0 else least), 0.0)
    return squares, -8.0 * volume, constant, min(root, math.sqrt(squares + 2.0 * math.sqrt(other)))


@inlined
def eigenvector(block: Array, k: int, root: float) -> tuple[float, float, float, float]:
    """Returns the eigenvector of a root, of any length: the largest column of the adjugate of the matrix minus it."""
    a, b, c, d, ab, ac, ad, bc, bd, cd = matrix_of(block, k)
    a, b, c, d = a - root, b - root, c - root, d - root
    s0, s1, s2, s3, s4, _, c0, c1, c2, c3, c4, c5 = minors(a, b, c, d, ab, ac, ad, bc, bd, cd)
    n00, n01 = b * c5 - bc * c4 + bd * c3, -ab * c5 + bc * c2 - bd * c1
    n02, n03 = ab * c4 - b * c2 + bd * c0, -ab * c3 + b * c1 - bc * c0
    n11, n12, n13 = a * c5 - ac * c2 + ad * c1, -a * c4 + ab * c2 - ad * c0, a * c3 - ab * c1 + ac * c0
    n22, n23, n33 = ad * s4 - bd * s2 + d * s0, -ac * s4 + bc * s2 - cd * s0, ac * s3 - bc * s1 + c * s0
    x, y, z, w, most = n00, n01, n02, n03, abs(n00)
    larger = abs(n11) > most
    x, y = n01 if larger else x, n11 if larger else y
    z, w, most = n12 if larger else z, n13 if larger else w, abs(n11) if larger else most
    larger = abs(n22) > most
    x, y = n02 if larger else x, n12 if larger else y
    z, w, most = n22 if larger else z, n23 if larger else w, abs(n22) if larger else most
    larger = abs(n33) > most
    x, y = n03 if larger else x, n13 if larger else y
    z, w = n23 if larger else z, n33 if larger else w
    return x, y, z, w
