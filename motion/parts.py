"""The parts of an upper body that an action may drive: trunk, arms, head."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.roles import Roles, common_ancestor
from motionsplice.motion.skeleton import Skeleton

TRUNK, LEFT_ARM, RIGHT_ARM, HEAD_AND_NECK = 1, 2, 4, 8
PARTS = 4
UPPER_BODY = 15
PART_NAMES = ("trunk", "left arm", "right arm", "head")  # in order of their bits
TWIN_PARTS = (0, 2, 1, 3)  # the number of the part that is each part's mirror image

Mask = Literal["upper_body", "left_arm", "right_arm", "arms", "head"]
MASKS: Mapping[str, int] = {
    "upper_body": UPPER_BODY,
    "left_arm": LEFT_ARM,
    "right_arm": RIGHT_ARM,
    "arms": LEFT_ARM | RIGHT_ARM,
    "head": HEAD_AND_NECK,
}


def chains_to_limbs(skeleton: Skeleton, roles: Roles) -> dict[int, list[int]]:
    """Returns, by part, the joints from the pelvis's child to the first joint of each limb: collar bone or neck.

    The list is empty for a limb that the rig does not have, or whose roles do not show where it leaves the spine.
    """
    tip = roles.neck if roles.neck >= 0 else roles.head
    tips = {LEFT_ARM: roles.left_shoulder, RIGHT_ARM: roles.right_shoulder, HEAD_AND_NECK: tip}
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    return {part: _chain(skeleton, roles.pelvis, chest, tip) for part, tip in tips.items()}


def _chain(skeleton: Skeleton, pelvis: int, chest: int, tip: int) -> list[int]:
    chain = skeleton.chain(tip)[::-1] if tip >= 0 else []
    if chest not in chain or pelvis not in skeleton.chain(chest) or chain[-1] == chest:
        return []
    return [int(joint) for joint in chain[chain.index(pelvis) + 1 : chain.index(chest) + 2]]


def part_of_joint(skeleton: Skeleton, roles: Roles) -> NDArray[np.int64]:
    """Returns the number [J] of each joint's part, 0 to PARTS - 1; 0 for all joints that are on no limb."""
    parts = np.zeros(skeleton.joint_count, np.int64)
    for part, chain in chains_to_limbs(skeleton, roles).items():
        if chain:
            parts[skeleton.subtree(chain[-1])] = part.bit_length() - 1
    return parts
