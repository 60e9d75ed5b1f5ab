"""Lower clouds that are free of place and heading, ready to compare and to average."""

from __future__ import annotations

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.turned_points import turned_points


def facing_joints(roles: Roles) -> tuple[int, ...]:
    """Returns the joints that `facing` needs: the lower cloud, then left and right hip."""
    return (*roles.lower_cloud, roles.left_hip, roles.right_hip)


def facing(positions: Floats) -> Floats:
    """Returns lower clouds [n, 3, 3] moved over the origin and turned until the hips lie along x, ready to average.

    `positions` [n, 5, 3] are the world positions of the `facing_joints`, metres.
    """
    turn = quaternion.about([0.0, 1.0, 0.0], -heading(positions[:, 3] - positions[:, 4]))
    clouds = positions[:, :3]
    return turned_points(turn, clouds - clouds[:, :1] * np.array([1.0, 0.0, 1.0]))
