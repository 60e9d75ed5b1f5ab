"""The fingers of one clip on the body of another, at the frames that an alignment says go together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.hand_joints import Side, bind_turn, fingered, fingers_of, forearm, forearm_of, match_fingers
from motionsplice.motion.quaternion import Floats, conjugate, multiply
from motionsplice.motion.roles import Roles


def merge_hands(
    body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, frames: Mapping[Side, Floats], *, wrist: bool = False
) -> tuple[Clip, Roles]:
    """The body's clip with the fingers of the hands' clip; with `wrist` also its wrists, and the twist of its forearms.

    frames: of each hand to take, the real-valued frame [F] of the hands' clip that goes with each of the body's. Rigs
    may differ outside the hands; a body without fingers is given those of the hands' rig. Raises SkeletonError.
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
    """The rotations [F, 4] of those joints of the body, by joint, that the hands' clip drives. Raises SkeletonError.

    As seen from the forearm, and with the bind pose of their hand laid on that of ours. The twist of a wrist belongs to
    the forearm: bones of the wrist hardly twist, and a rig may have either. Of forearms that have bones which twist,
    ours or theirs, each of ours has an equal share. Bones of their palm that we lack turn the fingers on them.
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
    """Rotations [F, n, 4] of joints at real-valued frames [F], in our bind pose's axes."""
    before, after, t = quaternion.neighbours(hands.frame_count, frames)
    own = hands.rotations[:, joints]
    return multiply(multiply(turn, quaternion.slerp(own[before], own[after], t[:, None])), conjugate(turn))


def twist_about(q: Floats, axis: Floats) -> Floats:
    """The part of rotations [..., 4] about a unit axis [3]: what is left, q twist^-1, turns about none of it."""
    along = q[..., :3] @ axis
    twist = np.concatenate([along[..., None] * axis, q[..., 3:]], axis=-1)
    size = quaternion.length(twist)[..., None]
    return np.where(size > 1e-9, twist / np.maximum(size, 1e-9), quaternion.IDENTITY)


def radians_about(q: Floats, axis: Floats) -> Floats:
    """How far the twists of rotations [F, ..., 4] about a unit axis [3] turn [F, ...]: at most pi at first, then on
    without a jump."""
    turned = np.unwrap(2.0 * np.arctan2(q[..., :3] @ axis, q[..., 3]), axis=0)
    return np.asarray(turned - 2.0 * np.pi * np.round(turned[:1] / (2.0 * np.pi)))
