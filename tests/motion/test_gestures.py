from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.body_shape import check_shape
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.hand_joints import fingers_of, wrist_of
from motionsplice.motion.kinematics import heading, joint_positions
from motionsplice.motion.procedural.body import LEFT, RIGHT, SKELETON
from motionsplice.motion.procedural.gestures import SMALLER, GesturePair, gesture_pair, sample_gestures
from motionsplice.motion.procedural.hand_rig import (
    COUNTED,
    FINGERED,
    FIST,
    OPEN,
    POINT,
    RELAXED,
    THUMBS_UP,
    finger_joints,
    with_fingers,
)
from motionsplice.motion.procedural.score import KINDS, least_jerk
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.motion.roles import SIDES, Side, find_roles
from motionsplice.precompute.hands.merge import twist_about

ROLES = find_roles(FINGERED)
SEEDS = st.integers(0, 10_000)
ALL: Any = [*KINDS]


def wrist(clip: Clip, side: Side) -> Floats:
    """Returns the wrist's position [F, 3] relative to the shoulder, in the trunk's axes."""
    positions = joint_positions(clip)
    shoulders = ROLES.left_shoulder, ROLES.right_shoulder
    facing = heading(positions[:, shoulders[0]] - positions[:, shoulders[1]])
    away = positions[:, wrist_of(ROLES, side)] - positions[:, shoulders[side == "right"]]
    return rotate(about([0.0, 1.0, 0.0], -facing), away)


def at_the_bodys_times(pair: GesturePair) -> Clip:
    return Clip("sampled", pair.hands.skeleton, pair.body.rate, *pair.hands.sampled(pair.hand_frames))


def test_a_seed_determines_the_pair_and_another_seed_gives_another() -> None:
    one, same, other = (gesture_pair(seed, gestures=3, seconds=3.0) for seed in (4, 4, 5))
    for clip in ("body", "hands", "truth"):
        ours, theirs = getattr(one, clip), getattr(same, clip)
        assert np.array_equal(ours.rotations, theirs.rotations)
        assert np.array_equal(ours.root_positions, theirs.root_positions)
    assert np.array_equal(one.hand_frames, same.hand_frames)
    assert (one.kinds, one.spans) == (same.kinds, same.spans)
    assert not np.array_equal(one.body.rotations, other.body.rotations)


@settings(max_examples=15)
@given(
    SEEDS,
    st.lists(st.sampled_from(KINDS), max_size=8),
    st.sampled_from(["left", "right", "both"]),
    st.sampled_from([30.0, 60.0, 120.0]),
    st.sampled_from([None, "walk"]),
)
def test_hand_frames_increase_and_spans_cover_the_clip(
    seed: int, kinds: Any, hand: str, hand_rate: float, locomotion: str | None
) -> None:
    pair = gesture_pair(seed, kinds=kinds, seconds=3.0, hand=hand, hand_rate=hand_rate, locomotion=locomotion)
    count = pair.body.frame_count
    assert (pair.kinds, count, pair.hands.rate) == (kinds, 181, hand_rate)
    assert pair.hand_frames.shape == (count,)
    assert pair.hand_frames[0] == 0.0
    assert pair.hand_frames[-1] == pytest.approx(pair.hands.frame_count - 1)
    assert np.diff(pair.hand_frames).min() > 0.0
    sides = {"left": [LEFT], "right": [RIGHT], "both": [LEFT, RIGHT]}[hand]
    for number, side in enumerate(sides):
        spans = [span for span in pair.spans if span.side == side]
        assert (spans[0].kind, spans[0].begin) == (spans[-1].kind, 0.0) == ("hold", 0.0)
        assert spans[-1].end == pytest.approx(count - 1)
        for before, after in pairwise(spans):
            assert before.begin < before.end == after.begin
            assert (before.kind, after.kind) != ("hold", "hold")
            assert (before.kind, after.kind) != ("retraction", "stroke")
            assert before.kind != "preparation" or after.kind == "stroke"
        phases = [span.kind for span in spans]
        own = len(kinds[number :: len(sides)])
        assert phases.count("preparation") == own
        assert phases.count("stroke") >= own
        assert phases[-2:-1] == (["retraction"] if own else [])
    assert {span.side for span in pair.spans} == set(sides)


def test_fingers_are_still_in_the_body_and_move_in_the_truth() -> None:
    pair = gesture_pair(6, kinds=ALL, seconds=4.0, locomotion="walk")
    joints = [joint for side in SIDES for joint in fingers_of(FINGERED, ROLES, side)]
    others = [joint for joint in range(FINGERED.joint_count) if joint not in joints]
    assert np.array_equal(pair.truth.root_positions, pair.body.root_positions)
    assert np.array_equal(pair.truth.rotations[:, others], pair.body.rotations[:, others])
    assert np.ptp(pair.body.rotations[:, joints], axis=0).max() < 1e-12
    assert np.ptp(pair.truth.rotations[:, joints], axis=0).max() > 0.5
    sampled = at_the_bodys_times(pair)
    assert quaternion.angle(pair.truth.rotations[:, joints], sampled.rotations[:, joints]).max() < 0.05


@pytest.mark.parametrize("size", [0.2, 0.5, 1.0])
def test_the_hands_motion_is_scaled_by_the_amplitude(size: float) -> None:
    """The scale is relative to the body's wrists, and further reduced by the smaller stature of the performer."""
    for seed in (1, 2, 3):
        pair = gesture_pair(seed, kinds=ALL, seconds=6.0, amplitude=(size, size), locomotion=None, hand="right")
        own, theirs = (wrist(clip, "right") for clip in (pair.body, at_the_bodys_times(pair)))
        ratio = np.linalg.norm(np.ptp(theirs, axis=0)) / np.linalg.norm(np.ptp(own, axis=0))
        assert ratio == pytest.approx(SMALLER * size, rel=0.2)


