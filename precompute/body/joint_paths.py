"""World positions and rotations of a few joints: forward kinematics of these joints and their ancestors only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles


def joint_paths(clip: Clip, joints: Sequence[int]) -> Floats:
    """Returns the world positions [F, n, 3] of n joints of a clip, metres."""
    return joint_transforms(clip, joints)[0]


def joint_transforms(clip: Clip, joints: Sequence[int], step: int = 1) -> tuple[Floats, Floats]:
    """Returns the world positions [F, n, 3] in metres and world rotations [F, n, 4] of n joints of a clip.

    With a `step`, only every so many-th frame is computed. The results agree with `motion.kinematics.world_transforms`,
    which computes all joints.
    """
    needed = np.array(sorted({above for joint in joints for above in clip.skeleton.chain(joint)}))
    places = {int(joint): place for place, joint in enumerate(needed)}
    parents = np.array([places.get(int(clip.skeleton.parents[joint]), -1) for joint in needed])
    wanted = np.array([places[joint] for joint in joints])
    roots, rotations = (np.ascontiguousarray(rows[::step]) for rows in (clip.root_positions, clip.rotations))
    positions, world = np.empty((len(roots), len(joints), 3)), np.empty((len(roots), len(joints), 4))
    follow_joints(needed, parents, clip.skeleton.offsets[needed], wanted, roots, rotations, positions, world)
    return positions, world


def upper_joints(clip: Clip, roles: Roles, step: int = 1) -> Floats:
    """Returns the positions [F, n, 3] of the upper body's joints in the pelvis's frame at every `step`-th frame."""
    positions, world = joint_transforms(clip, clip.skeleton.subtree(roles.pelvis), step)
    return quaternion.rotate(quaternion.conjugate(world[:, :1]), positions[:, 1:] - positions[:, :1])


@njit(cache=True, nogil=True, error_model="numpy")
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
    """Fills `positions` [F, n, 3] and `world` [F, n, 4] for the joints needed[wanted], with `wanted` [n].

    `needed` [m] are joints, the root first and parents before children. `parents` [m] and `wanted` are indices into it.
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
            for i in range(4):
                world[frame, number, i] = turn[wanted[number], i]
