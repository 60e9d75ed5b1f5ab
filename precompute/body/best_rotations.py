"""Horn's rotation for every frame of a clip, computed by the kernel of the run-time evaluator."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.posture import LEAST_GAP
from motionsplice.runtime.kernels.rotations import horn


def best_rotations(targets: Floats, sources: Floats) -> Floats:
    """Returns the rotations [n, 4] about the origin that best lay `sources` [n, p, 3] on `targets` [n, p, 3].

    The results agree with `motion.pointcloud.horn_rotation`, which also computes the frames whose best rotation is
    hardly better than the next (a gap below LEAST_GAP).
    """
    correlations = (np.swapaxes(targets, 1, 2) @ sources).reshape(-1, 9)
    bounds = 0.5 * (1.0 + 1e-12) * (np.sum(targets**2, axis=(1, 2)) + np.sum(sources**2, axis=(1, 2)))
    rotations, gaps = np.empty((len(targets), 4)), np.empty(len(targets))
    fit_blocks(correlations, bounds, rotations, gaps)
    unclear = gaps < LEAST_GAP
    if unclear.any():
        rotations[unclear] = horn_rotation(targets[unclear], sources[unclear])
    return rotations


@compiled(nogil=True, error_model="numpy")
def fit_blocks(correlations: Floats, bounds: Floats, rotations: Floats, gaps: Floats) -> None:
    """Fills `rotations` [n, 4] and `gaps` [n] from `correlations` [n, 9] and `bounds` [n]."""
    block = np.zeros(arrays.BLOCK_ROWS * arrays.BLOCK)
    for first in range(0, len(bounds), arrays.BLOCK):
        count = min(arrays.BLOCK, len(bounds) - first)
        for k in range(count):
            for i in range(9):
                block[(arrays.CORRELATION + i) * arrays.BLOCK + k] = correlations[first + k, i]
            block[arrays.BOUND * arrays.BLOCK + k] = bounds[first + k]
        horn(block)
        for k in range(count):
            for i in range(4):
                rotations[first + k, i] = block[(arrays.ALIGNED + i) * arrays.BLOCK + k]
            gaps[first + k] = block[arrays.GAP * arrays.BLOCK + k]
