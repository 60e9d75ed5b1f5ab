from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.hand_joints import elbow_of, fingers_of, forearm, forearm_of, wrist_of
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats, about, conjugate, multiply, rotate
from motionsplice.motion.roles import SIDES, Roles, Side, find_roles
from motionsplice.precompute.hands.merge import merge_hands, radians_about, twist_about
from tests.conftest import CLIPS, COUNTING, OTHERS
from tests.rigs import with_arms_turned, with_bones_above

BODY, HANDS, TRUTH = COUNTING.body, COUNTING.hands, COUNTING.truth
ROLES = find_roles(BODY.skeleton)
FRAMES: dict[Side, Floats] = dict.fromkeys(SIDES, COUNTING.hand_frames)
TWIST = {"LeftHand": "LeftForeArmTwist", "RightHand": "RightForeArmTwist"}

numbers = st.floats(-1.0, 1.0)
turns = st.builds(lambda *q: np.array(q), numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 0.05)
axes = st.builds(lambda *v: np.array(v), numbers, numbers, numbers).filter(lambda v: np.linalg.norm(v) > 0.05)


def unit(v: Floats) -> Floats:
    return v / np.linalg.norm(v)


@given(turns, axes)
def test_a_rotation_is_a_twist_and_then_a_swing(turn: Floats, axis: Floats) -> None:
    q, axis = unit(turn), unit(axis)
    twist = twist_about(q, axis)
    swing = multiply(q, conjugate(twist))
    assert quaternion.length(twist) == pytest.approx(1.0)
    np.testing.assert_allclose(rotate(twist, axis), axis, atol=1e-9)
    np.testing.assert_allclose(multiply(swing, twist), q, atol=1e-12)
    assert swing[:3] @ axis == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(rotate(swing, axis), rotate(q, axis), atol=1e-9)  # a twist does not move the bone


@given(st.floats(-3.0, 3.0), axes)
def test_the_twist_of_a_twist_is_itself_and_of_a_half_turn_swing_identity(radians: float, axis: Floats) -> None:
    axis = unit(axis)
    twist = about(axis, radians)
    np.testing.assert_allclose(twist_about(twist, axis), twist, atol=1e-9)
    across = unit(np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.8 else [0.0, 1.0, 0.0]))
    np.testing.assert_array_equal(twist_about(about(across, np.pi), axis), quaternion.IDENTITY)


@given(st.floats(-3.1, 3.1), st.lists(st.floats(-2.0, 2.0), max_size=20), st.lists(st.booleans(), min_size=21))
def test_twist_angles_have_no_jumps_for_any_signs_of_the_quaternions(
    begin: float, steps: list[float], signs: list[bool]
) -> None:
    radians = np.cumsum([begin, *steps])
    q = about([0.6, 0.0, 0.8], radians) * np.where(signs[: len(radians)], 1.0, -1.0)[:, None]
    np.testing.assert_allclose(radians_about(q[:, None], np.array([0.6, 0.0, 0.8]))[:, 0], radians, atol=1e-6)


def test_equal_rigs_and_times_give_exactly_the_true_fingers() -> None:
    same = np.arange(BODY.frame_count, dtype=np.float64)
    merged, roles = merge_hands(BODY, ROLES, TRUTH, ROLES, dict.fromkeys(SIDES, same))
    assert roles == ROLES
    assert quaternion.angle(BODY.rotations, TRUTH.rotations).max() > 1.0
    assert quaternion.angle(merged.rotations, TRUTH.rotations).max() < 1e-9
    assert np.array_equal(merged.root_positions, BODY.root_positions)


def test_at_the_true_frames_the_fingers_equal_the_truth_within_interpolation() -> None:
    merged, _ = merge_hands(BODY, ROLES, HANDS, find_roles(HANDS.skeleton), FRAMES)
    assert quaternion.angle(merged.rotations, TRUTH.rotations).max() < 0.02


