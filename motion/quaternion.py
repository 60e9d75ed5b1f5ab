"""Unit-quaternion algebra on arrays. Order is xyzw; every function broadcasts over leading axes.

Conversions from and to other forms of rotation are SciPy's: `scipy.spatial.transform.Rotation`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

IDENTITY: Floats = np.array([0.0, 0.0, 0.0, 1.0])


def multiply(a: ArrayLike, b: ArrayLike) -> Floats:
    """The rotation that turns by `b`, then by `a`. [..., 4], [..., 4] -> [..., 4]."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    ax, ay, az, aw = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bx, by, bz, bw = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def conjugate(q: ArrayLike) -> Floats:
    """The inverse of a unit quaternion. [..., 4] -> [..., 4]."""
    return np.asarray(q, np.float64) * np.array([-1.0, -1.0, -1.0, 1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> Floats:
    """Vectors `v` turned by `q`. [..., 4], [..., 3] -> [..., 3]."""
    q, v = np.asarray(q, np.float64), np.asarray(v, np.float64)
    axis = q[..., :3]
    t = 2.0 * np.cross(axis, v)
    return v + q[..., 3:] * t + np.cross(axis, t)


def normalise(q: ArrayLike) -> Floats:
    """Scaled to unit length. [..., 4] -> [..., 4]."""
    q = np.asarray(q, np.float64)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def angle(a: ArrayLike, b: ArrayLike) -> Floats:
    """The angle in radians between two rotations, in [0, pi]. [..., 4], [..., 4] -> [...]."""
    difference = multiply(conjugate(a), b)
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(difference[..., :3], axis=-1), np.abs(difference[..., 3])))


def about(axis: ArrayLike, radians: ArrayLike) -> Floats:
    """The turn by `radians` [...] about the unit vector `axis` [3] or [..., 3] -> [..., 4]."""
    axis, half = np.asarray(axis, np.float64), 0.5 * np.asarray(radians, np.float64)
    vector = axis * np.sin(half)[..., None]
    return np.concatenate([vector, np.cos(half)[..., None]], axis=-1)


def one_hemisphere(q: ArrayLike) -> Floats:
    """The same rotations [frames, ..., 4], signed so that each frame is nearest to the one before."""
    q = np.array(q, np.float64)
    flips = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0.0, -1.0, 1.0)
    q[1:] *= np.cumprod(flips, axis=0)[..., None]
    return q


def neighbours(count: int, frames: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """The keys before and after real-valued frames [n], and how far past the first [n]; held at the ends of `count`."""
    at = np.clip(np.asarray(frames, np.float64), 0.0, count - 1)
    before = np.minimum(at.astype(np.int64), max(count - 2, 0))
    return before, np.minimum(before + 1, count - 1), at - before


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike) -> Floats:
    """Spherical linear interpolation along the shorter arc. [..., 4], [..., 4], [...] -> [..., 4]."""
    a, b, t = np.asarray(a, np.float64), np.asarray(b, np.float64), np.asarray(t, np.float64)[..., None]
    dot = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(dot < 0.0, -b, b)
    # The half-chord keeps full precision for nearly equal rotations, where arccos(dot) has none.
    theta = 2.0 * np.arctan2(np.linalg.norm(b - a, axis=-1), np.linalg.norm(b + a, axis=-1))[..., None]
    small = theta < 1e-6
    sine = np.where(small, 1.0, np.sin(theta))
    weight_a = np.where(small, 1.0 - t, np.sin((1.0 - t) * theta) / sine)
    weight_b = np.where(small, t, np.sin(t * theta) / sine)
    return normalise(weight_a * a + weight_b * b)