def test_only_the_chosen_hand_gestures() -> None:
    pair = gesture_pair(2, kinds=ALL, seconds=4.0, hand="right", locomotion=None)
    left, right = (fingers_of(FINGERED, ROLES, side) for side in SIDES)
    assert np.ptp(pair.hands.rotations[:, left], axis=0).max() < 1e-12
    assert np.ptp(pair.hands.rotations[:, right], axis=0).max() > 0.5
    with pytest.raises(SettingsError, match="unknown hand 'third'"):
        gesture_pair(2, hand="third")


def posed(pose: Floats) -> Floats:
    """Returns the joints [J, 3] of a T-pose with both hands in `pose`."""
    still = Clip("still", SKELETON, 60.0, np.zeros((1, 3)), np.tile(quaternion.IDENTITY, (1, SKELETON.joint_count, 1)))
    return joint_positions(with_fingers(still, dict.fromkeys((LEFT, RIGHT), pose[None])))[0]


@given(st.lists(st.floats(-0.2, 1.0), min_size=7, max_size=7))
def test_left_and_right_hands_mirror_each_other(pose: list[float]) -> None:
    joints = posed(np.array(pose))
    left, right = finger_joints(LEFT), finger_joints(RIGHT)
    np.testing.assert_allclose(joints[right], joints[left] * [-1.0, 1.0, 1.0], atol=1e-12)


def test_poses_look_like_their_names() -> None:
    """Compares the distance of each finger's last joint from the wrist with that of a straight finger."""
    straight = posed(np.zeros(7))

    def reach(pose: Floats) -> Floats:
        last = np.array(finger_joints(LEFT)).reshape(5, 3)[:, 2]
        wrist, joints = straight[ROLES.left_wrist], posed(pose)
        return np.linalg.norm(joints[last] - wrist, axis=1) / np.linalg.norm(straight[last] - wrist, axis=1)

    assert reach(OPEN).min() > 0.97
    assert reach(FIST)[1:].max() < 0.75
    assert (reach(POINT)[1:] > 0.9).tolist() == [True, False, False, False]
    assert (reach(THUMBS_UP) > 0.9).tolist() == [True, False, False, False, False]
    for number, pose in COUNTED.items():
        assert (reach(pose)[1:] > 0.9).sum() == min(number, 4)
    assert reach(RELAXED)[1:].max() < reach(OPEN)[1:].min()
    palm_side = posed(FIST)[finger_joints(LEFT)[3:], 1] - straight[ROLES.left_wrist, 1]
    assert palm_side.max() < 0.01  # palms face down


@settings(max_examples=10)
@given(SEEDS)
def test_fingers_stay_within_human_limits(seed: int) -> None:
    """A knuckle and the joints after it bend by up to 100, 110 and 80 degrees, and fingers spread by up to 25."""
    truth = gesture_pair(seed, gestures=5, seconds=4.0, locomotion=None).truth
    for sign in (LEFT, RIGHT):
        turns = truth.rotations[:, finger_joints(sign)].reshape(-1, 5, 3, 4)
        bent = quaternion.log(twist_about(turns[:, 1:], np.array([0.0, 0.0, 1.0])))[..., 2] * -sign
        spread = quaternion.log(twist_about(turns[:, 1:, 0], np.array([0.0, 1.0, 0.0])))[..., 1]
        assert bent.min() > np.radians(-15.0)
        assert (bent.max(axis=(0, 1)) < np.radians([100.0, 110.0, 80.0])).all()
        assert np.abs(spread).max() < np.radians(25.0)
        assert quaternion.angle(turns[:, 0, 1:], quaternion.IDENTITY).max() < np.radians(80.0)  # the thumb
    speed = quaternion.angle(truth.rotations[1:], truth.rotations[:-1]).max() * truth.rate
    assert speed < np.radians(2500.0)


def test_roles_are_the_same_with_fingers() -> None:
    named = {role: FINGERED.names[joint] for role, joint in vars(ROLES).items() if role != "spine"}
    bare = find_roles(SKELETON)
    assert named == {role: SKELETON.names[joint] for role, joint in vars(bare).items() if role != "spine"}
    assert (named["left_wrist"], named["right_elbow"]) == ("LeftHand", "RightForeArm")
    pair = gesture_pair(1, kinds=ALL, seconds=4.0)
    for clip in (pair.body, pair.hands, pair.truth):
        assert check_shape(clip, find_roles(clip.skeleton), given=False) == []


def test_samples_are_bodies_and_their_hands() -> None:
    samples = sample_gestures()
    assert sorted(samples) == ["count_steps", "count_steps_hands", "directions", "directions_hands"]
    assert all(clip.name == name for name, clip in samples.items())


def test_a_move_has_minimum_jerk() -> None:
    """It begins and ends at rest. Half-way it is half done, at its highest speed: 1.875 times the mean."""
    t = np.linspace(-0.5, 1.5, 2001)
    done = least_jerk(t)
    speed, change = np.gradient(done, t), np.gradient(np.gradient(done, t), t)
    np.testing.assert_allclose(done[[0, 500, 1000, 1500, 2000]], [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-9)
    assert speed.max() == pytest.approx(1.875, abs=1e-3)
    np.testing.assert_allclose(speed[[500, 1500]], 0.0, atol=1e-3)
    np.testing.assert_allclose(change[[500, 1500]], 0.0, atol=0.1)
