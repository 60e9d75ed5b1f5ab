from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion.errors import ClipError, SettingsError
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.hands.align import STRANGE
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import splice_hands


@pytest.mark.parametrize("rate", [30.0, 100.0, 120.0])
def test_hands_of_another_rate_are_aligned_in_their_own_frames(rate: float) -> None:
    pair = gesture_pair(31, kinds=["point", "count", "thumbs_up"], seconds=4.5, hand_rate=rate, hand="right")
    rigs = find_roles(pair.body.skeleton), find_roles(pair.hands.skeleton)
    settings = HandSettings("right", pairs=(FramePair(140, round(pair.hand_frames[140])),))
    spliced = splice_hands(pair.body, rigs[0], pair.hands, rigs[1], settings)
    assert set(spliced.frames) == {"right"}
    apart = np.abs(spliced.frames["right"] - pair.hand_frames) / rate
    assert np.median(apart) < 0.02
    assert spliced.frames["right"][140] == pytest.approx(round(pair.hand_frames[140]), abs=1e-9)
    outside = HandSettings("right", pairs=(FramePair(3, pair.hands.frame_count),))
    with pytest.raises(SettingsError, match=f"pair 3:{pair.hands.frame_count}"):
        splice_hands(pair.body, rigs[0], pair.hands, rigs[1], outside)


def test_each_hand_can_have_its_own_timing() -> None:
    pair = gesture_pair(8, gestures=6, seconds=5.0)
    rigs = find_roles(pair.body.skeleton), find_roles(pair.hands.skeleton)
    for choice, groups in (("each", 2), ("both", 1)):
        spliced = splice_hands(pair.body, rigs[0], pair.hands, rigs[1], HandSettings(choice))  # type: ignore[arg-type]
        assert len(spliced.aligned) == groups
        assert np.array_equal(spliced.frames["left"], spliced.frames["right"]) == (choice == "both")


def test_hands_with_other_gestures_are_detected() -> None:
    pairs = [gesture_pair(seed, gestures=7, seconds=6.0) for seed in (40, 41, 42)]
    for number, pair in enumerate(pairs):
        roles, other = find_roles(pair.body.skeleton), pairs[number - 1].hands
        own = splice_hands(pair.body, roles, pair.hands, find_roles(pair.hands.skeleton), HandSettings())
        assert own.mismatch < 0.4
        assert own.warnings == ()
        strange = splice_hands(pair.body, roles, other, find_roles(other.skeleton), HandSettings())
        assert strange.mismatch > STRANGE
        (warning,) = strange.warnings
        assert "do not seem to match those of 'body'" in warning


def test_two_resting_hands_have_no_mismatch() -> None:
    hands = gesture_pair(8, gestures=2, seconds=2.0).hands
    still, roles = (
        replace(hands, rotations=np.tile(hands.rotations[:1], (hands.frame_count, 1, 1))),
        find_roles(hands.skeleton),
    )
    assert splice_hands(still, roles, still, roles, HandSettings()).mismatch == 0.0


def test_hands_that_last_for_hours_are_refused_before_resampling() -> None:
    """As when a file gives milliseconds as seconds."""
    pair = gesture_pair(8, gestures=2, seconds=2.0)
    rigs = find_roles(pair.body.skeleton), find_roles(pair.hands.skeleton)
    with pytest.raises(ClipError, match=r"1,9\d\d,\d{3} frames at the body's 60 per second"):
        splice_hands(pair.body, rigs[0], replace(pair.hands, rate=pair.hands.rate / 16_000.0), rigs[1], HandSettings())
