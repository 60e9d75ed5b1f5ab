"""Hands onto a body, whole: from two clips, of any rates, to the body with the hands' fingers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.hand_joints import Side
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.hands.align import STRANGE, HandAlignment, align_hands
from motionsplice.precompute.hands.banded_warp import check_pairs, limits
from motionsplice.precompute.hands.merge import merge_hands
from motionsplice.precompute.hands.points import HandMotion, hand_motion
from motionsplice.precompute.hands.settings import HandSettings

MOST_FRAMES = 250_000  # of hands at the body's rate: an hour at 60 Hz


@dataclass(frozen=True, eq=False)
class AlignedHands:
    """Hands that were aligned together: of each side how the body's and the hands' move, both at the body's rate."""

    body: Mapping[Side, HandMotion]
    hands: Mapping[Side, HandMotion]
    alignment: HandAlignment


@dataclass(frozen=True, eq=False)
class HandSplice:
    """A body with the fingers of hands, and its roles.

    frames: of each side, the real-valued frame [F] of the hands' clip that goes with each of the body's.
    """

    clip: Clip
    roles: Roles
    frames: Mapping[Side, Floats]
    aligned: tuple[AlignedHands, ...]

    @property
    def mismatch(self) -> float:
        """Of those hands that fit worst (`HandAlignment.mismatch`)."""
        return max(one.alignment.mismatch for one in self.aligned)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should look at."""
        if self.mismatch <= STRANGE:
            return ()
        said = f"its gestures hardly seem to be those of {self.clip.name!r}: phases of frames that go together differ"
        return (f"{said} {self.mismatch:.2f} times as much as those of any; one hand alone may fit",)


def splice_hands(body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, settings: HandSettings) -> HandSplice:
    """Aligns hands to a body and merges them.

    Raises MotionError if settings or rigs do not fit, or hands have more than MOST_FRAMES.
    """
    ordered = check_pairs(settings.pairs, body.frame_count, hands.frame_count)
    if (count := hands.duration * body.rate + 1.0) > MOST_FRAMES:
        raise ClipError(
            f"hands of {hands.duration:g} s are {count:,.0f} frames at the body's {body.rate:g} a second",
            mend="Check how many frames a second both have",
        )
    paced, ratio = hands.resampled(body.rate), hands.rate / body.rate
    last = paced.frame_count - 1
    pairs = [
        replace(pair, hands=min(round(pair.hands / ratio), last), tolerance=round(pair.tolerance / ratio))
        for pair in ordered
    ]
    frames: dict[Side, Floats] = {}
    aligned = []
    for group in settings.groups:
        ours = {side: hand_motion(body, roles, side) for side in group}
        theirs = {side: hand_motion(paced, hand_roles, side) for side in group}
        found = align_hands(
            list(ours.values()),
            list(theirs.values()),
            body.rate,
            pairs=pairs,
            bands=settings.bands,
            by_trunk=settings.turn == "trunk",
        )
        own = np.clip(found.frames * ratio, *limits(body.frame_count, hands.frame_count, ordered))
        frames |= dict.fromkeys(group, own)
        aligned.append(AlignedHands(ours, theirs, found))
    clip, merged_roles = merge_hands(body, roles, hands, hand_roles, frames, wrist=settings.wrist)
    return HandSplice(clip, merged_roles, frames, tuple(aligned))