def test_rotations_of_missing_palm_bones_are_passed_to_the_fingers() -> None:
    palm = {f"RightHand{finger}1": f"right{finger}Metacarpal" for finger in ("Index", "Middle", "Ring", "Pinky")}
    hands = with_bones_above(TRUTH, palm)
    cupped = hands.rotations.copy()
    for number, name in enumerate(palm.values()):
        cupped[:, hands.skeleton.index(name)] = about([1.0, 0.0, 0.0], 0.05 * (number + 1.0))
    hands = replace(hands, rotations=cupped)
    same = np.arange(BODY.frame_count, dtype=np.float64)
    merged, _ = merge_hands(BODY, ROLES, hands, find_roles(hands.skeleton), dict.fromkeys(SIDES, same))
    shown, wanted = (
        world_transforms(clip.skeleton, clip.root_positions, clip.rotations)[1] for clip in (merged, hands)
    )
    for finger in ("Thumb", "Index", "Pinky"):
        for number in (1, 2, 3):
            name = f"RightHand{finger}{number}"
            ours, theirs = shown[:, merged.skeleton.index(name)], wanted[:, hands.skeleton.index(name)]
            assert quaternion.angle(ours, theirs).max() < 1e-6


@pytest.mark.parametrize("wrist", [False, True])
@pytest.mark.parametrize("side", SIDES)
def test_joints_that_are_not_merged_stay_exactly_the_same(side: Side, wrist: bool) -> None:
    merged, _ = merge_hands(BODY, ROLES, HANDS, find_roles(HANDS.skeleton), {side: COUNTING.hand_frames}, wrist=wrist)
    driven = fingers_of(BODY.skeleton, ROLES, side) + ([elbow_of(ROLES, side), wrist_of(ROLES, side)] if wrist else [])
    others = [joint for joint in range(BODY.skeleton.joint_count) if joint not in driven]
    assert np.array_equal(merged.rotations[:, others], BODY.rotations[:, others])
    assert quaternion.angle(merged.rotations[:, driven], BODY.rotations[:, driven]).max(axis=0).all()
    steps = np.sum(merged.rotations[1:] * merged.rotations[:-1], axis=-1)
    assert steps.min() > 0.0  # in one hemisphere


def test_merging_no_side_changes_nothing() -> None:
    merged, _ = merge_hands(BODY, ROLES, HANDS, find_roles(HANDS.skeleton), {}, wrist=True)
    assert np.array_equal(merged.rotations, BODY.rotations)


def held(clip: Clip, roles: Roles, side: Side) -> Floats:
    """Returns the hand's orientation [F, 4] relative to the forearm's direction, whichever of its bones twist."""
    _, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    elbow, bone = elbow_of(roles, side), unit(forearm(clip.skeleton, roles, side))
    own = clip.rotations[:, elbow]
    swing = multiply(own, conjugate(twist_about(own, bone)))
    points = multiply(world[:, clip.skeleton.parents[elbow]], swing)
    return multiply(conjugate(points), world[:, wrist_of(roles, side)])


def twisting(clip: Clip) -> Clip:
    """Returns the same motion on a rig whose forearms have two bones, of which the second twists."""
    split = with_bones_above(clip, TWIST)
    roles, rotations = find_roles(split.skeleton), split.rotations.copy()
    for side in SIDES:
        upper, lower, _ = forearm_of(split.skeleton, roles, side)
        twist = twist_about(rotations[:, upper], unit(forearm(split.skeleton, roles, side)))
        rotations[:, upper], rotations[:, lower] = multiply(rotations[:, upper], conjugate(twist)), twist
    return replace(split, rotations=rotations)


@pytest.mark.parametrize("ours", [BODY, twisting(BODY)], ids=["one bone", "two bones"])
@pytest.mark.parametrize("theirs", [HANDS, twisting(HANDS)], ids=["one bone", "two bones"])
def test_wrist_gives_the_hands_orientation_and_moves_no_joint(ours: Clip, theirs: Clip) -> None:
    roles, their_roles = find_roles(ours.skeleton), find_roles(theirs.skeleton)
    merged, _ = merge_hands(ours, roles, theirs, their_roles, FRAMES, wrist=True)
    sampled = Clip("sampled", theirs.skeleton, ours.rate, *theirs.sampled(COUNTING.hand_frames))
    before, after = (world_transforms(one.skeleton, one.root_positions, one.rotations)[0] for one in (ours, merged))
    for side in SIDES:
        assert quaternion.angle(held(ours, roles, side), held(sampled, their_roles, side)).max() > 0.1
        assert quaternion.angle(held(merged, roles, side), held(sampled, their_roles, side)).max() < 1e-6
        arm = forearm_of(ours.skeleton, roles, side)
        np.testing.assert_allclose(after[:, arm], before[:, arm], atol=1e-9)


