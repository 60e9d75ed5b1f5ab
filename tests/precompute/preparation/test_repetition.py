from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.joint_paths import upper_joints
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.preparation.repetition import mean_distance, stride_to_stride
from tests.conftest import CLIPS

WALK = CLIPS["walk"]
ROLES = find_roles(WALK.skeleton)
CLOUDS = measure_torso(WALK, ROLES).clouds
PHASE = align(WALK, ROLES, find_baseline(WALK, ROLES)).phase


def test_equal_strides_do_not_differ_and_uneven_strides_do() -> None:
    assert 0.0 < stride_to_stride(WALK, CLOUDS, PHASE, ROLES) < 0.01
    uneven = WALK.rotations.copy()
    raised = quaternion.about([0.0, 0.0, 1.0], np.linspace(0.0, 1.5, WALK.frame_count))
    uneven[:, ROLES.left_shoulder] = quaternion.multiply(uneven[:, ROLES.left_shoulder], raised)
    assert stride_to_stride(replace(WALK, rotations=uneven), CLOUDS, PHASE, ROLES) > 0.02


def test_less_than_a_stride_and_a_half_says_nothing() -> None:
    assert stride_to_stride(WALK.frames(0, 60), CLOUDS[:60], PHASE[:60], ROLES) == 0.0


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_it_does_not_depend_on_where_the_person_goes(turn: float) -> None:
    about = quaternion.about([0.0, 1.0, 0.0], np.linspace(0.0, turn, WALK.frame_count))
    rotations = WALK.rotations.copy()
    rotations[:, 0] = quaternion.multiply(about, rotations[:, 0])
    turned = replace(WALK, root_positions=WALK.root_positions + np.array([3.0, 0.0, 1.0]), rotations=rotations)
    wanted = stride_to_stride(WALK, CLOUDS, PHASE, ROLES)
    assert stride_to_stride(turned, CLOUDS, PHASE, ROLES) == pytest.approx(wanted, rel=1e-9)


def test_joints_are_seen_from_the_pelvis() -> None:
    upper = WALK.skeleton.subtree(ROLES.pelvis)[1:]
    positions = joint_positions(WALK)
    apart = np.linalg.norm(positions[:, upper] - positions[:, ROLES.pelvis, None], axis=2)
    np.testing.assert_allclose(np.linalg.norm(upper_joints(WALK, ROLES), axis=2), apart, atol=1e-12)


def test_the_kernel_agrees_with_numpy() -> None:
    random = np.random.default_rng(1)
    points, turns = random.normal(size=(9, 4, 3)), quaternion.normalise(random.normal(size=(5, 4)))
    frames, later = np.array([0, 2, 3, 5, 8]), np.array([1.25, 0.0, 7.5, 8.0, 2.9])
    turned = quaternion.rotate(turns[:, None], quaternion.interpolated(points, later))
    wanted = np.linalg.norm(points[frames] - turned, axis=2).mean()
    assert mean_distance(points, frames, *quaternion.neighbours(9, later), turns) == pytest.approx(wanted, rel=1e-14)
