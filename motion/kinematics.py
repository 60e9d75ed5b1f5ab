"""Forward kinematics."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton


def world_transforms(skeleton: Skeleton, root_positions: ArrayLike, rotations: ArrayLike) -> tuple[Floats, Floats]:
    """Returns the world positions [F, J, 3] in metres and world rotations [F, J, 4] of every joint.

    root_positions [F, 3] and local rotations [F, J, 4] are as in a clip.
    """
    from motionsplice.motion.followed_joints import follow_joints  # Numba takes half a second, and `inspect` needs none

    local = np.ascontiguousarray(rotations, np.float64)
    roots = np.ascontiguousarray(np.broadcast_to(np.asarray(root_positions, np.float64), (len(local), 3)))
    parents = np.ascontiguousarray(skeleton.parents, np.int64)
    offsets = np.ascontiguousarray(skeleton.offsets, np.float64)
    joints = np.arange(skeleton.joint_count)
    positions, world = np.empty((*local.shape[:2], 3)), np.empty_like(local)
    follow_joints(joints, parents, offsets, joints, roots, local, positions, world)
    return positions, world


def local_rotations(skeleton: Skeleton, world: Floats) -> Floats:
    """Returns the rotations [..., J, 4] in the parents' frames, from those in the world [..., J, 4]."""
    local = world.copy()
    above = quaternion.conjugate(world[..., skeleton.parents[1:], :])
    local[..., 1:, :] = quaternion.multiply(above, world[..., 1:, :])
    return local


def bind_positions(skeleton: Skeleton) -> Floats:
    """Returns the positions [J, 3] of the joints in the bind pose, metres, with the root at the origin."""
    positions = skeleton.offsets.tolist()
    positions[0] = [0.0, 0.0, 0.0]
    for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
        positions[joint] = [a + b for a, b in zip(positions[parent], positions[joint], strict=True)]
    return np.array(positions, np.float64)


def joint_positions(clip: Clip) -> Floats:
    """Returns the world positions [F, J, 3] in metres of a clip's joints."""
    return world_transforms(clip.skeleton, clip.root_positions, clip.rotations)[0]


def hips_heading(positions: Floats, roles: Roles) -> Floats:
    """Returns the heading of the hips [...], radians about Y from +Z, from world positions of joints [..., J, 3]."""
    return heading(positions[..., roles.left_hip, :] - positions[..., roles.right_hip, :])


def heading(hip_line: Floats) -> Floats:
    """Returns the heading [...], as `hips_heading`, from the vectors [..., 3] from the right to the left hip."""
    return np.arctan2(-hip_line[..., 2], hip_line[..., 0])


def end_positions(skeleton: Skeleton, positions: Floats, world: Floats) -> Floats:
    """Returns the world positions [F, E, 3] of the end sites, from the two results of `world_transforms`."""
    at = skeleton.end_parents
    return np.asarray(positions[:, at] + quaternion.rotate(world[:, at], skeleton.end_offsets))
