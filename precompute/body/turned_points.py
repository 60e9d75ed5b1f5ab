"""Points of many frames, turned frame by frame."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats


def turned_points(turns: Floats, points: Floats) -> Floats:
    """Returns points [F, p, 3], those of each frame turned by its rotation [F, 4]; as `quaternion.rotate`, but faster.

    Clips have many frames and few points in each, for which NumPy's temporary arrays cost most of the time.
    """
    turned = np.empty(points.shape)
    turn_points(np.ascontiguousarray(turns), np.ascontiguousarray(points), turned)
    return turned


@compiled(nogil=True, error_model="numpy")
def turn_points(turns: Floats, points: Floats, turned: Floats) -> None:
    """Fills `turned` [F, p, 3]; see `turned_points`."""
    for frame in range(len(points)):
        x, y, z, w = turns[frame, 0], turns[frame, 1], turns[frame, 2], turns[frame, 3]
        for i in range(points.shape[1]):
            vx, vy, vz = points[frame, i, 0], points[frame, i, 1], points[frame, i, 2]
            tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
            turned[frame, i, 0] = vx + w * tx + y * tz - z * ty
            turned[frame, i, 1] = vy + w * ty + z * tx - x * tz
            turned[frame, i, 2] = vz + w * tz + x * ty - y * tx
