from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.body import SKELETON
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.path import ease
from motionsplice.motion.procedural.stances import BEGIN, END, STANDING, Performer, fair, standing_action
from motionsplice.motion.procedural.variants import local_axes, with_local_axes
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.preparation.stance import Stance, departures, parts_used, rest_frames
from motionsplice.precompute.preparation.standing import NO_REST, UNUSED, measure_standing
from motionsplice.precompute.splice import splice_standing
from motionsplice.runtime.format.standing import Standing

ROLES = find_roles(SKELETON)
UP = np.array([0.0, 1.0, 0.0])
TRUNK, LEFT_ARM, RIGHT_ARM, HEAD = range(4)


def measured(clip: Clip) -> Standing:
    return measure_standing(clip, clip.frame_count, None, None, find_roles(clip.skeleton)).standing


def turned(clip: Clip, heading: Floats) -> Clip:
    """Returns the clip turned about Y, by `heading` [F] radians."""
    turn, rotations = quaternion.about(UP, heading), clip.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    return replace(clip, root_positions=quaternion.rotate(turn, clip.root_positions), rotations=rotations)


@pytest.mark.parametrize("name", STANDING)
@pytest.mark.parametrize("performer", [Performer(), fair(1)])
def test_the_frames_at_rest_are_those_before_and_after_the_gesture(name: str, performer: Performer) -> None:
    clip = standing_action(name, performer, seed=1)
    seconds = rest_frames(clip, ROLES) / clip.rate
    assert seconds[0] == 0.0
    assert seconds[-1] == clip.duration
    before, after = seconds[seconds < 2.5], seconds[seconds > 2.5]
    assert BEGIN - 0.1 < before.max() < BEGIN + 0.35  # a gesture begins slowly
    assert END - 0.35 < after.min() < END + 0.1


def test_a_clip_cut_to_its_gesture_is_at_rest_only_where_its_arms_hang_alike() -> None:
    clip = standing_action("hail", Performer(), seed=1)
    waving = clip.frames(120, 180)
    assert len(rest_frames(waving, ROLES)) == 0
    tight = clip.frames(round(BEGIN * clip.rate) + 5, round(END * clip.rate) - 5)
    rest = rest_frames(tight, ROLES)
    assert 0 < len(rest) < 0.2 * tight.frame_count


@pytest.mark.parametrize("backward", [False, True])
def test_of_two_different_poses_at_rest_the_lower_wrists_count(backward: bool) -> None:
    clip = standing_action("reload", Performer(), seed=1).frames(0, 150)
    rotations = np.concatenate([clip.rotations, np.repeat(clip.rotations[-1:], 60, axis=0)])
    roots = np.repeat(clip.root_positions[:1], len(rotations), axis=0)
    drawn = Clip("drawn", SKELETON, clip.rate, roots, rotations[::-1] if backward else rotations)
    rest = rest_frames(drawn, ROLES)
    assert rest.max() < 100 if not backward else rest.min() > 100
    assert len(rest) > 50


def test_a_person_who_only_stands_departs_from_nothing() -> None:
    clip = standing_action("bow", Performer(), seed=1).frames(0, 60)
    still = replace(clip, rotations=np.repeat(clip.rotations[:1], 60, axis=0))
    found = measure_standing(still, 60, None, None, ROLES)
    assert found.warnings == (UNUSED,)
    assert found.uses == ()
    assert quaternion.angle(found.standing.turns, quaternion.IDENTITY).max() < 1e-7
    np.testing.assert_array_equal(found.standing.usage, 0.0)


def test_usage_is_0_at_rest_and_1_in_the_gesture() -> None:
    usage = measured(standing_action("hail", Performer(), seed=1)).usage
    np.testing.assert_allclose(usage[[0, 30, -30, -1]], 0.0, atol=0.01)
    np.testing.assert_allclose(usage[[120, 150, 180], RIGHT_ARM], 1.0, atol=1e-3)
    np.testing.assert_allclose(usage[:, [TRUNK, LEFT_ARM, HEAD]], 0.0, atol=0.01)
    assert np.abs(np.diff(usage, axis=0)).max() < 0.2  # of a frame at 60 Hz


@pytest.mark.parametrize(
    ("name", "uses"),
    [
        ("hail", ("right arm",)),
        ("point", ("trunk", "left arm", "head")),
        ("jab", ("trunk", "left arm", "right arm", "head")),
        ("bow", ("trunk",)),
    ],
)
def test_the_parts_that_an_action_uses_are_named(name: str, uses: tuple[str, ...]) -> None:
    clip = standing_action(name, Performer(), seed=1)
    assert parts_used(clip, measured(clip), ROLES) == uses


