"""The limbs of an upper body, and where they hang on the trunk."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.parts import PARTS, chains_to_limbs, part_of_joint
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.characters.arrays import Limbs
from motionsplice.runtime.format.rows import FIRST_JOINT, Layout


def limbs_of(skeleton: Skeleton, roles: Roles, layout: Layout) -> Limbs:
    """Returns the limbs, each from where it leaves the spine: arms with collar bones, the head with the neck."""
    parts = part_of_joint(skeleton, roles)[list(layout.upper.joints)]
    part_lanes = np.zeros((PARTS, layout.upper.width), np.float32)
    part_lanes[parts, FIRST_JOINT + np.arange(len(parts))] = 1.0
    chain_of = chains_to_limbs(skeleton, roles)
    longest = max((len(chain) for chain in chain_of.values()), default=0)
    attachments, lengths = np.full(PARTS, -1, np.int64), np.zeros(PARTS, np.int64)
    chains, columns = np.zeros((PARTS, max(longest, 1)), np.int64), np.zeros((PARTS, max(longest, 1)), np.uint64)
    lanes = {joint: FIRST_JOINT + number for number, joint in enumerate(layout.upper.joints)}
    for part, chain in chain_of.items():
        number = part.bit_length() - 1
        if chain:
            attachments[number], lengths[number] = lanes[chain[-1]], len(chain)
            chains[number, : len(chain)] = [lanes[joint] for joint in chain]
            columns[number, : len(chain)] = [4 * joint for joint in chain]
    return Limbs(1 << parts, part_lanes, attachments, lengths, chains, columns)
