"""Merging the fingers of one clip into the body of another, at the frames that an alignment found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.hand_joints import bind_turn, fingered, fingers_of, forearm, forearm_of, match_fingers
from motionsplice.motion.quaternion import Floats, conjugate, multiply
from motionsplice.motion.roles import Roles, Side


def merge_hands(
    body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, frames: Mapping[Side, Floats], *, wrist: bool = False
) -> tuple[Clip, Roles]:
    """Returns the body's clip with the fingers of the hands clip, and its roles.

    frames: for each side to merge, the real-valued frame [F] of the hands clip at each frame of the body. wrist: also
    take the wrists and the twist of the forearms. The rigs may differ outside the hands. A body without fingers gets
    those of the hands' rig. Raises SkeletonError if the hands cannot be matched.
    """
    clip, roles = fingered(body, roles, hands.skeleton, hand_roles)
    rotations = clip.rotations.copy()
    for side, at in frames.items():
        driven = hand_rotations(clip, roles, hands, hand_roles, side, at, wrist=wrist)
        for joint, turned in driven.items():
            rotations[:, joint] = turned
    return replace(clip, rotations=rotations), roles


def hand_rotations(
    body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, side: Side, frames: Floats, *, wrist: bool
) -> dict[int, Floats]:
    """Returns the rotations [F, 4] of the body's joints that the hands clip drives, by joint. Raises SkeletonError.

    Hands keep their orientation relative to the forearm, with the bind pose of their hand laid on the body's. The twist
    of a wrist is moved to the forearm: real wrists hardly twist, and rigs store the twist in either. If forearms have
    twist bones, on either rig, each bone of the body's forearm gets an equal share. Rotations of palm bones that the
    body does not have are passed on to the fingers below them.
    """
    match = match_fingers(body.skeleton, roles, hands.skeleton, hand_roles, side)
    turn = bind_turn(body.skeleton, roles, hands.skeleton, hand_roles, side)
    fingers = fingers_of(hands.skeleton, hand_roles, side)
    theirs = dict(zip(fingers, np.moveaxis(_taken(hands, frames, turn, fingers), 1, 0), strict=True))
    driven = {}
    for joint, other in match.items():
        driven[joint], above = theirs[other], int(hands.skeleton.parents[other])
        while above in theirs.keys() - match.values():
            driven[joint], above = multiply(theirs[above], driven[joint]), int(hands.skeleton.parents[above])
    if wrist:
        *arm, joint = forearm_of(body.skeleton, roles, side)
        bone = forearm(body.skeleton, roles, side)
        bone /= np.linalg.norm(bone)
        turns = _taken(hands, frames, turn, forearm_of(hands.skeleton, hand_roles, side))
        driven[joint] = multiply(conjugate(twist_about(turns[:, -1], bone)), turns[:, -1])
        share = quaternion.about(bone, radians_about(turns, bone).sum(axis=1) / len(arm))
        for own in arm:
            swing = multiply(body.rotations[:, own], conjugate(twist_about(body.rotations[:, own], bone)))
            driven[own] = multiply(swing, share)
    return {joint: quaternion.one_hemisphere(turned) for joint, turned in driven.items()}


def _taken(hands: Clip, frames: Floats, turn: Floats, joints: list[int]) -> Floats:
    """Returns rotations [F, n, 4] of joints at real-valued frames [F], in the axes of the body's bind pose."""
    before, after, t = quaternion.neighbours(hands.frame_count, frames)
    own = hands.rotations[:, joints]
    return multiply(multiply(turn, quaternion.slerp(own[before], own[after], t[:, None])), conjugate(turn))


def twist_about(q: Floats, axis: Floats) -> Floats:
    """Returns the twist of rotations [..., 4] about a unit axis [3]. The rest, q twist^-1, is a swing without twist."""
    along = q[..., :3] @ axis
    twist = np.concatenate([along[..., None] * axis, q[..., 3:]], axis=-1)
    size = quaternion.length(twist)[..., None]
    return np.where(size > 1e-9, twist / np.maximum(size, 1e-9), quaternion.IDENTITY)


def radians_about(q: Floats, axis: Floats) -> Floats:
    """Returns the twist angles [F, ...] of rotations [F, ..., 4] about a unit axis [3], radians.

    The first frame's angle is within -pi to pi; the others follow without jumps.
    """
    turned = np.unwrap(2.0 * np.arctan2(q[..., :3] @ axis, q[..., 3]), axis=0)
    return np.asarray(turned - 2.0 * np.pi * np.round(turned[:1] / (2.0 * np.pi)))
