from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.measures import arm_lag, lag_error, neck_jitter, posture_error, upper_body_errors
from motion import quaternion
from motion.roles import find_roles
from precompute.baseline import align, find_baseline
from tests.conftest import CLIPS

WALK, BOX = CLIPS["walk"], CLIPS["carry_box"]
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
PHASE = align(WALK, ROLES, RING).phase
UPPER = WALK.skeleton.subtree(ROLES.pelvis)


def test_a_clip_is_at_no_distance_from_itself_and_at_a_known_one_from_a_bent_copy() -> None:
    assert upper_body_errors(WALK, WALK, ROLES).max() == 0.0
    turn = quaternion.about([0.0, 0.0, 1.0], 0.1)
    bent = WALK.rotations.copy()
    hand = WALK.skeleton.index("LeftForeArm")
    bent[:, hand] = quaternion.multiply(bent[:, hand], turn)
    errors = upper_body_errors(replace(WALK, rotations=bent), WALK, ROLES)
    wrist = [joint for joint in UPPER if joint != ROLES.pelvis].index(ROLES.left_wrist)
    reach = WALK.skeleton.bone_length(ROLES.left_wrist)
    np.testing.assert_allclose(errors[:, wrist], 2.0 * reach * np.sin(0.05), rtol=1e-6)
    assert np.count_nonzero(errors.max(axis=0) > 1e-9) == 1


def test_arms_swing_with_the_opposite_legs_and_half_a_stride_from_their_own() -> None:
    assert abs(arm_lag(WALK, PHASE, ROLES)) < 0.1
    crossed = replace(ROLES, left_wrist=ROLES.right_wrist, left_shoulder=ROLES.right_shoulder,
                      right_wrist=ROLES.left_wrist, right_shoulder=ROLES.left_shoulder)  # fmt: skip
    assert abs(arm_lag(WALK, PHASE, crossed)) == pytest.approx(0.5, abs=0.1)
    assert np.isnan(arm_lag(BOX, align(BOX, ROLES, RING).phase, ROLES))


@pytest.mark.parametrize("part", [0.1, 0.25, -0.2])
def test_arms_that_are_late_are_told_by_how_much(part: float) -> None:
    frames = np.arange(60, WALK.frame_count - 60)
    late = np.interp(PHASE[frames] - part, PHASE, np.arange(WALK.frame_count))
    rotations = WALK.rotations[frames].copy()
    rotations[:, UPPER] = WALK.sampled(late)[1][:, UPPER]
    truth = WALK.frames(60, WALK.frame_count - 60)
    result = replace(truth, rotations=rotations)
    assert lag_error(result, truth, PHASE[frames], ROLES) == pytest.approx(2 * np.pi * abs(part), abs=0.06)
    assert arm_lag(result, PHASE[frames], ROLES) - arm_lag(truth, PHASE[frames], ROLES) == pytest.approx(part, abs=0.01)


def test_posture_error_is_the_lean() -> None:
    lean = quaternion.about([1.0, 0.0, 0.0], -0.2)
    rotations = WALK.rotations.copy()
    parent = quaternion.multiply(quaternion.conjugate(rotations[:, 0]), lean)
    rotations[:, ROLES.pelvis] = quaternion.multiply(
        quaternion.multiply(parent, rotations[:, 0]), rotations[:, ROLES.pelvis]
    )
    assert posture_error(replace(WALK, rotations=rotations), WALK, ROLES) == pytest.approx(0.2, abs=0.02)


def test_jitter_is_the_third_derivative() -> None:
    still = replace(WALK, rotations=np.tile(WALK.rotations[:1], (WALK.frame_count, 1, 1)))
    assert neck_jitter(still, ROLES) < 1e-6
    shaken = WALK.rotations.copy()
    wobble = 0.05 * np.random.default_rng(0).normal(size=WALK.frame_count)
    shaken[:, ROLES.pelvis] = quaternion.multiply(shaken[:, ROLES.pelvis], quaternion.about([1.0, 0.0, 0.0], wobble))
    assert neck_jitter(replace(WALK, rotations=shaken), ROLES) > 5.0 * neck_jitter(WALK, ROLES)
