"""How far rotations are from what a clip's must be."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats


@compiled(nogil=True, error_model="numpy")
def unevenness(rotations: Floats) -> tuple[float, float]:
    """Returns the largest error of a rotation's length, and the least product of successive frames; inf for NaN."""
    error, least = 0.0, np.inf
    for frame in range(len(rotations)):
        for joint in range(rotations.shape[1]):
            x, y, z, w = rotations[frame, joint]
            off = abs(np.sqrt(x * x + y * y + z * z + w * w) - 1.0)
            if not off <= error:
                error = off if off > error else np.inf
            if frame > 0:
                a, b, c, d = rotations[frame - 1, joint]
                least = min(least, x * a + y * b + z * c + w * d)
    return error, least
