"""The parts of an upper body that an action may own: trunk, arms, head."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.roles import Roles, common_ancestor
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.characters.state import HEAD_AND_NECK, LEFT_ARM, PARTS, RIGHT_ARM
from motionsplice.runtime.format.rows import FIRST_JOINT, Layout


def limbs_of(skeleton: Skeleton, roles: Roles, layout: Layout) -> Limbs:
    """Each limb from where it parts from the spine on: arms with their collar bones, the head with its neck."""
    part_of_lane = np.zeros(layout.upper.width, np.int64)
    ways = {part: chain_to_limb(skeleton, roles, tip) for part, tip in tips(roles).items()}
    longest = max((len(way) for way in ways.values()), default=0)
    attachments, lengths = np.full(PARTS, -1, np.int64), np.zeros(PARTS, np.int64)
    chains, columns = np.zeros((PARTS, max(longest, 1)), np.int64), np.zeros((PARTS, max(longest, 1)), np.uint64)
    lanes = {joint: FIRST_JOINT + number for number, joint in enumerate(layout.upper.joints)}
    for part, way in ways.items():
        number = part.bit_length() - 1
        if way:
            for joint in skeleton.subtree(way[-1]):
                part_of_lane[lanes[joint]] = number
            attachments[number], lengths[number] = lanes[way[-1]], len(way)
            chains[number, : len(way)] = [lanes[joint] for joint in way]
            columns[number, : len(way)] = [4 * joint for joint in way]
    return Limbs(part_of_lane, attachments, lengths, chains, columns)


def tips(roles: Roles) -> dict[int, int]:
    """A joint of each limb."""
    tip = roles.neck if roles.neck >= 0 else roles.head
    return {LEFT_ARM: roles.left_shoulder, RIGHT_ARM: roles.right_shoulder, HEAD_AND_NECK: tip}


def chain_to_limb(skeleton: Skeleton, roles: Roles, tip: int) -> list[int]:
    """The joints from the pelvis's child to where a limb parts from the spine; none if the rig is not so built."""
    arms = (roles.left_shoulder, roles.right_shoulder)
    chest = common_ancestor(skeleton.parents, arms)
    chain = skeleton.chain(tip)[::-1] if tip >= 0 else []
    if chest not in chain or roles.pelvis not in skeleton.chain(chest) or chain[-1] == chest:
        return []
    return [int(joint) for joint in chain[chain.index(roles.pelvis) + 1 : chain.index(chest) + 2]]
