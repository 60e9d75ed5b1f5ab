"""Unit-quaternion algebra on arrays. Order is xyzw; every function broadcasts over leading axes.

For everything else there is `scipy.spatial.transform.Rotation`, which is slow to import and slow on many frames.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

BLOCK = 256  # frames computed at once, so that what is between stays in a core's cache
IDENTITY: Floats = np.array([0.0, 0.0, 0.0, 1.0])


def multiply(a: ArrayLike, b: ArrayLike) -> Floats:
    """Returns the product: the rotation by `b`, then by `a`. [..., 4], [..., 4] -> [..., 4]."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    ax, ay, az, aw = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bx, by, bz, bw = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    product[..., 0] = aw * bx + ax * bw + ay * bz - az * by
    product[..., 1] = aw * by - ax * bz + ay * bw + az * bx
    product[..., 2] = aw * bz + ax * by - ay * bx + az * bw
    product[..., 3] = aw * bw - ax * bx - ay * by - az * bz
    return product


def conjugate(q: ArrayLike) -> Floats:
    """Returns the inverse of a unit quaternion. [..., 4] -> [..., 4]."""
    return np.asarray(q, np.float64) * np.array([-1.0, -1.0, -1.0, 1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> Floats:
    """Rotates the vectors `v` by `q`. [..., 4], [..., 3] -> [..., 3]."""
    q, v = np.asarray(q, np.float64), np.asarray(v, np.float64)
    turned = np.empty((*np.broadcast_shapes(q.shape[:-1], v.shape[:-1]), 3))
    if q.ndim == v.ndim > 1 and len(q) == len(v):
        for first in range(0, len(q), BLOCK):
            some = slice(first, first + BLOCK)
            _rotate(q[some], v[some], turned[some])
    else:
        _rotate(q, v, turned)
    return turned


def _rotate(q: Floats, v: Floats, turned: Floats) -> None:
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    vx, vy, vz = v[..., 0], v[..., 1], v[..., 2]
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    turned[..., 0] = vx + w * tx + y * tz - z * ty  # written out, because np.cross takes several times as long
    turned[..., 1] = vy + w * ty + z * tx - x * tz
    turned[..., 2] = vz + w * tz + x * ty - y * tx


def length(q: ArrayLike) -> Floats:
    """Returns the Euclidean norm over the last axis. [..., n] -> [...]."""
    q = np.asarray(q, np.float64)
    return np.sqrt(np.einsum("...i,...i->...", q, q))


def normalise(q: ArrayLike) -> Floats:
    """Scales to unit length. [..., 4] -> [..., 4]."""
    q = np.asarray(q, np.float64)
    return np.asarray(q / length(q)[..., None])


def unit(v: ArrayLike) -> Floats:
    """Scales vectors to unit length, and leaves those that have no length. [..., n] -> [..., n]."""
    v = np.asarray(v, np.float64)
    size = length(v)[..., None]
    return np.asarray(v / np.where(size > 0.0, size, 1.0))


def angle(a: ArrayLike, b: ArrayLike) -> Floats:
    """Returns the angle in radians between two rotations, in [0, pi]. [..., 4], [..., 4] -> [...]."""
    difference = multiply(conjugate(a), b)
    return np.asarray(2.0 * np.arctan2(length(difference[..., :3]), np.abs(difference[..., 3])))


def about(axis: ArrayLike, radians: ArrayLike) -> Floats:
    """Returns the rotation [..., 4] by `radians` [...] about the unit vector `axis`, [3] or [..., 3]."""
    axis, half = np.asarray(axis, np.float64), 0.5 * np.asarray(radians, np.float64)
    vector = axis * np.sin(half)[..., None]
    return np.concatenate([vector, np.cos(half)[..., None]], axis=-1)


def between(a: ArrayLike, b: ArrayLike) -> Floats:
    """Returns the smallest rotation that turns the direction of `a` to that of `b`. [..., 3], [..., 3] -> [..., 4].

    The axis is any perpendicular one if they are opposite; the rotation is the identity if either is zero.
    """
    a, b = np.broadcast_arrays(np.asarray(a, np.float64), np.asarray(b, np.float64))
    sizes = np.sqrt(np.sum(a * a, axis=-1) * np.sum(b * b, axis=-1))[..., None]
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    q = np.concatenate([np.cross(a, b), sizes + cosine], axis=-1)
    opposite = length(q)[..., None] <= 1e-7 * sizes
    least = np.eye(3)[np.argmin(np.abs(a), axis=-1)]
    aside = np.concatenate([np.cross(a, least), np.zeros_like(sizes)], axis=-1)
    q = np.where(sizes > 0.0, np.where(opposite, aside, q), IDENTITY)
    return normalise(q)


def from_euler(order: str, sines: Floats, cosines: Floats) -> Floats:
    """Returns the rotation [..., 4] of n intrinsic Euler angles about the axes in `order`, such as "zxy".

    sines and cosines [..., n] are of half the angles.
    """
    q = np.zeros((*sines.shape[:-1], 4))
    q[..., 3] = 1.0
    for column, name in enumerate(order):
        i = "xyz".index(name)
        j, k = (i + 1) % 3, (i + 2) % 3
        s, c = sines[..., column], cosines[..., column]
        turned = np.empty_like(q)  # q times the turn about axis i, whose other two components are zero
        turned[..., i] = c * q[..., i] + s * q[..., 3]
        turned[..., j] = c * q[..., j] + s * q[..., k]
        turned[..., k] = c * q[..., k] - s * q[..., j]
        turned[..., 3] = c * q[..., 3] - s * q[..., i]
        q = turned
    return q


def to_matrices(q: ArrayLike) -> Floats:
    """Returns the matrices of unit quaternions: their columns are the turned axes. [..., 4] -> [..., 3, 3]."""
    q = np.asarray(q, np.float64)
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    matrices = np.empty((3, 3, *x.shape))
    matrices[0] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    matrices[1] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    matrices[2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    return np.moveaxis(matrices, (0, 1), (-2, -1))


def from_matrices(matrices: Floats) -> Floats:
    """Returns the quaternions of rotation matrices, each from its largest component. [..., 3, 3] -> [..., 4]."""
    m = np.moveaxis(matrices, (-2, -1), (0, 1)).reshape(3, 3, -1)
    x, y, z = m[0, 0], m[1, 1], m[2, 2]
    largest = np.argmax([x - y - z, y - z - x, z - x - y, x + y + z], axis=0)
    q = np.empty((len(x), 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rows = np.flatnonzero(largest == i)
        if len(rows):
            one = m[..., rows]
            q[rows, i] = 1.0 + one[i, i] - one[j, j] - one[k, k]
            q[rows, j] = one[j, i] + one[i, j]
            q[rows, k] = one[k, i] + one[i, k]
            q[rows, 3] = one[k, j] - one[j, k]
    rows = np.flatnonzero(largest == 3)
    one = m[..., rows]
    q[rows, 0], q[rows, 1] = one[2, 1] - one[1, 2], one[0, 2] - one[2, 0]
    q[rows, 2], q[rows, 3] = one[1, 0] - one[0, 1], 1.0 + one[0, 0] + one[1, 1] + one[2, 2]
    return normalise(q).reshape(*matrices.shape[:-2], 4)


def log(q: ArrayLike) -> Floats:
    """Returns the rotation vector of the shorter turn: its axis times its radians. [..., 4] -> [..., 3]."""
    q = np.asarray(q, np.float64)
    q = np.where(q[..., 3:] < 0.0, -q, q)
    sine = length(q[..., :3])
    half = np.arctan2(sine, q[..., 3])
    small = sine < 1e-12
    return np.asarray(q[..., :3] * np.where(small, 2.0, 2.0 * half / np.where(small, 1.0, sine))[..., None])


def exp(v: ArrayLike) -> Floats:
    """Returns the rotation of a rotation vector. [..., 3] -> [..., 4]."""
    v = np.asarray(v, np.float64)
    half = 0.5 * length(v)
    return np.concatenate([0.5 * v * np.sinc(half / np.pi)[..., None], np.cos(half)[..., None]], axis=-1)


def one_hemisphere(q: ArrayLike) -> Floats:
    """Returns the same rotations [frames, ..., 4], with signs that keep each in the hemisphere of the frame before."""
    q = np.asarray(q, np.float64)
    turns = np.einsum("...i,...i->...", q[1:], q[:-1]) < 0.0
    if not turns.any():
        return q
    signed = q.copy()
    signed[1:] *= np.cumprod(np.where(turns, -1.0, 1.0), axis=0)[..., None]
    return signed


def neighbours(count: int, frames: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Returns the whole frames before and after real-valued `frames` [n], and the fraction between them, each [n].

    Frames outside the `count` frames are clamped to the first or last.
    """
    at = np.clip(np.asarray(frames, np.float64), 0.0, count - 1)
    before = np.minimum(at.astype(np.int64), max(count - 2, 0))
    return before, np.minimum(before + 1, count - 1), at - before


def interpolated(rows: Floats, frames: ArrayLike) -> Floats:
    """Returns rows [F, ...] of numbers at real-valued `frames` [n], linearly interpolated and clamped: [n, ...]."""
    before, after, t = neighbours(len(rows), frames)
    return np.asarray(rows[before] + t.reshape(-1, *[1] * (rows.ndim - 1)) * (rows[after] - rows[before]))


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike) -> Floats:
    """Interpolates along the shorter arc (spherical linear). [..., 4], [..., 4], [...] -> [..., 4]."""
    a, b, t = np.asarray(a, np.float64), np.asarray(b, np.float64), np.asarray(t, np.float64)[..., None]
    dot = np.einsum("...i,...i->...", a, b)[..., None]
    b = np.where(dot < 0.0, -b, b)
    # Half-chords keep full precision for nearly equal rotations, where arccos(dot) loses it.
    theta = 2.0 * np.arctan2(length(b - a), length(b + a))[..., None]
    small = theta < 1e-6
    sine = np.where(small, 1.0, np.sin(theta))
    weight_a = np.where(small, 1.0 - t, np.sin((1.0 - t) * theta) / sine)
    weight_b = np.where(small, t, np.sin(t * theta) / sine)
    return normalise(weight_a * a + weight_b * b)
