"""Moves clips of any rig onto one skeleton: that of a bank, a character or a file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError, listed
from motionsplice.motion.hand_joints import fingered, has_fingers
from motionsplice.motion.kinematics import bind_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.by_roles import retarget
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import LIMBS, Roles
from motionsplice.motion.skeleton import Skeleton

OTHER_LIMB = 10.0  # rig sizes: joints of different limbs are matched only if nothing else is left
WIDEST_BIND_ANGLE = np.radians(25.0)  # radians between the same bone of two rigs in their bind poses
SAME_LENGTHS = 1e-3  # rigs whose bones differ less, relative to their length, are one rig, bound in two poses if at all
WIDEST_OF_ONE_RIG = np.radians(2.0)
RETARGETED = "retargeted by roles"  # begins a note


@dataclass(frozen=True, eq=False)
class Fitted:
    """A clip on the skeleton, and notes on how it came there."""

    clip: Clip
    notes: tuple[str, ...] = ()


def onto_rig(clip: Clip, roles: Roles, rig: Rig, *, retargeting: bool = True) -> Fitted:
    """Puts a clip on a rig's skeleton, and scales its root path by the ratio of the leg lengths.

    If the rigs have the same topology, but for missing fingers, and the same bind pose, the rotations are copied; bone
    lengths, joint order and joint names may differ (CMU's two releases do). Other rigs are retargeted by roles.

    Args:
        clip: The motion.
        roles: The roles of its joints.
        rig: The skeleton, and what is known of it.
        retargeting: Whether other rigs are retargeted.

    Raises:
        SkeletonError: The legs have no length, or the rigs differ and `retargeting` is off.
    """
    try:
        return Fitted(_copied(clip, roles, rig))
    except SkeletonError as difference:
        if not retargeting:
            raise
        moved = retarget(clip, roles, rig.skeleton, rig.roles, rig.pose)
        notes = [f"{RETARGETED}: {difference.problem}"]
    if moved.left_out:
        notes.append(f"not carried over, the skeleton has no such joints: {listed(list(moved.left_out))}")
    return Fitted(moved.clip, tuple(notes))


def _copied(clip: Clip, roles: Roles, rig: Rig) -> Clip:
    """Returns the clip with its rotations unchanged on the other skeleton. Raises SkeletonError if the rigs differ."""
    skeleton, skeleton_roles = rig.skeleton, rig.roles
    if clip.skeleton == skeleton and roles == skeleton_roles:
        return Clip.of_valid(clip.name, skeleton, clip.rate, clip.root_positions, clip.rotations)
    if has_fingers(skeleton, skeleton_roles):
        clip, roles = fingered(clip, roles, skeleton, skeleton_roles)
    match = _match(clip, roles, skeleton, skeleton_roles)
    for role in (*LIMBS, "pelvis", "spine"):
        theirs, ours = (np.atleast_1d(getattr(found, role)).tolist() for found in (roles, skeleton_roles))
        if [match.index(joint) for joint in theirs] != ours:
            raise SkeletonError(
                f"its {role} is not the same joint as the skeleton's {role}",
                mend="Name the joints of both rigs in a roles file and pass it as --roles, or allow retargeting",
            )
    _check_bind_poses(clip, match, skeleton, skeleton_roles)
    scale = skeleton_roles.leg_length(skeleton) / roles.leg_length(clip.skeleton)
    rotations = clip.rotations if match == sorted(match) else np.take(clip.rotations, match, axis=1)
    return Clip.of_valid(clip.name, skeleton, clip.rate, clip.root_positions * scale, rotations)


def _match(clip: Clip, roles: Roles, ours: Skeleton, our_roles: Roles) -> list[int]:
    """Returns their joint for each of ours, matched by name, else by the tree's shape, roles and where limbs point."""
    theirs = clip.skeleton
    if set(theirs.names) == set(ours.names):
        match = [theirs.index(joint) for joint in ours.names]
        parents = [-1 if parent < 0 else match[parent] for parent in ours.parents]
        if parents == theirs.parents[match].tolist():
            return match
    match = [0] * ours.joint_count
    reach_theirs, reach_ours = _reach(theirs), _reach(ours)
    limbs_theirs, limbs_ours = _limbs(theirs, roles), _limbs(ours, our_roles)
    for joint in range(ours.joint_count):
        a, b = theirs.children[match[joint]], ours.children[joint]
        if len(a) != len(b):
            raise SkeletonError(
                f"the rigs have different topologies: children of its joint {theirs.names[match[joint]]!r}: {len(a)}, "
                f"of the skeleton's {ours.names[joint]!r}: {len(b)}",
                mend="Allow retargeting, or build a separate bank for it",
            )
        if b:
            apart = np.linalg.norm(reach_theirs[list(a), None] - reach_ours[None, list(b)], axis=-1)
            apart += [[OTHER_LIMB * (limbs_theirs[i] != limbs_ours[j]) for j in b] for i in a]
            for their_child, our_child in zip(*linear_sum_assignment(apart), strict=True):
                match[b[our_child]] = a[their_child]
    return match


def _limbs(skeleton: Skeleton, roles: Roles) -> list[frozenset[str]]:
    """Returns the limb roles below each joint, itself included."""
    joints = {role: skeleton.chain(getattr(roles, role)) for role in LIMBS}
    return [frozenset(role for role in LIMBS if joint in joints[role]) for joint in range(skeleton.joint_count)]


def _reach(skeleton: Skeleton) -> Floats:
    """Returns the centre of each joint's subtree in the bind pose [J, 3], in units of the rig's size."""
    rest = bind_positions(skeleton)
    middle = np.array([rest[skeleton.subtree(joint)].mean(axis=0) for joint in range(skeleton.joint_count)])
    return np.asarray(middle / np.abs(rest).max())


def _check_bind_poses(clip: Clip, match: list[int], skeleton: Skeleton, roles: Roles) -> None:
    names = [f"{side} {part}" for side in ("left", "right") for part in ("knee", "ankle", "elbow", "wrist")]
    joints = [getattr(roles, name.replace(" ", "_")) for name in names]
    ours, theirs = skeleton.offsets[joints], clip.skeleton.offsets[[match[joint] for joint in joints]]
    apart = quaternion.angle(quaternion.between(theirs, ours), quaternion.IDENTITY)
    ratios = np.linalg.norm(theirs, axis=1) / np.maximum(np.linalg.norm(ours, axis=1), 1e-12)
    widest = WIDEST_OF_ONE_RIG if np.ptp(ratios) < SAME_LENGTHS * ratios.max() else WIDEST_BIND_ANGLE
    if apart.max() > widest:
        worst = int(np.argmax(apart))
        raise SkeletonError(
            f"its bind pose differs from the skeleton's: the bone to the {names[worst]} points "
            f"{np.degrees(apart[worst]):.0f} degrees away",
            mend="Export the clip with the bind pose of the skeleton, or allow retargeting",
        )
