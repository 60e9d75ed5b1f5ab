"""Bringing clips of differently built people onto the bank's one skeleton."""

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

WIDEST_BIND_ANGLE = np.radians(25.0)  # between the same limb of two rigs in their bind poses


def onto_skeleton(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles) -> Clip:
    """The clip's rotations on `skeleton`, its root's path scaled by the ratio of the legs.

    Rigs may differ in bone lengths, joint order and names (CMU's two forms do), but not in topology, except that
    fingers may be missing; and their bind poses must agree, or the same rotations would mean other poses. Raises
    SkeletonError.
    """
    if has_fingers(skeleton, skeleton_roles):
        clip, roles = fingered(clip, roles, skeleton, skeleton_roles)
    match = _match(clip.skeleton, skeleton, clip.name)
    for role in (*LIMBS, "pelvis", "spine"):
        theirs, ours = (np.atleast_1d(getattr(one, role)).tolist() for one in (roles, skeleton_roles))
        if [match.index(joint) for joint in theirs] != ours:
            raise SkeletonError(
                f"its {role} is another joint than the bank's",
                place=f"clip {clip.name!r}",
                mend="Give both rigs the same roles with a roles file",
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
    """For each of our joints the one of theirs: by name, else by the shape of the tree and where limbs point."""
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
                f"its joint {theirs.names[match[joint]]!r} has {len(a)} children where the bank's "
                f"{ours.names[joint]!r} has {len(b)}: the rigs have different topologies",
                place=f"clip {name!r}",
                mend="Retarget it to the baseline's rig, or build a bank of its own for it",
            )
        if b:
            apart = np.linalg.norm(reach_theirs[list(a), None] - reach_ours[None, list(b)], axis=-1)
            for their_child, our_child in zip(*linear_sum_assignment(apart), strict=True):
                match[b[our_child]] = a[their_child]
    return match


def _reach(skeleton: Skeleton) -> Floats:
    """Where each joint's whole subtree lies in the bind pose [J, 3], in units of the rig's size."""
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
                    f"in its bind pose the bone to the {side} {part} points {np.degrees(apart):.0f} degrees away "
                    "from the bank's, so the same rotations mean other poses",
                    place=f"clip {clip.name!r}",
                    mend="Export both clips with one bind pose",
                )
