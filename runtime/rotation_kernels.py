"""Rotations in kernels: interpolation, products, and the one that lays a cloud on another.

As `runtime.kernels`: nothing here checks, allocates or holds the GIL.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]


@njit(cache=True, nogil=True, error_model="numpy")
def slerp(a: Array, b: Array, t: float, out: Array) -> None:
    """Spherical interpolation of neighbouring keys, as Eberly's series (2011) cut after four terms.

    Keys lie in one hemisphere. The remainder grows with their angle: 1e-7 rad at 60 degrees, 1e-5 at 90, 1e-3 (0.05
    degrees) at 150, and 0.0051 (0.3 degrees) at 180, which is as far apart as keys can be.
    """
    below = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] - 1.0
    weight_a, weight_b = series(1.0 - t, below), series(t, below)
    x, y = weight_a * a[0] + weight_b * b[0], weight_a * a[1] + weight_b * b[1]
    z, w = weight_a * a[2] + weight_b * b[2], weight_a * a[3] + weight_b * b[3]
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    out[0], out[1], out[2], out[3] = x * scale, y * scale, z * scale, w * scale


@njit(cache=True, nogil=True, error_model="numpy")
def series(t: float, below: float) -> float:
    """sin(t angle) / sin(angle), where `below` is cos(angle) - 1."""
    square = t * t
    fourth = (square / 36.0 - 4.0 / 9.0) * below
    third = (square / 21.0 - 3.0 / 7.0) * below
    second = (square / 10.0 - 2.0 / 5.0) * below
    first = (square / 3.0 - 1.0 / 3.0) * below
    return t * (1.0 + first * (1.0 + second * (1.0 + third * (1.0 + fourth))))


@njit(cache=True, nogil=True, error_model="numpy")
def multiply(a: Array, b: Array, out: Array) -> None:
    """out = a b; out may be a or b."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    out[0], out[1], out[2], out[3] = x, y, z, w


@njit(cache=True, nogil=True, error_model="numpy")
def multiply_by_inverse(a: Array, b: Array, out: Array) -> None:
    """out = a b^-1; out may be a or b."""
    x = -a[3] * b[0] + a[0] * b[3] - a[1] * b[2] + a[2] * b[1]
    y = -a[3] * b[1] + a[0] * b[2] + a[1] * b[3] - a[2] * b[0]
    z = -a[3] * b[2] - a[0] * b[1] + a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    out[0], out[1], out[2], out[3] = x, y, z, w


@njit(cache=True, nogil=True, error_model="numpy")
def rotate(q: Array, v: Array, out: Array) -> None:
    """out = v [3] turned by q; out may be v."""
    tx = 2.0 * (q[1] * v[2] - q[2] * v[1])
    ty = 2.0 * (q[2] * v[0] - q[0] * v[2])
    tz = 2.0 * (q[0] * v[1] - q[1] * v[0])
    x = v[0] + q[3] * tx + q[1] * tz - q[2] * ty
    y = v[1] + q[3] * ty + q[2] * tx - q[0] * tz
    z = v[2] + q[3] * tz + q[0] * ty - q[1] * tx
    out[0], out[1], out[2] = x, y, z


@njit(cache=True, nogil=True, error_model="numpy")
def normalise_into(q: Array, out: Array) -> None:
    scale = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        out[i] = q[i] * scale


