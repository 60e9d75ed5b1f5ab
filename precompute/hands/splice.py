"""Splicing separately captured hands onto a body: two clips of any rates in, one clip out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, Side
from motionsplice.precompute.hands.align import STRANGE, HandAlignment, align_hands
from motionsplice.precompute.hands.banded_warp import check_pairs, limits
from motionsplice.precompute.hands.merge import merge_hands
from motionsplice.precompute.hands.points import HandMotion, hand_motion
from motionsplice.precompute.hands.settings import HandSettings

MOST_FRAMES = 250_000  # of the hands clip at the body's rate: an hour at 60 Hz


@dataclass(frozen=True, eq=False)
class AlignedHands:
    """Hands that were aligned together.

    body, hands: the motion of each side in both clips, at the body's rate. alignment: of all these sides.
    """

    body: Mapping[Side, HandMotion]
    hands: Mapping[Side, HandMotion]
    alignment: HandAlignment


@dataclass(frozen=True, eq=False)
class HandSplice:
    """A body with the fingers of a hands clip.

    Attributes:
        clip: The body's F frames at the body's rate, with the hands.
        roles: The roles of the clip's joints. Its skeleton has fingers even if the body's had none.
        frames: For each side, the real-valued frame [F] of the hands clip at each frame of the body.
        aligned: The hands that were aligned together: one entry, or two for `hand = "each"`.
    """

    clip: Clip
    roles: Roles
    frames: Mapping[Side, Floats]
    aligned: tuple[AlignedHands, ...]

    @property
    def mismatch(self) -> float:
        """The largest `HandAlignment.mismatch` of the aligned hands: 0 if identical, about 1 if unrelated."""
        return max(group.alignment.mismatch for group in self.aligned)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for the user; empty if the gestures match."""
        if self.mismatch <= STRANGE:
            return ()
        problem = f"its gestures do not seem to match those of {self.clip.name!r}: the mismatch is {self.mismatch:.2f}"
        return (f"{problem} (matching gestures stay below {STRANGE}); try one hand alone",)


def splice_hands(body: Clip, roles: Roles, hands: Clip, hand_roles: Roles, settings: HandSettings) -> HandSplice:
    """Aligns separately captured hands to a body, and merges them into it (Majkowska, Zordan and Faloutsos 2006).

    Args:
        body: The clip of the body, F frames. The result has its rate.
        roles: Which joint of the body's skeleton is which.
        hands: The clip that gives the hands. Its rate and skeleton may differ from the body's.
        hand_roles: Which joint of the hands' skeleton is which.
        settings: Which hands, and how they are aligned and merged.

    Returns:
        The body with the hands, and the frames [F] of the hands clip that were used.

    Raises:
        SettingsError: A frame pair lies outside a clip or crosses another, or the bands are not within 0 to 1.
        SkeletonError: The rigs' hands do not match.
        ClipError: At the body's rate the hands have more than MOST_FRAMES frames, or the clips cannot be compared.
    """
    ordered = check_pairs(settings.pairs, body.frame_count, hands.frame_count)
    if (count := hands.duration * body.rate + 1.0) > MOST_FRAMES:
        raise ClipError(
            f"the hands last {hands.duration:g} s, {count:,.0f} frames at the body's {body.rate:g} per second; "
            f"the limit is {MOST_FRAMES:,}",
            mend="Check the frame rates of both clips",
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
