"""Poses as VRM, VRM animations and VMC state them: of a person's bones, which are not turned in the T-pose."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.formats.gltf.humanoid import ROLES
from motionsplice.motion.hand_joints import finger_places, fingers_of
from motionsplice.motion.quaternion import IDENTITY, Floats
from motionsplice.motion.roles import SIDES, Roles, common_ancestor
from motionsplice.motion.skeleton import Skeleton

TRUNK = {1: ("spine",), 2: ("spine", "chest"), 3: ("spine", "chest", "upperChest")}
FINGERS = {"thumb": "Thumb", "index": "Index", "middle": "Middle", "ring": "Ring", "pinky": "Little"}
PHALANGES = ("Proximal", "Intermediate", "Distal")
THUMB = ("Metacarpal", "Proximal", "Distal")


def vrm_bones(skeleton: Skeleton, roles: Roles) -> dict[int, str]:
    """Returns VRM's bone of each joint that has one. Of a long spine, three joints do."""
    bones = {roles.root: "hips"}
    trunk = [roles.pelvis, *(joint for joint in roles.spine if joint != roles.neck)]
    if len(trunk) > len(TRUNK):
        trunk = [trunk[0], trunk[len(trunk) // 2], trunk[-1]]
    bones |= dict(zip(trunk, TRUNK[len(trunk)], strict=True))
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    for side in SIDES:
        collar = int(skeleton.parents[getattr(roles, f"{side}_shoulder")])
        if collar != chest:
            bones[collar] = f"{side}Shoulder"
        for joint, (finger, place) in finger_places(skeleton, fingers_of(skeleton, roles, side)).items():
            phalanges = THUMB if finger == "thumb" else PHALANGES
            if 1 <= place <= len(phalanges):
                bone = f"{side}{FINGERS[finger]}{phalanges[place - 1]}"
                if bone not in bones.values():
                    bones[joint] = bone
    return bones | {joint: bone for bone, role in ROLES.items() if (joint := int(getattr(roles, role))) >= 0}


class Humanoid:
    """The n bones of a person in a rig, parents first.

    A bone's frame is aligned with the world in the T-pose. Joints without a bone are part of the next bone below. In
    rigs such as 3ds Max Biped, collar bones are children of the neck. Here they are below the chest, as VRM and Unity
    have them, and the neck joint is part of them as well as a bone.

    Args:
        skeleton: The rig, with J joints.
        roles: The roles of its joints.
        straight: [J, 4] world rotations of its joints in the T-pose.

    Attributes:
        bones: VRM's names of the bones.
        joints: The joint of each bone; the first is the root's.
        above: The index of the bone above each bone; -1 for the hips.
    """

    def __init__(self, skeleton: Skeleton, roles: Roles, straight: Floats) -> None:
        named = vrm_bones(skeleton, roles)
        self.joints = sorted(named)
        self.bones = [named[joint] for joint in self.joints]
        carriers = named.keys() - {roles.neck}
        paths = [_path(skeleton, joint, named if named[joint] == "head" else carriers) for joint in self.joints]
        above = [int(skeleton.parents[path[0]]) for path in paths]
        self.above = [self.joints.index(joint) if joint >= 0 else -1 for joint in above]
        self._before = np.array([straight[joint] if joint >= 0 else IDENTITY for joint in above])
        self._after = quaternion.conjugate(straight[self.joints])
        # column k: of each bone, the joint k steps above its own one, as far as the next bone; else J, which is still
        longest = max(map(len, paths))
        self._steps = np.full((len(paths), longest), skeleton.joint_count)
        for row, path in zip(self._steps, paths, strict=True):
            row[: len(path)] = path[::-1]
        self._offsets = np.concatenate([skeleton.offsets, np.zeros((1, 3))])
        self._offsets[0] = 0.0

    def local(self, root_positions: NDArray[Any], rotations: NDArray[Any]) -> tuple[Floats, Floats]:
        """Returns a motion's positions [..., n, 3] and rotations [..., n, 4], each relative to the bone above.

        root_positions [..., 3] and rotations [..., J, 4] are as in a clip. The hips' are relative to the world.
        """
        still = np.broadcast_to(IDENTITY, (*rotations.shape[:-2], 1, 4))
        joints = np.concatenate([rotations, still], axis=-2)
        positions, turns = self._offsets[self._steps[:, 0]], joints[..., self._steps[:, 0], :]
        for step in self._steps.T[1:]:
            positions = self._offsets[step] + quaternion.rotate(joints[..., step, :], positions)
            turns = quaternion.multiply(joints[..., step, :], turns)
        positions = np.broadcast_to(quaternion.rotate(self._before, positions), (*turns.shape[:-1], 3)).copy()
        positions[..., 0, :] = root_positions
        return positions, quaternion.multiply(quaternion.multiply(self._before, turns), self._after)


def _path(skeleton: Skeleton, joint: int, named: Container[int]) -> list[int]:
    """Returns the joints from below the next bone above down to a joint, which is included."""
    path = [joint]
    while (parent := int(skeleton.parents[path[0]])) >= 0 and parent not in named:
        path.insert(0, parent)
    return path
