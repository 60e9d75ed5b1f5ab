"""The chains of a rig's legs, for the foot lock."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.characters.arrays import Legs

REACH = 0.14  # leg lengths: the farthest that a foot lock holds a foot from its pose


def legs_of(skeleton: Skeleton, roles: Roles) -> Legs:
    """Returns both legs; empty ones if an ankle does not hang on its knee, or a knee on its hip."""
    ends = ((roles.left_hip, roles.left_knee, roles.left_ankle), (roles.right_hip, roles.right_knee, roles.right_ankle))
    chains = [skeleton.chain(ankle)[-2::-1] for _, _, ankle in ends]
    at = [
        [chain.index(joint) if joint in chain else -1 for joint in leg] for leg, chain in zip(ends, chains, strict=True)
    ]
    longest = max(len(chain) for chain in chains)
    columns, offsets = np.zeros((2, longest), np.uint64), np.zeros((2, longest, 3))
    fits = all(0 <= hip < knee < ankle for hip, knee, ankle in at)
    for number, chain in enumerate(chains):
        columns[number, : len(chain)] = np.multiply(chain, 4)
        offsets[number, : len(chain)] = skeleton.offsets[chain]
    hips, knees, ankles = np.array(list(zip(*at, strict=True)))
    counts = ankles + 1 if fits else np.zeros(2, np.int64)
    reach = REACH * roles.leg_length(skeleton) if fits else 1.0
    return Legs(columns, offsets, counts, hips, knees, reach)