def test_where_a_person_stands_and_faces_does_not_matter() -> None:
    clip = standing_action("jab", fair(1), seed=1)
    moved = replace(
        turned(clip, np.full(clip.frame_count, 2.0)), root_positions=clip.root_positions + np.array([3.0, 0.0, 1.0])
    )
    for one, other in zip(*((m.turns, m.usage, m.stance[1:]) for m in map(measured, (clip, moved))), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_hips_that_turn_with_a_gesture_count_but_a_person_who_turns_does_not() -> None:
    clip = standing_action("hail", Performer(), seed=1)
    seconds = np.arange(clip.frame_count) / clip.rate
    twist = np.radians(30.0) * (ease((seconds - 1.5) / 0.5) - ease((seconds - 3.0) / 0.5))
    twisted = measured(turned(clip, twist)).turns
    angles = quaternion.angle(twisted, measured(clip).turns)
    np.testing.assert_allclose(angles, twist, atol=1e-6)
    walked_round = measured(turned(clip, np.radians(170.0) * ease((seconds - 0.5) / 4.0))).turns
    assert quaternion.angle(walked_round, measured(clip).turns).max() < np.radians(12.0)


def test_without_frames_at_rest_the_whole_upper_body_is_posed() -> None:
    clip = standing_action("hail", Performer(), seed=1).frames(120, 180)
    found = measure_standing(clip, 60, None, None, ROLES)
    assert found.warnings == (NO_REST,)
    np.testing.assert_array_equal(found.standing.usage, 1.0)


def test_an_idle_shows_the_stance_of_a_clip_without_frames_at_rest() -> None:
    whole = standing_action("hail", Performer(), seed=1)
    waving, idle = whole.frames(120, 180), whole.frames(0, 50)
    found = measure_standing(waving, 60, idle, None, ROLES)
    assert found.warnings == ()
    expected = measured(whole)
    np.testing.assert_allclose(found.standing.usage, expected.usage[120:180], atol=0.02)
    assert quaternion.angle(found.standing.stance[1:], expected.stance[1:]).max() < np.radians(1.0)


def test_a_mask_poses_its_parts_and_drives_no_others() -> None:
    clip = standing_action("jab", Performer(), seed=1)
    found = measure_standing(clip, clip.frame_count, None, "right_arm", ROLES)
    np.testing.assert_array_equal(found.standing.usage, np.tile([0.0, 0.0, 1.0, 0.0], (clip.frame_count, 1)))
    assert found.standing.parts == 1 << RIGHT_ARM
    assert found.uses == ("right arm",)


def test_a_person_at_rest_leaves_the_locomotion_as_it_is() -> None:
    clip, walk = standing_action("bow", Performer(), seed=1).frames(0, 60), make("walk", seconds=2.0)
    still = replace(clip, rotations=np.repeat(clip.rotations[:1], 60, axis=0))
    result = splice_standing(walk, still, ROLES, measured(still))
    assert quaternion.angle(result.rotations, walk.rotations).max() < 1e-7


def test_the_splice_does_not_depend_on_local_axes() -> None:
    axes = local_axes(SKELETON.joint_count, 3)
    walk, jab = make("walk", seconds=3.0), standing_action("jab", fair(1), seed=1)
    plain = splice_standing(walk, jab, ROLES, measured(jab))
    others = with_local_axes(walk, axes), with_local_axes(jab, axes)
    result = splice_standing(*others, ROLES, measured(others[1]))
    np.testing.assert_allclose(joint_positions(result), joint_positions(plain), atol=1e-9)


def test_usage_takes_a_limb_from_the_added_to_its_own_rotation() -> None:
    walk, jab = make("walk", seconds=4.0), standing_action("jab", Performer(), seed=1)
    measured_jab, arm, frame = measured(jab), SKELETON.index("RightForeArm"), 150
    added = quaternion.multiply(quaternion.conjugate(measured_jab.stance[arm]), jab.rotations[frame, arm])
    added = quaternion.multiply(walk.rotations[frame, arm], added)
    apart = quaternion.angle(added, jab.rotations[frame, arm])
    for share in (0.0, 0.3, 1.0):
        given = replace(measured_jab, usage=np.full_like(measured_jab.usage, share))
        found = splice_standing(walk, jab, ROLES, given).rotations[frame, arm]
        assert quaternion.angle(found, added) == pytest.approx(share * apart, rel=0.02, abs=1e-6)


def test_the_stance_of_an_idle_is_its_mean_pose() -> None:
    clip = standing_action("bow", Performer(), seed=1).frames(0, 60)
    stance = Stance.of(clip, np.arange(60), ROLES)
    apart = quaternion.angle(clip.rotations[:, 1:], stance.rotations[1:]).max(axis=1)
    assert apart.max() < np.radians(2.0)
    assert quaternion.angle(departures(clip, stance, ROLES, np.arange(60)).turns, quaternion.IDENTITY).max() < 0.03
