"""The most typical of many strides, which becomes the baseline if the user names none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.alignment.ring import walk_ring

OTHER_GAIT = 0.15  # leg lengths between strides: those farther apart are other gaits, however far
MOST_CANDIDATES = 16  # strides that are compared with all others
DECIMALS = 9  # leg lengths: the choice must not depend on last bits, in which compilations of a kernel differ


def most_typical(strides: Sequence[Baseline]) -> Baseline:
    """Returns the stride nearest to all `strides`, among the MOST_CANDIDATES whose ends match best.

    Two laps of each stride are wound round each candidate's ring, so the cost is linear in the number of strides. The
    sum is over distances, not their squares, and each counts at most OTHER_GAIT. Otherwise one run among walks would
    favour a stride halfway between walk and run, which is like neither, and jumps and dances would count most.
    """
    rings = [_centred(stride) for stride in strides]
    all_rings, ends = np.concatenate(rings), np.cumsum([len(ring) for ring in rings])
    candidates = sorted(strides, key=lambda stride: (stride.loop, stride.name))[:MOST_CANDIDATES]
    best, chosen = np.inf, candidates[0]
    for candidate in sorted(candidates, key=lambda stride: stride.name):  # of equals, the first by name
        apart = round(distance_to_all(all_rings, ends, _centred(candidate), best), DECIMALS)
        if apart < best:
            best, chosen = apart, candidate
    return chosen


def _centred(stride: Baseline) -> Floats:
    """Returns the clouds of a stride about their means [cells, 3, 3], in leg lengths."""
    clouds = stride.clouds / stride.leg
    return np.asarray(clouds - clouds.mean(axis=1, keepdims=True))


@compiled(nogil=True, error_model="numpy")
def distance_to_all(rings: Floats, ends: NDArray[np.int64], ring: Floats, enough: float) -> float:
    """Returns the sum of the distances of strides from one of them; inf if it is certainly above `enough`.

    rings: [n, 3, 3] the clouds of all strides about their means, one stride after the other, each up to one of `ends`.
    A stride is no nearer than its clouds are to those that are most like them, whatever their order.
    """
    least, total, first = np.empty(len(ends)), 0.0, 0
    for k in range(len(ends)):
        squares = 0.0
        for i in range(first, ends[k]):
            nearest = np.inf
            for j in range(len(ring)):
                nearest = min(nearest, _squared_distance(rings[i], ring[j]))
            squares += nearest
        least[k] = min(np.sqrt(squares / (ends[k] - first)), OTHER_GAIT)
        total += least[k]
        first = ends[k]
    first = 0
    for k in range(len(ends)):
        if total > enough + 10.0**-DECIMALS:
            return np.inf
        if least[k] < OTHER_GAIT:
            cells = ends[k] - first
            twice = np.empty((2 * cells, len(ring)))
            for i in range(cells):
                for j in range(len(ring)):
                    twice[i, j] = twice[i + cells, j] = _squared_distance(rings[first + i], ring[j])
            wound = walk_ring(twice, 0.0, 0.0)
            squares = 0.0
            for i in range(2 * cells):
                squares += twice[i, wound[i] % len(ring)]
            total += min(np.sqrt(squares / (2 * cells)), OTHER_GAIT) - least[k]
        first = ends[k]
    return total


@compiled(nogil=True, error_model="numpy")
def _squared_distance(a: Floats, b: Floats) -> float:
    """Returns the distance of two clouds [p, 3] about their means, as `motion.pointcloud.planar_distances`."""
    squares, along, across = 0.0, 0.0, 0.0
    for i in range(len(a)):
        squares += a[i, 0] ** 2 + a[i, 2] ** 2 + b[i, 0] ** 2 + b[i, 2] ** 2 + (a[i, 1] - b[i, 1]) ** 2
        along += a[i, 0] * b[i, 0] + a[i, 2] * b[i, 2]
        across += a[i, 0] * b[i, 2] - a[i, 2] * b[i, 0]
    return max(squares - 2.0 * np.sqrt(along**2 + across**2), 0.0)
