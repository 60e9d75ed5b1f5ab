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
    local = np.asarray(rotations, np.float64)
    positions = np.empty((*local.shape[:2], 3))
    world = np.empty_like(local)
    positions[:, 0], world[:, 0] = root_positions, local[:, 0]
    for joint in range(1, skeleton.joint_count):
        parent = skeleton.parents[joint]
        positions[:, joint] = positions[:, parent] + quaternion.rotate(world[:, parent], skeleton.offsets[joint])
        world[:, joint] = quaternion.multiply(world[:, parent], local[:, joint])
    return positions, world


def local_rotations(skeleton: Skeleton, world: Floats) -> Floats:
    """Returns the rotations [..., J, 4] in the parents' frames, from those in the world [..., J, 4]."""
    local = world.copy()
    above = quaternion.conjugate(world[..., skeleton.parents[1:], :])
    local[..., 1:, :] = quaternion.multiply(above, world[..., 1:, :])
    return local


def bind_positions(skeleton: Skeleton) -> Floats:
    """Returns the positions [J, 3] of the joints in the bind pose, metres, with the root at the origin."""
    positions = np.zeros((skeleton.joint_count, 3))
    for joint in range(1, skeleton.joint_count):
        positions[joint] = positions[skeleton.parents[joint]] + skeleton.offsets[joint]
    return positions


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
