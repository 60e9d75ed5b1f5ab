from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.retarget import measures
from bench.retarget.kinds import KINDS
from bench.retarget.measures import Posed
from bench.retarget.rigs import on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SkeletonError
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.by_roles import retarget
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton

BUILT_IN = make("curve", "wave", seconds=2.0, rate=30.0)
RIGS = {name: on_rig(BUILT_IN, kind) for name, kind in KINDS.items()}
POSED = {name: Posed.of(clip, find_roles(clip.skeleton)) for name, clip in RIGS.items()}


def moved(start: Posed, end: Posed) -> Posed:
    """Returns the motion of one rig on the other."""
    pose = standing_pose(end.clip.skeleton, end.roles, end.clip)
    return Posed.of(retarget(start.clip, start.roles, end.clip.skeleton, end.roles, pose).clip, end.roles)


@pytest.mark.parametrize(("start", "end"), list(permutations(KINDS, 2)))
def test_a_motion_keeps_its_directions_on_every_rig_and_comes_back(start: str, end: str) -> None:
    theirs, ours = POSED[start], POSED[end]
    got = moved(theirs, ours)
    assert measures.limbs(theirs, got) < 1e-3
    assert measures.trunk(theirs, got) < 0.5
    assert measures.shoulder_line(theirs, got) < 0.5
    assert measures.ankles(theirs, got) < 5.0
    assert measures.limbs(theirs, moved(got, theirs)) < 1e-3


@pytest.mark.parametrize(("start", "end"), list(permutations(KINDS, 2)))
def test_limbs_do_not_roll_and_feet_stay_flat(start: str, end: str) -> None:
    got, truth = moved(POSED[start], POSED[end]), POSED[end]
    rolled = 12.6 if "Unreal" in (start, end) else 0.1  # half of the angle between palms of its bind pose and others'
    assert measures.turn_errors(got, truth, ("thigh", "shin", "arm")) < rolled
    assert measures.turn_errors(got, truth, ("foot", "toe")) < (6.0 if "LAFAN1" in (start, end) else 0.01)
    assert measures.turn_errors(got, truth, ("root", "head", "neck", "collar")) < 0.01
    fingered = not {"CMU", "LAFAN1"} & {start, end}
    if fingered or "Unreal" not in (start, end):  # without fingers, the palm of a bind pose is unknown
        assert measures.turn_errors(got, truth, ("hand",)) < 0.01


def test_fingers_follow() -> None:
    got, truth = moved(POSED["Unreal"], POSED["Rigify"]), POSED["Rigify"]
    fingers = [joint for joint, name in enumerate(truth.clip.skeleton.names) if "DEF-f_" in name]
    assert len(fingers) == 30
    assert quaternion.angle(got.rotations[:, fingers], truth.rotations[:, fingers]).max() < 1e-3


def test_the_middle_of_the_hips_is_scaled_by_the_legs() -> None:
    theirs, got = POSED["Unreal"], moved(POSED["Unreal"], POSED["VRM"])
    for one in (theirs, got):
        assert one.leg == pytest.approx(one.roles.leg_length(one.clip.skeleton))
    middles = [0.5 * (one.at("left_hip") + one.at("right_hip")) / one.leg for one in (theirs, got)]
    np.testing.assert_allclose(middles[0], middles[1], atol=1e-9)


def test_a_clip_on_its_own_rig_is_unchanged() -> None:
    for name, one in POSED.items():
        got = moved(one, one).clip
        np.testing.assert_allclose(got.root_positions, one.clip.root_positions, atol=1e-9, err_msg=name)
        assert quaternion.angle(got.rotations, one.clip.rotations).max() < 1e-6, name


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1), st.integers(1, 21))
def test_limbs_point_as_they_did_whatever_the_axes_of_their_joints(turn: tuple[float, ...], joint: int) -> None:
    theirs, ours = POSED["LAFAN1"], POSED["built-in"]
    limbs = [place for place, name in enumerate(theirs.clip.skeleton.names) if "Arm" in name or "Leg" in name]
    clip = with_axes(theirs.clip, limbs[joint % len(limbs)], quaternion.normalise(turn))
    got = retarget(clip, theirs.roles, ours.clip.skeleton, ours.roles).clip
    assert measures.limbs(theirs, Posed.of(got, ours.roles)) < 1e-3


