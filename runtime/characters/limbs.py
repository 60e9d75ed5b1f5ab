"""The parts of an upper body that an action may own: trunk, arms, head."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.roles import Roles, common_ancestor
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.characters.state import HEAD_AND_NECK, LEFT_ARM, PARTS, RIGHT_ARM
from motionsplice.runtime.format.rows import FIRST_JOINT, Layout


def limbs_of(skeleton: Skeleton, roles: Roles, layout: Layout) -> Limbs:
    """Returns the limbs, each from where it leaves the spine: arms with collar bones, the head with the neck."""
    part_of_lane = np.zeros(layout.upper.width, np.int64)
    chain_of = {part: chain_to_limb(skeleton, roles, tip) for part, tip in tips(roles).items()}
    longest = max((len(chain) for chain in chain_of.values()), default=0)
    attachments, lengths = np.full(PARTS, -1, np.int64), np.zeros(PARTS, np.int64)
    chains, columns = np.zeros((PARTS, max(longest, 1)), np.int64), np.zeros((PARTS, max(longest, 1)), np.uint64)
    lanes = {joint: FIRST_JOINT + number for number, joint in enumerate(layout.upper.joints)}
    for part, chain in chain_of.items():
        number = part.bit_length() - 1
        if chain:
            for joint in skeleton.subtree(chain[-1]):
                part_of_lane[lanes[joint]] = number
            attachments[number], lengths[number] = lanes[chain[-1]], len(chain)
            chains[number, : len(chain)] = [lanes[joint] for joint in chain]
            columns[number, : len(chain)] = [4 * joint for joint in chain]
    return Limbs(part_of_lane, attachments, lengths, chains, columns)


def tips(roles: Roles) -> dict[int, int]:
    """Returns a joint of each limb."""
    tip = roles.neck if roles.neck >= 0 else roles.head
    return {LEFT_ARM: roles.left_shoulder, RIGHT_ARM: roles.right_shoulder, HEAD_AND_NECK: tip}


def chain_to_limb(skeleton: Skeleton, roles: Roles, tip: int) -> list[int]:
    """Returns the joints from the pelvis's child to the first joint of a limb; empty if the rig is built otherwise."""
    arms = (roles.left_shoulder, roles.right_shoulder)
    chest = common_ancestor(skeleton.parents, arms)
    chain = skeleton.chain(tip)[::-1] if tip >= 0 else []
    if chest not in chain or roles.pelvis not in skeleton.chain(chest) or chain[-1] == chest:
        return []
    return [int(joint) for joint in chain[chain.index(roles.pelvis) + 1 : chain.index(chest) + 2]]
