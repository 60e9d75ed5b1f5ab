"""World positions and rotations of a few joints: forward kinematics of these joints and their ancestors only."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import ClassVar

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import follow_joints
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Integers, Skeleton
from motionsplice.precompute.body.turned_points import turned_points


class Followed(Clip):
    """A clip whose joints with roles have been followed once, for all that ask for their paths."""

    _followed: ClassVar[tuple[dict[int, int], Floats, Floats] | None] = None  # places of joints in the two arrays

    @classmethod
    def of(cls, clip: Clip, roles: Roles) -> Followed:
        """Follows the joints of a clip that have roles, and the pelvis's parent."""
        one = cls.of_valid(clip.name, clip.skeleton, clip.rate, clip.root_positions, clip.rotations)
        with_roles = {joint for role, joint in vars(roles).items() if role != "spine"} - {-1}  # -1: no such toe
        joints = sorted({int(clip.skeleton.parents[roles.pelvis]), *roles.spine, *with_roles})
        places = {joint: place for place, joint in enumerate(joints)}
        object.__setattr__(one, "_followed", (places, *joint_transforms(clip, joints)))
        return one

    def places(self, joints: Sequence[int]) -> list[int] | None:
        """Returns where joints are among those that have been followed; None if one of them is not."""
        known = {} if self._followed is None else self._followed[0]
        return [known[joint] for joint in joints] if known.keys() >= set(joints) else None

    def positions(self, places: Sequence[int]) -> Floats:
        assert self._followed is not None
        return np.take(self._followed[1], places, axis=1)

    def world(self, places: Sequence[int]) -> Floats:
        assert self._followed is not None
        return np.take(self._followed[2], places, axis=1)


def joint_paths(clip: Clip, joints: Sequence[int]) -> Floats:
    """Returns the world positions [F, n, 3] of n joints of a clip, metres."""
    if isinstance(clip, Followed) and (places := clip.places(joints)):
        return clip.positions(places)
    return joint_transforms(clip, joints)[0]


def joint_transforms(clip: Clip, joints: Sequence[int], step: int = 1) -> tuple[Floats, Floats]:
    """Returns the world positions [F, n, 3] in metres and world rotations [F, n, 4] of n joints of a clip.

    With a `step`, only every so many-th frame is computed. The results agree with `motion.kinematics.world_transforms`,
    which computes all joints.
    """
    if isinstance(clip, Followed) and step == 1 and (places := clip.places(joints)):
        return clip.positions(places), clip.world(places)
    roots, rotations = (np.ascontiguousarray(rows[::step]) for rows in (clip.root_positions, clip.rotations))
    positions, world = np.empty((len(roots), len(joints), 3)), np.empty((len(roots), len(joints), 4))
    follow_joints(*_chains(clip.skeleton, tuple(joints)), roots, rotations, positions, world)
    return positions, world


@lru_cache(maxsize=64)  # clips of a bank share its skeleton
def _chains(skeleton: Skeleton, joints: tuple[int, ...]) -> tuple[Integers, Integers, Floats, Integers]:
    """Returns the first arguments of `follow_joints`."""
    needed = np.array(sorted({above for joint in joints for above in skeleton.chain(joint)}))
    places = {int(joint): place for place, joint in enumerate(needed)}
    parents = np.array([places.get(int(skeleton.parents[joint]), -1) for joint in needed])
    return needed, parents, skeleton.offsets[needed], np.array([places[joint] for joint in joints])


def upper_joints(clip: Clip, roles: Roles, step: int = 1) -> Floats:
    """Returns the positions [F, n, 3] of the upper body's joints in the pelvis's frame at every `step`-th frame."""
    positions, world = joint_transforms(clip, clip.skeleton.subtree(roles.pelvis), step)
    return turned_points(quaternion.conjugate(world[:, 0]), positions[:, 1:] - positions[:, :1])