def with_axes(clip: Clip, joint: int, turn: np.ndarray) -> Clip:
    """Returns the same motion with the axes of a joint, and of all below it, turned by [4] in the bind pose."""
    skeleton, below = clip.skeleton, clip.skeleton.subtree(joint)
    offsets, ends, rotations = skeleton.offsets.copy(), skeleton.end_offsets.copy(), clip.rotations.copy()
    inside = np.isin(skeleton.parents, below)
    offsets[inside] = quaternion.rotate(turn, offsets[inside])
    tips = np.isin(skeleton.end_parents, below)
    ends[tips] = quaternion.rotate(turn, ends[tips])
    back = quaternion.conjugate(turn)
    rotations[:, joint] = quaternion.multiply(rotations[:, joint], back)
    inner = below[1:]
    rotations[:, inner] = quaternion.multiply(turn, quaternion.multiply(rotations[:, inner], back))
    return replace(clip, skeleton=replace(skeleton, offsets=offsets, end_offsets=ends), rotations=rotations)


def test_moving_joints_without_a_counterpart_are_named() -> None:
    theirs, ours = POSED["built-in"], POSED["CMU"]
    left_out = retarget(theirs.clip, theirs.roles, ours.clip.skeleton, ours.roles).left_out
    assert "LeftHandIndex1" not in left_out  # the fingers rest
    clip = theirs.clip
    thumb = clip.skeleton.index("LeftHandThumb1")
    turning = clip.rotations.copy()
    turning[:, thumb] = quaternion.about([1.0, 0.0, 0.0], np.linspace(0.0, 1.0, clip.frame_count))
    again = retarget(replace(clip, rotations=turning), theirs.roles, ours.clip.skeleton, ours.roles).left_out
    assert set(again) - set(left_out) == {"LeftHandThumb1"}


def test_joints_without_a_role_keep_their_bind_rotation() -> None:
    got = moved(POSED["CMU"], POSED["Unreal"]).clip
    fingers = [joint for joint, name in enumerate(got.skeleton.names) if "index" in name or "thumb" in name]
    assert fingers
    assert np.all(got.rotations[:, fingers] == quaternion.IDENTITY)


def test_a_rig_with_a_single_joint_in_its_trunk_takes_the_turn_of_the_chest() -> None:
    theirs, rig = POSED["built-in"], POSED["built-in"].clip.skeleton
    spine, chest = rig.index("Spine"), rig.index("Spine2")
    kept = [joint for joint in range(rig.joint_count) if joint not in (rig.index("Spine1"), chest)]
    parents = [spine if rig.parents[joint] == chest else int(rig.parents[joint]) for joint in kept]
    one = Skeleton(
        names=tuple(rig.names[joint] for joint in kept),
        parents=np.array([-1] + [kept.index(parent) for parent in parents[1:]]),
        offsets=rig.offsets[kept],
        end_parents=np.zeros(0, np.int64),
        end_offsets=np.zeros((0, 3)),
    )
    got = Posed.of(retarget(theirs.clip, theirs.roles, one, find_roles(one)).clip, find_roles(one))
    turns = got.rotations[:, one.index("Spine")], theirs.rotations[:, chest]
    assert quaternion.angle(*turns).max() < 1e-6
    assert measures.limbs(theirs, got) < 1e-3


def test_legs_without_length_are_an_error() -> None:
    clip, roles = POSED["built-in"].clip, POSED["built-in"].roles
    offsets = clip.skeleton.offsets.copy()
    offsets[[roles.left_knee, roles.right_knee, roles.left_ankle, roles.right_ankle]] = 0.0
    flat = replace(clip, skeleton=replace(clip.skeleton, offsets=offsets))
    with pytest.raises(SkeletonError, match="legs have no length"):
        retarget(flat, roles, clip.skeleton, roles)
