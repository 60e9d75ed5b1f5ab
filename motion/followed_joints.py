"""The kernel of forward kinematics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats


@compiled(nogil=True, error_model="numpy")
def follow_joints(
    needed: NDArray[np.int64],
    parents: NDArray[np.int64],
    offsets: Floats,
    wanted: NDArray[np.int64],
    root_positions: Floats,
    rotations: Floats,
    positions: Floats,
    world: Floats,
) -> None:
    """Fills `positions` [F, n, 3] of the joints needed[wanted], and `world` [F, m, 4] of the first m of them.

    `needed` [k] are joints, the root first and parents before children. `parents` [k] and `wanted` [n] are indices
    into it.
    """
    at, turn = np.empty((len(needed), 3)), np.empty((len(needed), 4))
    for frame in range(len(root_positions)):
        for i in range(3):
            at[0, i] = root_positions[frame, i]
        for i in range(4):
            turn[0, i] = rotations[frame, 0, i]
        for place in range(1, len(needed)):
            above, joint = parents[place], needed[place]
            ax, ay, az, aw = turn[above, 0], turn[above, 1], turn[above, 2], turn[above, 3]
            vx, vy, vz = offsets[place, 0], offsets[place, 1], offsets[place, 2]
            tx, ty, tz = 2.0 * (ay * vz - az * vy), 2.0 * (az * vx - ax * vz), 2.0 * (ax * vy - ay * vx)
            at[place, 0] = at[above, 0] + (vx + aw * tx + ay * tz - az * ty)
            at[place, 1] = at[above, 1] + (vy + aw * ty + az * tx - ax * tz)
            at[place, 2] = at[above, 2] + (vz + aw * tz + ax * ty - ay * tx)
            bx, by = rotations[frame, joint, 0], rotations[frame, joint, 1]
            bz, bw = rotations[frame, joint, 2], rotations[frame, joint, 3]
            turn[place, 0] = aw * bx + ax * bw + ay * bz - az * by
            turn[place, 1] = aw * by - ax * bz + ay * bw + az * bx
            turn[place, 2] = aw * bz + ax * by - ay * bx + az * bw
            turn[place, 3] = aw * bw - ax * bx - ay * by - az * bz
        for number in range(len(wanted)):
            for i in range(3):
                positions[frame, number, i] = at[wanted[number], i]
        for number in range(world.shape[1]):
            for i in range(4):
                world[frame, number, i] = turn[wanted[number], i]
