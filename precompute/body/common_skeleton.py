"""Moving clips of differently built performers onto the bank's skeleton."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.hand_joints import fingered, has_fingers
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import LIMBS, Roles
from motionsplice.motion.skeleton import Skeleton

WIDEST_BIND_ANGLE = np.radians(25.0)  # radians between the same bone of two rigs in their bind poses


def onto_skeleton(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles) -> Clip:
    """Puts the clip's rotations on `skeleton` and scales its root path by the ratio of the leg lengths.

    The rigs may differ in bone lengths, joint order and joint names (CMU's two releases do). Their topology must be the
    same, except that fingers may be missing. Their bind poses must agree too: with another bind pose, the same
    rotations give another pose. Raises SkeletonError.
    """
    if has_fingers(skeleton, skeleton_roles):
        clip, roles = fingered(clip, roles, skeleton, skeleton_roles)
    match = _match(clip.skeleton, skeleton, clip.name)
    for role in (*LIMBS, "pelvis", "spine"):
        theirs, ours = (np.atleast_1d(getattr(rig, role)).tolist() for rig in (roles, skeleton_roles))
        if [match.index(joint) for joint in theirs] != ours:
            raise SkeletonError(
                f"its {role} is not the same joint as the bank's {role}",
                place=f"clip {clip.name!r}",
                mend="Name the joints of both rigs in a roles file and pass it as --roles",
            )
    _check_bind_poses(clip, match, skeleton, skeleton_roles)
    scale = skeleton_roles.leg_length(skeleton) / roles.leg_length(clip.skeleton)
    return replace(
        clip,
        skeleton=skeleton,
        root_positions=clip.root_positions * scale,
        rotations=clip.rotations if match == sorted(match) else clip.rotations[:, match],
    )


def _match(theirs: Skeleton, ours: Skeleton, name: str) -> list[int]:
    """Returns their joint for each of ours, matched by name, else by the tree's shape and where its limbs point."""
    if set(theirs.names) == set(ours.names):
        match = [theirs.index(joint) for joint in ours.names]
        parents = [-1 if parent < 0 else match[parent] for parent in ours.parents]
        if parents == theirs.parents[match].tolist():
            return match
    match = [0] * ours.joint_count
    reach_theirs, reach_ours = _reach(theirs), _reach(ours)
    for joint in range(ours.joint_count):
        a, b = theirs.children[match[joint]], ours.children[joint]
        if len(a) != len(b):
            raise SkeletonError(
                f"the rigs have different topologies: its joint {theirs.names[match[joint]]!r} has {len(a)} children, "
                f"the bank's {ours.names[joint]!r} has {len(b)}",
                place=f"clip {name!r}",
                mend="Retarget the clip to the baseline's rig, or build a separate bank for it",
            )
        if b:
            apart = np.linalg.norm(reach_theirs[list(a), None] - reach_ours[None, list(b)], axis=-1)
            for their_child, our_child in zip(*linear_sum_assignment(apart), strict=True):
                match[b[our_child]] = a[their_child]
    return match


def _reach(skeleton: Skeleton) -> Floats:
    """Returns the centre of each joint's subtree in the bind pose [J, 3], in units of the rig's size."""
    rest = np.zeros((skeleton.joint_count, 3))
    for joint in range(1, skeleton.joint_count):
        rest[joint] = rest[skeleton.parents[joint]] + skeleton.offsets[joint]
    middle = np.array([rest[skeleton.subtree(joint)].mean(axis=0) for joint in range(skeleton.joint_count)])
    return np.asarray(middle / np.abs(rest).max())


def _check_bind_poses(clip: Clip, match: list[int], skeleton: Skeleton, roles: Roles) -> None:
    for side in ("left", "right"):
        for part in ("knee", "ankle", "elbow", "wrist"):
            joint = getattr(roles, f"{side}_{part}")
            ours, theirs = skeleton.offsets[joint], clip.skeleton.offsets[match[joint]]
            apart = np.arccos(np.clip(ours @ theirs / (np.linalg.norm(ours) * np.linalg.norm(theirs)), -1.0, 1.0))
            if apart > WIDEST_BIND_ANGLE:
                raise SkeletonError(
                    f"its bind pose differs from the bank's: the bone to the {side} {part} points "
                    f"{np.degrees(apart):.0f} degrees away",
                    place=f"clip {clip.name!r}",
                    mend="Export the clip with the bind pose of the baseline's rig",
                )