def test_bones_of_a_forearm_share_its_twist() -> None:
    ours = twisting(BODY)
    roles = find_roles(ours.skeleton)
    merged, _ = merge_hands(ours, roles, HANDS, find_roles(HANDS.skeleton), FRAMES, wrist=True)
    for side in SIDES:
        upper, lower, wrist = forearm_of(ours.skeleton, roles, side)
        bone = unit(forearm(ours.skeleton, roles, side))
        shares = radians_about(merged.rotations[:, [upper, lower, wrist]], bone)
        np.testing.assert_allclose(shares[:, 0], shares[:, 1], atol=1e-6)
        np.testing.assert_allclose(shares[:, 2], 0.0, atol=1e-6)
        assert np.ptp(shares[:, 0]) > 0.1


def test_hands_of_another_bind_pose_keep_their_orientation() -> None:
    """The same captured motion, relative to an A-pose."""
    down, apart = 0.7, HANDS.skeleton
    rotations = HANDS.rotations.copy()
    for side, sign in (("Left", -1.0), ("Right", 1.0)):
        arm = apart.subtree(apart.index(f"{side}Arm"))
        turn = about([0.0, 0.0, 1.0], sign * down)
        rotations[:, arm[0]] = multiply(rotations[:, arm[0]], conjugate(turn))
        rotations[:, arm[1:]] = multiply(multiply(turn, rotations[:, arm[1:]]), conjugate(turn))
    posed = replace(HANDS, skeleton=with_arms_turned(apart, down), rotations=rotations)
    clips = [world_transforms(one.skeleton, one.root_positions, one.rotations)[0] for one in (HANDS, posed)]
    np.testing.assert_allclose(clips[1], clips[0], atol=1e-9)  # the same motion
    merged = [
        merge_hands(BODY, ROLES, one, find_roles(one.skeleton), FRAMES, wrist=True)[0].rotations
        for one in (HANDS, posed)
    ]
    assert quaternion.angle(merged[0], merged[1]).max() < 1e-6


def test_a_body_without_fingers_gets_those_of_the_hands() -> None:
    walk = CLIPS["walk"].frames(0, 60)
    frames = np.linspace(100.0, 160.0, 60)
    merged, roles = merge_hands(
        walk, find_roles(walk.skeleton), OTHERS.hands, find_roles(OTHERS.hands.skeleton), {"right": frames}
    )
    joints = fingers_of(merged.skeleton, roles, "right")
    theirs = fingers_of(OTHERS.hands.skeleton, find_roles(OTHERS.hands.skeleton), "right")
    wanted = OTHERS.hands.sampled(frames)[1][:, theirs]
    assert quaternion.angle(merged.rotations[:, joints], wanted).max() < 1e-9
    left = fingers_of(merged.skeleton, roles, "left")
    assert np.array_equal(merged.rotations[:, left], np.tile(quaternion.IDENTITY, (60, 15, 1)))
    places = [merged.skeleton.index(name) for name in walk.skeleton.names]
    assert np.array_equal(merged.rotations[:, places], walk.rotations)


def test_hands_without_fingers_cannot_be_merged_into_a_body_without() -> None:
    walk, run = CLIPS["walk"], CLIPS["run"]
    frames = np.zeros(walk.frame_count)
    with pytest.raises(SkeletonError, match="neither the body nor the hands have fingers"):
        merge_hands(walk, find_roles(walk.skeleton), run, find_roles(run.skeleton), {"left": frames})
    with pytest.raises(SkeletonError, match="the hands' rig has no fingers on its left hand"):
        merge_hands(BODY, ROLES, run, find_roles(run.skeleton), {"left": np.zeros(BODY.frame_count)})
