from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError, SkeletonError
from motionsplice.motion.quaternion import IDENTITY, Floats, about
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.hands.points import HandMotion, bones, hand_motion
from tests.conftest import CLIPS


def below_the_left_wrist(clip: Clip, names: Sequence[str], above: Sequence[int], tip: Floats) -> Clip:
    """Returns the clip with more joints, all at the left wrist, and an end site at `tip` of the last one."""
    skeleton = clip.skeleton
    more = Skeleton(
        names=(*skeleton.names, *names),
        parents=np.append(skeleton.parents, above),
        offsets=np.concatenate([skeleton.offsets, np.zeros((len(names), 3))]),
        end_parents=np.array([skeleton.joint_count + len(names) - 1]),
        end_offsets=tip[None],
    )
    rotations = np.tile(IDENTITY, (clip.frame_count, more.joint_count, 1))
    rotations[:, : skeleton.joint_count] = clip.rotations
    return replace(clip, skeleton=more, rotations=rotations)


def with_left_forearm(clip: Clip, offset: Sequence[float]) -> Clip:
    """Returns the same motion on a rig whose left forearm in the bind pose is `offset` [3], metres."""
    skeleton, offsets = clip.skeleton, clip.skeleton.offsets.copy()
    offsets[find_roles(skeleton).left_wrist] = offset
    return replace(clip, skeleton=replace(skeleton, offsets=offsets))


@pytest.mark.parametrize("count", [2, 3000])
def test_joints_at_the_wrist_are_not_the_hands_point(count: int) -> None:
    """Neither siblings, nor a chain of any length."""
    clip = CLIPS["walk"].frames(0, 20)
    wrist, first = clip.skeleton.index("LeftHand"), clip.skeleton.joint_count
    above = [wrist, wrist, *range(first + 1, first + count - 1)]
    on_it = below_the_left_wrist(clip, [f"LeftMitten{one}" for one in range(count)], above, np.array([0.04, 0.0, 0.0]))
    moves = hand_motion(on_it, find_roles(clip.skeleton), "left")
    assert np.isfinite(bones(moves.points)).all()
    wrists = moves.points[:, :2].mean(axis=1)
    np.testing.assert_allclose(np.linalg.norm(moves.points[:, 3] - wrists, axis=1), 0.04, atol=1e-9)


def test_a_joint_at_the_wrist_bends_the_palm() -> None:
    clip = CLIPS["walk"].frames(0, 20)
    wrist = clip.skeleton.index("LeftHand")
    mitten = below_the_left_wrist(clip, ["LeftMitten"], [wrist], np.array([0.04, 0.0, 0.0]))
    bent = mitten.rotations.copy()
    bent[:, -1] = about([0.0, 0.0, 1.0], 0.5)
    found = [
        bones(hand_motion(one, find_roles(clip.skeleton), "left").points)
        for one in (mitten, replace(mitten, rotations=bent))
    ]
    np.testing.assert_allclose(found[0][:, 0], found[1][:, 0], atol=1e-12)
    np.testing.assert_allclose(np.sum(found[0][:, 1] * found[1][:, 1], axis=1), np.cos(0.5), atol=1e-9)


@pytest.mark.parametrize("ahead", [0.25, -0.25])
def test_a_forearm_that_points_ahead_in_the_bind_pose_has_its_thumb_above(ahead: float) -> None:
    clip = with_left_forearm(CLIPS["walk"], [0.0, 0.0, ahead])
    still = replace(clip, rotations=np.tile(IDENTITY, (clip.frame_count, clip.skeleton.joint_count, 1)))
    across = np.diff(hand_motion(still, find_roles(clip.skeleton), "left").points[:, :2], axis=1)[:, 0]
    np.testing.assert_allclose(across, np.tile([0.0, -0.06, 0.0], (clip.frame_count, 1)), atol=1e-9)


def test_a_forearm_without_length_is_refused() -> None:
    clip = with_left_forearm(CLIPS["walk"], [0.0, 0.0, 0.0])
    with pytest.raises(SkeletonError, match="the left forearm has no length"):
        hand_motion(clip, find_roles(clip.skeleton), "left")
    hand_motion(clip, find_roles(clip.skeleton), "right")


def test_points_of_a_wrong_shape_or_not_finite_are_refused() -> None:
    with pytest.raises(ClipError, match="four points"):
        HandMotion(np.zeros((3, 5, 3)))
    with pytest.raises(ClipError, match="not a finite number"):
        HandMotion(np.full((3, 4, 3), np.nan))
