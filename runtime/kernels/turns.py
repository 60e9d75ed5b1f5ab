"""Rotations and vectors of single joints, as tuples of float64."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.kernels.rotations import ONE, P1, P2, P3, P4, Q1, Q2, Q3, Q4, TINY, product, rotated
from motionsplice.runtime.simd.compiled import Array, Index, inlined

Turn = tuple[float, float, float, float]  # a quaternion, xyzw
Vector = tuple[float, float, float]
SERIES_TO = math.cos(math.radians(45.0)) - 1.0


@inlined
def times(a: Turn, b: Turn) -> Turn:
    """Returns the rotation by b, then by a."""
    return product(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3])


@inlined
def inverse(q: Turn) -> Turn:
    """Returns the inverse of a unit quaternion."""
    return -q[0], -q[1], -q[2], q[3]


@inlined
def turned(q: Turn, v: Vector) -> Vector:
    """Returns a vector rotated by q."""
    return rotated(q[0], q[1], q[2], q[3], v[0], v[1], v[2])


@inlined
def plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def middle(a: Vector, b: Vector) -> Vector:
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inlined
def about_y(angle: float) -> Turn:
    return 0.0, math.sin(0.5 * angle), 0.0, math.cos(0.5 * angle)


@inlined
def forward_of(q: Turn) -> Vector:
    """Returns Z rotated by q."""
    x, y, z, w = q
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


@inlined
def between(a: Vector, b: Vector) -> Turn:
    """Returns the smallest rotation from unit vector a to unit vector b; the identity if they are opposite."""
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return unit((x, y, z, 1.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]))


@inlined
def unit(q: Turn) -> Turn:
    """Scales a quaternion to unit length; the identity if it has none."""
    square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]
    if square < TINY:
        return 0.0, 0.0, 0.0, 1.0
    scale = 1.0 / math.sqrt(square)
    return q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale


@inlined
def length(v: Vector) -> float:
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@inlined
def unit_vector(v: Vector) -> Vector:
    """Scales a vector to unit length, and leaves one that has none."""
    scale = 1.0 / math.sqrt(max(v[0] * v[0] + v[1] * v[1] + v[2] * v[2], TINY))
    return v[0] * scale, v[1] * scale, v[2] * scale


@inlined
def part_of(q: Turn, share: float) -> Turn:
    """Returns a share, 0 to 1, of the shorter rotation to q, about the same axis.

    Up to 90 degrees by Eberly's series (2011) as in `sample`, from the identity: at most 1e-5 rad off.
    """
    sign = 1.0 if q[3] >= 0.0 else -1.0
    below, square = sign * q[3] - 1.0, share * share
    if below > SERIES_TO:
        t1 = share * (P1 * square - Q1)
        t2 = t1 * (P2 * square - Q2)
        t3 = t2 * (P3 * square - Q3)
        t4 = t3 * (P4 * square - Q4)
        to = sign * float(share + below * (t1 + below * (t2 + below * (t3 + below * t4))))
    else:
        half = math.acos(min(1.0 + below, 1.0))
        to = sign * math.sin(share * half) / math.sin(half)
    x, y, z = to * q[0], to * q[1], to * q[2]
    return x, y, z, math.sqrt(max(1.0 - (x * x + y * y + z * z), 0.0))


@inlined
def straight_part_of(q: Turn, share: float) -> Turn:
    """Returns a share, 0 to 1, of the rotation to q as it is: of more than half a turn where q[3] < 0."""
    if q[3] >= 0.0:
        return part_of(q, share)
    half = math.acos(max(q[3], -1.0))
    to = math.sin(share * half) / max(math.sin(half), TINY)
    return to * q[0], to * q[1], to * q[2], math.cos(share * half)


@inlined
def turn_at(rotations: Array, character: int, column: Index) -> Turn:
    """Returns a rotation of a pose."""
    x, y = rotations[character, column], rotations[character, column + ONE]
    z, w = rotations[character, column + ONE + ONE], rotations[character, column + ONE + ONE + ONE]
    return np.float64(x), np.float64(y), np.float64(z), np.float64(w)


@inlined
def set_turn(rotations: Array, character: int, column: Index, q: Turn) -> None:
    """Writes a rotation of a pose, which is nearly of unit length: a Newton step normalises it."""
    scale = 1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    rotations[character, column], rotations[character, column + ONE] = scale * q[0], scale * q[1]
    rotations[character, column + ONE + ONE] = scale * q[2]
    rotations[character, column + ONE + ONE + ONE] = scale * q[3]


@inlined
def turn_joint(rotations: Array, character: int, column: Index, turn: Turn, above: Turn) -> Turn:
    """Turns a joint of a pose by a turn of the world, and returns it; `above` was its parent's rotation."""
    x, y, z = turned(inverse(above), (turn[0], turn[1], turn[2]))
    local = times((x, y, z, turn[3]), turn_at(rotations, character, column))
    set_turn(rotations, character, column, local)
    return local
