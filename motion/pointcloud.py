"""Point clouds: distances up to a turn and a shift over the floor, and the rotation that best aligns two."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from motionsplice.motion.quaternion import Floats


def planar_distances(a: ArrayLike, b: ArrayLike) -> Floats:
    """Returns the least sum of squared distances of every cloud in `a` to every cloud in `b`.

    For each pair, the minimum is over all turns about Y and shifts over the floor. The closed form is that of Kovar,
    Gleicher and Pighin 2002, as used by Heck et al. 2006, 3.1. [n, p, 3], [m, p, 3] metres -> [n, m] square metres.
    """
    a_floor, a_height = _centred(np.asarray(a, np.float64))
    b_floor, b_height = _centred(np.asarray(b, np.float64))
    points = a_height.shape[1]
    b_turned = np.concatenate([b_floor[:, points:], -b_floor[:, :points]], axis=1)
    overlap = np.hypot(a_floor @ b_floor.T, a_floor @ b_turned.T)
    squares_a = np.sum(a_floor**2, axis=1) + np.sum(a_height**2, axis=1)
    squares_b = np.sum(b_floor**2, axis=1) + np.sum(b_height**2, axis=1)
    distances = squares_a[:, None] + squares_b - 2.0 * (overlap + a_height @ b_height.T)
    return np.maximum(distances, 0.0)  # rounding may give -1e-16 for equal clouds


def planar_distance(a: ArrayLike, b: ArrayLike) -> Floats:
    """Returns the distance of each a[i] to b[i], as `planar_distances`. [n, p, 3], [n, p, 3] -> [n] square metres."""
    a_floor, a_height = _centred(np.asarray(a, np.float64))
    b_floor, b_height = _centred(np.asarray(b, np.float64))
    points = a_height.shape[1]
    along = np.sum(a_floor * b_floor, axis=1)
    across = np.sum(a_floor[:, :points] * b_floor[:, points:] - a_floor[:, points:] * b_floor[:, :points], axis=1)
    squares = np.sum(a_floor**2 + b_floor**2, axis=1) + np.sum((a_height - b_height) ** 2, axis=1)
    return np.maximum(squares - 2.0 * np.hypot(along, across), 0.0)


def planar_lag_distances(clouds: ArrayLike, lags: range) -> Floats:
    """Returns the `planar_distance` of each cloud i to cloud i + lag, for successive lags.

    [n, p, 3] -> [lags, n] square metres, inf where there is no cloud i + lag.
    """
    floor, height = _centred(np.asarray(clouds, np.float64))
    points = height.shape[1]
    turned = np.concatenate([floor[:, points:], -floor[:, :points]], axis=1)
    squares = np.sum(floor**2, axis=1) + np.sum(height**2, axis=1)
    overlap = np.hypot(_dots(floor, floor, lags), _dots(floor, turned, lags))
    both = overlap + _dots(height, height, lags)
    distances = np.maximum(squares + _later(squares, lags).T - 2.0 * both, 0.0)
    distances[np.arange(len(squares)) + np.array(lags)[:, None] >= len(squares)] = np.inf
    return np.asarray(distances)


def _dots(rows: Floats, others: Floats, lags: range) -> Floats:
    """Returns the products of row i with row i + lag of the others. [n, k], [n, k] -> [lags, n]."""
    return np.asarray(np.einsum("nk,nkl->ln", rows, _later(others, lags)))


def _later(rows: Floats, lags: range) -> Floats:
    """Returns the rows i + lag, zeros after the last one, for successive lags: [n, ...] -> [n, ..., lags]."""
    padded = np.concatenate([rows, np.zeros((lags.stop - 1, *rows.shape[1:]))])
    return sliding_window_view(padded[lags.start :], len(lags), axis=0)


def _centred(clouds: Floats) -> tuple[Floats, Floats]:
    """Returns centred floor coordinates [n, 2p] (all x, then all z) and heights [n, p]."""
    floor = clouds[:, :, [0, 2]]
    floor = floor - floor.mean(axis=1, keepdims=True)
    return np.concatenate([floor[:, :, 0], floor[:, :, 1]], axis=1), clouds[:, :, 1]


def level(clouds: Floats) -> Floats:
    """Returns clouds [n, p, 3] about their mean height, so that steps on a stair compare with steps on the floor.

    The papers shift clouds over the floor only. Up a stair of three steps this leaves the legs 40 cm from the
    baseline's; levelling leaves 4 cm. On level ground the difference is negligible.
    """
    return clouds - clouds.mean(axis=1, keepdims=True) * np.array([0.0, 1.0, 0.0])


def windowed(clouds: Floats, width: int) -> Floats:
    """Joins the clouds of each `width` successive frames into one. [n, p, 3] -> [n - width + 1, width * p, 3]."""
    count = max(len(clouds) - width + 1, 0)
    return np.concatenate([clouds[shift : shift + count] for shift in range(width)], axis=1)


def horn_rotation(target: ArrayLike, source: ArrayLike) -> Floats:
    """Returns the rotation about the origin that best lays `source` on `target`: argmin_q sum |target - q source|^2.

    Horn 1987: the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix. The clouds are not centred first.
    [..., p, 3], [..., p, 3] -> [..., 4], with w >= 0.
    """
    s = np.swapaxes(np.asarray(source, np.float64), -1, -2) @ np.asarray(target, np.float64)
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = (tuple(s[..., i, j] for j in range(3)) for i in range(3))
    horn = np.stack(
        [
            np.stack([xx - yy - zz, xy + yx, zx + xz, yz - zy], axis=-1),
            np.stack([xy + yx, yy - xx - zz, yz + zy, zx - xz], axis=-1),
            np.stack([zx + xz, yz + zy, zz - xx - yy, xy - yx], axis=-1),
            np.stack([yz - zy, zx - xz, xy - yx, xx + yy + zz], axis=-1),
        ],
        axis=-2,
    )
    q: Floats = np.linalg.eigh(horn)[1][..., :, 3]
    return np.where(q[..., 3:] < 0.0, -q, q)
