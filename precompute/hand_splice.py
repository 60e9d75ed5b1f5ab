"""Hands onto a body, from two clips to the frames of the one that go with those of the other."""

from __future__ import annotations

from motion.clip import Clip
from motion.hand_joints import Side
from motion.quaternion import Floats
from motion.roles import Roles
from precompute.banded_warp import FramePair
from precompute.hand_points import hand_motion
from precompute.hand_settings import HandSettings
from precompute.hands import align_hands


def hand_frames(body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, settings: HandSettings) -> dict[Side, Floats]:
    slow = hands.resampled(body.rate)
    ratio = hands.rate / body.rate
    pairs = [FramePair(one.body, round(one.hands / ratio), round(one.tolerance / ratio)) for one in settings.pairs]
    found: dict[Side, Floats] = {}
    for group in settings.groups:
        ours, theirs = (
            [hand_motion(clip, one, side) for side in group] for clip, one in ((body, roles), (slow, hand_roles))
        )
        aligned = align_hands(
            ours, theirs, body.rate, pairs=pairs, bands=settings.bands, by_trunk=settings.turn == "trunk"
        )
        found |= dict.fromkeys(group, aligned.frames * ratio)
    return found
