"""World positions and rotations of a few joints: forward kinematics of these joints and their ancestors only."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.followed_joints import follow_joints
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Integers, Skeleton
from motionsplice.precompute.body.turned_points import turned_points


class Followed(Clip):
    """A clip whose joints with roles have been followed once, for all that ask for their paths."""

    _known: tuple[dict[int, int], Floats, Floats] = ({}, np.empty((0, 0, 3)), np.empty((0, 0, 4)))

    @classmethod
    def of(cls, clip: Clip, roles: Roles) -> Followed:
        """Follows the joints of a clip that have roles, and keeps the rotations of the pelvis and its parent."""
        one = cls.of_valid(clip.name, clip.skeleton, clip.rate, clip.root_positions, clip.rotations)
        turning = (roles.pelvis, int(clip.skeleton.parents[roles.pelvis]))
        with_roles = {joint for role, joint in vars(roles).items() if role != "spine"} - {-1}  # -1: no such toe
        joints = list(dict.fromkeys((*turning, *roles.spine, *sorted(with_roles))))
        places = {joint: place for place, joint in enumerate(joints)}
        object.__setattr__(one, "_known", (places, *joint_transforms(clip, joints, turning=len(turning))))
        return one

    def transforms(self, joints: Sequence[int], turning: int) -> tuple[Floats, Floats] | None:
        """Returns what `joint_transforms` does, or None if it is not known."""
        places, positions, world = self._known
        at = [places.get(joint, len(places)) for joint in joints]
        if max(at) == len(places) or max(at[:turning], default=-1) >= world.shape[1]:
            return None
        wanted = np.array(at)
        return picked_joints(positions, wanted), picked_joints(world, wanted[:turning])


def joint_paths(clip: Clip, joints: Sequence[int]) -> Floats:
    """Returns the world positions [F, n, 3] of n joints of a clip, metres."""
    return joint_transforms(clip, joints, turning=0)[0]


def joint_transforms(
    clip: Clip, joints: Sequence[int], step: int = 1, turning: int | None = None
) -> tuple[Floats, Floats]:
    """Returns the world positions [F, n, 3] in metres and world rotations [F, n, 4] of n joints of a clip.

    With a `step`, only every so many-th frame is computed; with `turning`, only the rotations of so many joints, the
    first ones. The results agree with `motion.kinematics.world_transforms`, which computes all joints.
    """
    turning = len(joints) if turning is None else turning
    if isinstance(clip, Followed) and step == 1 and (known := clip.transforms(joints, turning)):
        return known
    roots, rotations = (np.ascontiguousarray(rows[::step]) for rows in (clip.root_positions, clip.rotations))
    positions, world = np.empty((len(roots), len(joints), 3)), np.empty((len(roots), turning, 4))
    follow_joints(*_chains(clip.skeleton, tuple(joints)), roots, rotations, positions, world)
    return positions, world


@lru_cache(maxsize=64)  # clips of a bank share its skeleton
def _chains(skeleton: Skeleton, joints: tuple[int, ...]) -> tuple[Integers, Integers, Floats, Integers]:
    """Returns the first arguments of `follow_joints`."""
    needed = np.array(sorted({above for joint in joints for above in skeleton.chain(joint)}))
    places = {int(joint): place for place, joint in enumerate(needed)}
    parents = np.array([places.get(int(skeleton.parents[joint]), -1) for joint in needed])
    return needed, parents, skeleton.offsets[needed], np.array([places[joint] for joint in joints])


@compiled(nogil=True)
def picked_joints(values: Floats, joints: Integers) -> Floats:
    """Returns values[:, joints] of [F, J, n], in C order; NumPy takes several times as long."""
    picked = np.empty((len(values), len(joints), values.shape[2]))
    for frame in range(len(values)):
        for place in range(len(joints)):
            for i in range(values.shape[2]):
                picked[frame, place, i] = values[frame, joints[place], i]
    return picked


def upper_joints(clip: Clip, roles: Roles, step: int = 1) -> Floats:
    """Returns the positions [F, n, 3] of the upper body's joints in the pelvis's frame at every `step`-th frame."""
    positions, world = joint_transforms(clip, clip.skeleton.subtree(roles.pelvis), step, turning=1)
    return turned_points(quaternion.conjugate(world[:, 0]), positions[:, 1:] - positions[:, :1])
