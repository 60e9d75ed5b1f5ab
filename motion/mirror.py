"""The mirror image of a motion: left and right exchanged."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import local_rotations, world_transforms
from motionsplice.motion.quaternion import IDENTITY, Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Integers, Skeleton
from motionsplice.motion.twins import MIRROR, twins_of

FLIP = np.array([1.0, -1.0, -1.0, 1.0])  # the mirror image of a rotation, as a quaternion
NEAR = np.radians(20.0)  # axes of twins that are this near to mirrored axes of the joints are those
LEAST_FIT = 0.05  # of a bone's length: by how much bones of twins may miss each other's mirror image
STIFF = 1e-3  # weight of the standing pose beside bones, for axes that bones leave open


@dataclass(frozen=True, eq=False)
class Mirror:
    """How a rig is mirrored at the plane x = 0.

    The mirror image of joint k has the rotation `turns[parent]^-1 f(q) turns[k]`, where q is the local rotation of its
    twin, and f changes the signs of y and z of a quaternion. A joint without a twin keeps its rotation.

    Attributes:
        twins: [J] the joint on the other side; itself for one in the middle, -1 for one without a twin.
        turns: [J, 4] the rotation from the mirrored axes of the twin to the joint's own; the identity where bind poses
            are symmetric and face Z.
    """

    twins: Integers
    turns: Floats

    @classmethod
    def of(cls, skeleton: Skeleton, roles: Roles, pose: Floats) -> Mirror:
        """Returns how a rig is mirrored.

        Args:
            skeleton: The rig.
            roles: The roles of its joints.
            pose: [J, 4] the joints' world rotations in its standing pose (`standing_pose`).

        Raises:
            SkeletonError: A limb has a joint that the other side does not have.
        """
        local = local_rotations(skeleton, pose)
        twins = twins_of(skeleton, roles, world_transforms(skeleton, np.zeros((1, 3)), local[None])[0][0])
        axes, turns = quaternion.to_matrices(pose), np.tile(IDENTITY, (skeleton.joint_count, 1))
        joints = np.flatnonzero(twins >= np.arange(len(twins)))  # one of both sides, and those in the middle
        found = [
            _axes(skeleton, twins, joint, axes[joint].T @ np.diag(MIRROR) @ axes[twins[joint]])
            for joint in joints.tolist()
        ]
        both = quaternion.from_matrices(np.diag(MIRROR) @ np.stack([[each.T, each] for each in found]))
        turns[joints], turns[twins[joints]] = both[:, 0], both[:, 1]
        return cls(twins, turns)

    def above(self, parents: Integers) -> Floats:
        """Returns the turn [J, 4] of each joint's parent, the identity for the root; parents [J] are the skeleton's."""
        above = self.turns[parents]
        above[0] = IDENTITY
        return above

    def rotations(self, rotations: Floats, parents: Integers) -> Floats:
        """Returns the mirror image of local rotations [..., J, 4]; parents [J] are those of the skeleton."""
        above = self.above(parents)
        image = quaternion.multiply(quaternion.conjugate(above), rotations[..., self.twins, :] * FLIP)
        image = quaternion.multiply(image, self.turns)
        return np.where((self.twins >= 0)[:, None], image, rotations)

    def clip(self, clip: Clip) -> Clip:
        """Returns the mirror image of a clip of the rig. Mirrored twice, it is the clip again."""
        image = self.rotations(clip.rotations, clip.skeleton.parents)
        return replace(clip, root_positions=clip.root_positions * MIRROR, rotations=image)


def _axes(skeleton: Skeleton, twins: Integers, joint: int, standing: Floats) -> Floats:
    """Returns the reflection [3, 3] from a twin's axes to those of a joint, which lays the twin's bones on its own.

    standing: [3, 3] the same as the standing pose has it. It is right where the bind pose is symmetric. Where it was
    found from a motion, its noise is left out.
    """
    children = [child for child in skeleton.children[joint] if twins[child] >= 0]
    own, other = skeleton.offsets[children], skeleton.offsets[twins[children]]
    for found in (_signed_permutation(standing), standing):
        away = np.linalg.norm(other @ found.T - own, axis=-1)
        near = np.trace(found.T @ standing) >= 1.0 + 2.0 * np.cos(NEAR)
        if near and np.all(away <= LEAST_FIT * np.linalg.norm(own, axis=-1)):
            return found
    left, _, right = np.linalg.svd(own.T @ other + STIFF * np.sum(own**2) * standing)
    last = -np.linalg.det(left @ right)
    return np.asarray(left @ np.diag([1.0, 1.0, last]) @ right)


def _signed_permutation(matrix: Floats) -> Floats:
    """Returns the matrix [3, 3] with the largest number of each row as 1 or -1, and 0 elsewhere."""
    largest = np.eye(3)[np.argmax(np.abs(matrix), axis=1)]
    return np.asarray(largest * np.sign(matrix))
