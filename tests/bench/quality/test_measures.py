from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.quality.measures import (
    change_within_halves,
    hand_speeds,
    hurry,
    mismatch,
    neck_excursion,
    neck_jitter,
    posture_angle,
    posture_error,
    promised_posture,
    upper_body_errors,
)
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.posture import measure_torso
from tests.conftest import CLIPS

WALK, BOX = CLIPS["walk"], CLIPS["carry_box"]
ROLES = find_roles(WALK.skeleton)
UPPER = WALK.skeleton.subtree(ROLES.pelvis)


def test_the_error_is_zero_against_itself_and_known_against_a_bent_copy() -> None:
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


def test_excursion_measures_the_neck_and_ignores_turning() -> None:
    turned = WALK.rotations.copy()
    spin = quaternion.about([0.0, 1.0, 0.0], np.linspace(0.0, 6.0, WALK.frame_count))
    turned[:, 0] = quaternion.multiply(spin, turned[:, 0])
    assert neck_excursion(replace(WALK, rotations=turned), ROLES) == pytest.approx(neck_excursion(WALK, ROLES))
    bowed = WALK.rotations.copy()
    bowed[100, ROLES.pelvis] = quaternion.multiply(bowed[100, ROLES.pelvis], quaternion.about([1.0, 0.0, 0.0], 0.8))
    assert neck_excursion(replace(WALK, rotations=bowed), ROLES) > 0.15 > neck_excursion(WALK, ROLES)


def test_a_change_within_a_half_counts_and_one_of_the_pelvis_does_not() -> None:
    for joint, found in ((ROLES.pelvis, 0.0), (ROLES.left_elbow, 0.1), (ROLES.left_knee, 0.1)):
        bent = WALK.rotations.copy()
        bent[7, joint] = quaternion.multiply(bent[7, joint], quaternion.about([0.0, 0.0, 1.0], 0.1))
        change = change_within_halves(replace(WALK, rotations=bent), WALK, WALK.rotations, ROLES)
        assert change == pytest.approx(found, abs=1e-7)


def test_mismatch_is_zero_at_equal_frames_and_large_half_a_stride_later() -> None:
    frames = np.arange(float(WALK.frame_count))
    assert mismatch(WALK, WALK, frames, ROLES).max() < 1e-7
    assert mismatch(WALK.frames(0, 200), WALK, frames[:200] + 33.0, ROLES).mean() > 0.03


@pytest.mark.parametrize(("posture", "wanted"), [("off", WALK), ("absolute", BOX), ("running", BOX)])
def test_a_posture_form_promises_the_posture_of_one_source(posture: str, wanted: Clip) -> None:
    none = np.tile(quaternion.IDENTITY, (WALK.frame_count, 1))
    promised = promised_posture(WALK, BOX, none, posture, ROLES)
    assert posture_angle(promised, measure_torso(wanted, ROLES).posture) < 1e-6


def test_relative_promises_the_locomotions_posture_turned() -> None:
    lean = np.tile(quaternion.about([1.0, 0.0, 0.0], -0.2), (WALK.frame_count, 1))
    promised = promised_posture(WALK, BOX, lean, "relative", ROLES)
    assert posture_angle(promised, measure_torso(WALK, ROLES).posture) == pytest.approx(0.2, abs=0.01)


def test_hands_hurry_as_much_as_they_are_played_faster() -> None:
    assert hurry(replace(WALK, rate=2.0 * WALK.rate), WALK, ROLES) == pytest.approx(2.0, rel=0.1)
    assert hurry(WALK, WALK, ROLES) == 1.0


def test_hands_that_only_the_trunk_moves_are_in_no_hurry() -> None:
    rotations = np.tile(WALK.rotations[:1], (WALK.frame_count, 1, 1))
    held = replace(WALK, rotations=rotations.copy())
    swing = quaternion.about([0.0, 1.0, 0.0], np.sin(np.arange(WALK.frame_count) / 5.0))
    rotations[:, ROLES.pelvis] = quaternion.multiply(swing, rotations[:, ROLES.pelvis])
    assert hand_speeds(replace(WALK, rotations=rotations), ROLES).max() < 1e-6
    assert hurry(WALK, held, ROLES) is None
