"""Lower clouds that are free of place and heading, ready to compare and to average."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles


def facing_joints(roles: Roles) -> tuple[int, ...]:
    """Returns the joints that `facing` needs: the lower cloud, then left and right hip."""
    return (*roles.lower_cloud, roles.left_hip, roles.right_hip)


def facing(positions: Floats) -> Floats:
    """Returns lower clouds [n, 3, 3] moved over the origin and turned until the hips lie along x, ready to average.

    `positions` [n, 5, 3] are the world positions of the `facing_joints`, metres.
    """
    clouds = np.empty((len(positions), 3, 3))
    face(np.ascontiguousarray(positions), heading(positions[:, 3] - positions[:, 4]), clouds)
    return clouds


@compiled(nogil=True, error_model="numpy")
def face(positions: Floats, headings: Floats, clouds: Floats) -> None:
    """Fills `clouds` [n, 3, 3], given the headings of the hips [n]; see `facing`."""
    for frame in range(len(positions)):
        half = 0.5 * -headings[frame]
        y, w = np.sin(half), np.cos(half)
        for i in range(3):
            vx = positions[frame, i, 0] - positions[frame, 0, 0]
            vy = positions[frame, i, 1]
            vz = positions[frame, i, 2] - positions[frame, 0, 2]
            tx, tz = 2.0 * (y * vz), 2.0 * -(y * vx)
            clouds[frame, i, 0] = vx + w * tx + y * tz
            clouds[frame, i, 1] = vy
            clouds[frame, i, 2] = vz + w * tz - y * tx
