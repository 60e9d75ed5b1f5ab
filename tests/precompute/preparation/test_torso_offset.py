from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bench.quality.measures import upper_body_errors
from motionsplice.motion import quaternion
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.preparation.torso_offset import MeanStride, believed, shoulder_motion, torso_offsets
from motionsplice.precompute.splice import splice_exact
from tests.conftest import CLIPS

WALK, PUNCH = CLIPS["walk"], make("walk", "punch", seed=9, seconds=5.0)
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
PHASE = align(WALK, ROLES, RING).phase
TORSO = measure_torso(WALK, ROLES).upright
STRIDE = MeanStride.of(TORSO, PHASE)


@given(st.integers(0, 2**32 - 1), st.floats(2.0, 6.0))
@settings(max_examples=25)
def test_a_cloud_that_repeats_every_stride_equals_its_mean_stride(seed: int, strides: float) -> None:
    draw = np.random.default_rng(seed)
    shape = MeanStride(draw.normal(size=(9, 5, 3)))
    phase = np.linspace(0.3, 0.3 + strides, 400)
    np.testing.assert_allclose(MeanStride.of(shape.at(phase), phase).at(phase), shape.at(phase), atol=2e-3)


def test_a_plain_gait_has_hardly_any_torso_offset() -> None:
    assert np.degrees(shoulder_motion(torso_offsets(TORSO, PHASE, WALK.rate, STRIDE))) < 0.6


def test_motion_added_to_a_gait_is_recovered_as_torso_offset() -> None:
    seconds = np.arange(WALK.frame_count) / WALK.rate
    swayed = Rotation.from_euler("YX", np.stack([0.25 * np.sin(3.0 * seconds), 0.2 + 0.0 * seconds], axis=1)).as_quat()
    offsets = torso_offsets(quaternion.rotate(swayed[:, None], TORSO), PHASE, WALK.rate, STRIDE)
    assert np.degrees(quaternion.angle(offsets, swayed)[20:-20]).max() < 2.0
    assert shoulder_motion(offsets) == pytest.approx(0.25 / np.sqrt(2.0), abs=0.03)


def test_offsets_of_a_whole_cycle_repeat_with_it() -> None:
    turns = quaternion.about([1.0, 0.0, 0.0], 0.2 * np.sin(2.0 * np.pi * (np.arange(40) + 0.3) / 30.0))
    phase = np.arange(40) / 30.0
    mean = MeanStride(np.random.default_rng(1).normal(size=(9, 5, 3)))
    offsets = torso_offsets(quaternion.rotate(turns[:, None], mean.at(phase)), phase, 30.0, mean, 30)
    np.testing.assert_array_equal(offsets[30:], offsets[:10])
    steps = quaternion.angle(offsets[1:31], offsets[:30])
    assert steps.max() < 1.05 * 0.2 * 2.0 * np.pi / 30.0
    assert np.abs(np.diff(steps)).max() < 0.01


def test_a_clip_shorter_than_a_stride_still_has_a_mean_stride() -> None:
    part = slice(0, int(np.searchsorted(PHASE, PHASE[0] + 0.6)))
    elsewhere = MeanStride.of(TORSO[part], PHASE[part]).at(np.linspace(0.0, 1.0, 50))
    assert np.abs(elsewhere - TORSO.mean(axis=0)).max() < 0.3


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.5), st.floats(0.0, 1.0))
def test_motion_of_an_offset_counts_by_how_far_it_exceeds_the_noise(seed: int, size: float, share: float) -> None:
    draw = np.random.default_rng(seed)
    mean = quaternion.normalise(draw.normal(size=4))
    mean = mean if mean[3] >= 0.0 else -mean
    turns = quaternion.exp(size * np.sin(np.linspace(0.0, 8.0 * np.pi, 200))[:, None] * [0.6, 0.0, 0.8])
    offsets = quaternion.one_hemisphere(quaternion.multiply(mean, turns))
    motion = shoulder_motion(offsets)
    found = believed(offsets, 200, share * motion)
    assert shoulder_motion(found) == pytest.approx(motion * (1.0 - share**2), abs=1e-3 * motion)
    assert quaternion.angle(believed(offsets, 200, 2.0 * motion), mean).max() < 1e-3
    np.testing.assert_allclose(quaternion.angle(believed(offsets, 200, 0.0), offsets), 0.0, atol=1e-6)


def test_relative_posture_keeps_the_shoulder_motion_of_a_punch() -> None:
    """Deliberate shoulder motion is a limitation of the papers (Heck et al. 2006, section 5)."""
    offsets = torso_offsets(measure_torso(PUNCH, ROLES).upright, align(PUNCH, ROLES, RING).phase, PUNCH.rate, STRIDE)
    curve, truth = make("curve", seed=11), make("curve", "punch", seed=11)
    errors = {}
    for posture in ("off", "relative"):
        result = splice_exact(curve, PUNCH, ROLES, posture=posture, torso_offsets=(None, offsets)).clip
        errors[posture] = upper_body_errors(result, truth, ROLES).mean()
    assert errors["relative"] < 0.7 * errors["off"]
