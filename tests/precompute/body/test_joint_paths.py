from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.variants import local_axes, with_local_axes
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.joint_paths import Followed, joint_paths, joint_transforms, picked_joints
from tests import naive
from tests.conftest import CLIPS

WALK = with_local_axes(CLIPS["walk"].frames(0, 4), local_axes(CLIPS["walk"].skeleton.joint_count, seed=1))
JOINTS = st.lists(st.integers(0, WALK.skeleton.joint_count - 1), min_size=1, max_size=6)


@given(JOINTS)
@settings(max_examples=30)
def test_a_few_joints_match_forward_kinematics_of_all_joints(joints: list[int]) -> None:
    positions, world = world_transforms(WALK.skeleton, WALK.root_positions, WALK.rotations)
    found_positions, found_world = joint_transforms(WALK, joints)
    np.testing.assert_allclose(found_positions, positions[:, joints], atol=1e-13)
    np.testing.assert_allclose(found_world, world[:, joints], atol=1e-13)
    np.testing.assert_array_equal(joint_paths(WALK, joints), found_positions)


def test_all_joints_match_the_slow_twin() -> None:
    positions, world = naive.world_transforms(WALK.skeleton, WALK.root_positions, WALK.rotations)
    found = world_transforms(WALK.skeleton, WALK.root_positions, WALK.rotations)
    np.testing.assert_allclose(found[0], positions, atol=1e-13)
    np.testing.assert_allclose(found[1], world, atol=1e-13)


def test_a_followed_clip_gives_the_same_paths() -> None:
    roles = find_roles(WALK.skeleton)
    followed = Followed.of(WALK, roles)
    parent = int(WALK.skeleton.parents[roles.pelvis])
    for joints, turning in (((roles.head, *roles.feet[0]), 0), ((roles.pelvis, parent, roles.left_hip), 2), ((3,), 1)):
        found, wanted = (joint_transforms(clip, joints, turning=turning) for clip in (followed, WALK))
        np.testing.assert_array_equal(found[0], wanted[0])
        np.testing.assert_array_equal(found[1], wanted[1])


def test_a_followed_clip_with_other_frames_is_followed_anew() -> None:
    roles = find_roles(WALK.skeleton)
    raised = replace(Followed.of(WALK, roles), root_positions=WALK.root_positions + np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(joint_paths(raised, (0,))[:, 0], raised.root_positions)


@given(JOINTS)
@settings(max_examples=30)
def test_picked_joints_are_those_of_numpy(joints: list[int]) -> None:
    at = np.array(joints)
    for values in (WALK.rotations, WALK.rotations[..., :3], WALK.rotations[::2]):
        np.testing.assert_array_equal(picked_joints(values, at), np.take(values, at, axis=1))