@njit(cache=True, nogil=True, error_model="numpy")
def horn(correlation: Array, out: Array) -> None:
    """The rotation that maximises sum target . q source, for correlation[i, j] = sum target_i source_j.

    Horn 1987, by Theobald's route (2005): the largest root of the characteristic polynomial of a traceless
    symmetric 4x4 matrix by Newton's method from an upper bound, and its eigenvector as a column of the adjugate.
    The identity where no rotation is better than all others (empty or collinear clouds).
    """
    xx, xy, xz = correlation[0, 0], correlation[1, 0], correlation[2, 0]
    yx, yy, yz = correlation[0, 1], correlation[1, 1], correlation[2, 1]
    zx, zy, zz = correlation[0, 2], correlation[1, 2], correlation[2, 2]
    a, b, c, d = xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz
    ab, ac, ad, bc, bd, cd = xy + yx, zx + xz, yz - zy, yz + zy, zx - xz, xy - yx
    squares = xx * xx + xy * xy + xz * xz + yx * yx + yy * yy + yz * yz + zx * zx + zy * zy + zz * zz
    out[0], out[1], out[2], out[3] = 0.0, 0.0, 0.0, 1.0
    if squares == 0.0:
        return
    # det(N - s) = s^4 - 2 squares s^2 - 8 det s + det N
    det = xx * (yy * zz - yz * zy) - xy * (yx * zz - yz * zx) + xz * (yx * zy - yy * zx)
    linear = -8.0 * det
    constant = _determinant(a, b, c, d, ab, ac, ad, bc, bd, cd)
    root = math.sqrt(3.0 * squares)  # the largest eigenvalue of a traceless matrix with this norm at most
    for _ in range(24):
        value = ((root * root - 2.0 * squares) * root + linear) * root + constant
        slope = (4.0 * root * root - 4.0 * squares) * root + linear
        if slope <= 0.0:
            break
        step = value / slope
        root -= step
        if abs(step) < 1e-14 * root:
            break
    a, b, c, d = a - root, b - root, c - root, d - root
    best = 0.0
    for column in range(4):
        x, y, z, w = _adjugate_column(column, a, b, c, d, ab, ac, ad, bc, bd, cd)
        size = x * x + y * y + z * z + w * w
        if size > best:
            best = size
            scale = (1.0 if w >= 0.0 else -1.0) / math.sqrt(size)
            out[0], out[1], out[2], out[3] = x * scale, y * scale, z * scale, w * scale
    if best < 1e-12 * squares * squares * squares:  # the two largest roots meet: no single best rotation
        out[0], out[1], out[2], out[3] = 0.0, 0.0, 0.0, 1.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _determinant(
    a: float, b: float, c: float, d: float, ab: float, ac: float, ad: float, bc: float, bd: float, cd: float
) -> float:
    x, y, z, w = _adjugate_column(0, a, b, c, d, ab, ac, ad, bc, bd, cd)
    return a * x + ab * y + ac * z + ad * w


@njit(cache=True, nogil=True, error_model="numpy")
def _adjugate_column(
    column: int,
    a: float,
    b: float,
    c: float,
    d: float,
    ab: float,
    ac: float,
    ad: float,
    bc: float,
    bd: float,
    cd: float,
) -> tuple[float, float, float, float]:
    """A column of the adjugate of the symmetric matrix [[a, ab, ac, ad], [ab, b, bc, bd], [.., c, cd], [.., d]]."""
    # 2x2 minors of the two upper and the two lower rows
    s0, s1, s2 = a * b - ab * ab, a * bc - ab * ac, a * bd - ab * ad
    s3, s4, s5 = ab * bc - b * ac, ab * bd - b * ad, ac * bd - bc * ad
    c5, c4, c3 = c * d - cd * cd, bc * d - cd * bd, bc * cd - c * bd
    c2, c1, c0 = ac * d - cd * ad, ac * cd - c * ad, ac * bd - bc * ad
    if column == 0:
        return (
            b * c5 - bc * c4 + bd * c3,
            -ab * c5 + bc * c2 - bd * c1,
            ab * c4 - b * c2 + bd * c0,
            -ab * c3 + b * c1 - bc * c0,
        )
    if column == 1:
        return (
            -ab * c5 + ac * c4 - ad * c3,
            a * c5 - ac * c2 + ad * c1,
            -a * c4 + ab * c2 - ad * c0,
            a * c3 - ab * c1 + ac * c0,
        )
    if column == 2:
        return (
            bd * s5 - cd * s4 + d * s3,
            -ad * s5 + cd * s2 - d * s1,
            ad * s4 - bd * s2 + d * s0,
            -ad * s3 + bd * s1 - cd * s0,
        )
    return (
        -bc * s5 + c * s4 - cd * s3,
        ac * s5 - c * s2 + cd * s1,
        -ac * s4 + bc * s2 - cd * s0,
        ac * s3 - bc * s1 + c * s0,
    )
