"""Which joint of a rig is the mirror image of which."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.role_names import words_of
from motionsplice.motion.roles import SIDES, Roles
from motionsplice.motion.skeleton import Integers, Skeleton

FARTHEST = 0.15  # of the leg length: what hangs farther from the other's mirror image is not its twin
BY_ROLE, BY_NAME, BY_PLACE = range(3)
MIRROR = np.array([-1.0, 1.0, 1.0])  # of a body that faces Z: left and right change places


def twins_of(skeleton: Skeleton, roles: Roles, standing: Floats) -> Integers:
    """Returns each joint's twin [J]: itself in the middle of the body, -1 for one that has none, such as a weapon.

    Twins have the same role, else the same name but for the side, else mirrored places. A joint can only have a twin
    below its parent's twin.

    Args:
        skeleton: The rig.
        roles: The roles of its joints.
        standing: [J, 3] metres, the joints' places in the standing pose, with the root at the origin.

    Raises:
        SkeletonError: A limb has a joint that the other side does not have.
    """
    twins, pending = np.full(skeleton.joint_count, -1), [(0, 0)]
    search = _Search(skeleton, roles, standing)
    while pending:
        one, other = pending.pop()
        twins[one], twins[other] = other, one
        pending += search.children(one, other)
    for joint, wanted in search.opposite.items():
        if twins[joint] != wanted:
            pair = f"{skeleton.names[joint]!r} and {skeleton.names[wanted]!r}"
            problem = f"the rig cannot be mirrored: {pair} do not hang on joints that are twins"
            raise SkeletonError(problem, mend="Export the rig with the same joints on both sides")
    return twins


class _Search:
    def __init__(self, skeleton: Skeleton, roles: Roles, standing: Floats) -> None:
        self.skeleton, self.farthest = skeleton, FARTHEST * roles.leg_length(skeleton)
        below = [skeleton.subtree(joint) for joint in range(skeleton.joint_count)]
        hung = standing[np.maximum(skeleton.parents, 0)]
        self.hanging = np.array([standing[joints].mean(axis=0) for joints in below]) - hung
        self.opposite = opposite_roles(roles)
        self.limbs = [self.opposite.keys() & set(joints) for joints in below]
        self.words = [words_of(name) for name in skeleton.names]

    def children(self, one: int, other: int) -> Iterator[tuple[int, int]]:
        """Yields the pairs of twins among the children of two twins, the best pairs first."""
        pairs = [(a, b) for a in self.skeleton.children[one] for b in self.skeleton.children[other]]
        found = [(*fit, a, b) for a, b in pairs if (fit := self.fit(a, b)) is not None]
        taken: set[tuple[bool, int]] = set()
        for _, _, a, b in sorted(found):
            if (False, a) in taken or (True, b) in taken:
                continue
            taken |= {(False, a), (True, b)} | ({(False, b), (True, a)} if one == other else set())
            yield a, b

    def fit(self, a: int, b: int) -> tuple[int, float] | None:
        """Returns how a joint is the twin of another, and how far it is from its mirror image; None if it is not."""
        away = float(np.linalg.norm(self.hanging[a] * MIRROR - self.hanging[b]))
        if self.limbs[a] or self.limbs[b]:
            return (BY_ROLE, away) if {self.opposite[one] for one in self.limbs[a]} & self.limbs[b] else None
        (words, side), (other_words, other_side) = self.words[a], self.words[b]
        if side and other_side and side != other_side and words == other_words:
            return BY_NAME, away
        return (BY_PLACE, away) if away <= self.farthest else None


def opposite_roles(roles: Roles) -> dict[int, int]:
    """Returns the joint of the same role on the other side, by joint; the joint itself for a role without a side."""
    opposite = {joint: joint for joint in (roles.root, roles.pelvis, *roles.spine, roles.neck, roles.head)}
    for field in fields(Roles):
        for side, other in (SIDES, SIDES[::-1]):
            if field.name.startswith(side):
                opposite[getattr(roles, field.name)] = getattr(roles, field.name.replace(side, other))
    return {joint: other for joint, other in opposite.items() if joint >= 0 and other >= 0}
