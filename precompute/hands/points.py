"""The four points of a hand, relative to its shoulder, by which two performances of a gesture are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.hand_joints import ahead_of, elbow_of, forearm, wrist_of
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats, rotate
from motionsplice.motion.roles import Roles, Side
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.body.joint_paths import joint_transforms

THUMB_SIDE, LITTLE_SIDE, FOREARM, HAND = 0, 1, 2, 3  # indices of the points
WRIST_WIDTH = 0.12  # of the forearm's length, from the middle of the wrist to each side
TINY = 1e-9  # metres
KNUCKLES = 0.35  # of the forearm's length beyond the wrist, on a rig with no joint or end site below the wrist


@dataclass(frozen=True, eq=False)
class HandMotion:
    """One hand over F frames.

    points: [F, 4, 3] metres from the shoulder: thumb side and little side of the wrist, forearm, hand. They may be
    markers, or the points that `hand_motion` derives from joints. trunk: [F] heading of the trunk, radians about Y;
    None if unknown. Raises ClipError for arrays of other shapes, or numbers that are not finite.
    """

    points: Floats
    trunk: Floats | None = None

    def __post_init__(self) -> None:
        count = len(self.points)
        if self.points.shape != (count, 4, 3) or (self.trunk is not None and self.trunk.shape != (count,)):
            raise ClipError("a hand needs four points [F, 4, 3] and one trunk angle [F] per frame")
        if not np.isfinite(self.points).all() or not (self.trunk is None or np.isfinite(self.trunk).all()):
            raise ClipError("a point of a hand, or an angle of the trunk, is not a finite number")


def hand_motion(clip: Clip, roles: Roles, side: Side) -> HandMotion:
    """Returns the points of a rig's hand, where markers would be (Majkowska et al. 2006, 3 and 4).

    The sides of the wrist turn with the forearm. The hand's point is where the fingers begin. Raises SkeletonError if
    the forearm has no length.
    """
    skeleton, wrist = clip.skeleton, wrist_of(roles, side)
    bone, first = forearm(skeleton, roles, side), _firsts(skeleton, wrist)
    shoulders, elbow = [roles.left_shoulder, roles.right_shoulder], elbow_of(roles, side)
    above = int(skeleton.parents[wrist])
    bearers = [joint for joint, _ in first] or [wrist]
    positions, world = joint_transforms(clip, [*shoulders, elbow, wrist, above, *bearers])
    left, right, upper, at = np.moveaxis(positions[:, :4], 1, 0)
    aside = rotate(world[:, 4], WRIST_WIDTH * float(np.linalg.norm(bone)) * ahead_of(bone))
    offsets = np.array([offset for _, offset in first] or [KNUCKLES * bone])
    hand = at + rotate(world[:, 5:], offsets).mean(axis=1)
    shoulder = left if side == "left" else right
    points = np.stack([at + aside, at - aside, 0.5 * (at + upper), hand], axis=1) - shoulder[:, None]
    return HandMotion(points, np.unwrap(heading(left - right)))


def _firsts(skeleton: Skeleton, wrist: int) -> list[tuple[int, Floats]]:
    """Returns the first bones [3] of non-zero length below a wrist, to joints and then to end sites.

    Each comes with its parent joint. A rig may have joints at the wrist's own position, and bend the hand there.
    """
    on_it, found = {wrist}, list[tuple[int, Floats]]()
    for joint in range(wrist + 1, skeleton.joint_count):
        if (parent := int(skeleton.parents[joint])) in on_it:
            if np.any(skeleton.offsets[joint]):
                found.append((parent, skeleton.offsets[joint]))
            else:
                on_it.add(joint)
    ends = zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True)
    return found + [(parent, offset) for parent, offset in ends if parent in on_it and np.any(offset)]


def bones(points: Floats) -> Floats:
    """Returns unit vectors [F, 2, 3] from the wrist along forearm and hand (equation 8), from points [F, 4, 3]."""
    wrist = 0.5 * (points[:, THUMB_SIDE] + points[:, LITTLE_SIDE])
    along = [points[:, FOREARM] - wrist, points[:, HAND] - wrist]
    lengths = [np.maximum(np.linalg.norm(bone, axis=1, keepdims=True), TINY) for bone in along]
    return np.stack([bone / length for bone, length in zip(along, lengths, strict=True)], axis=1)
