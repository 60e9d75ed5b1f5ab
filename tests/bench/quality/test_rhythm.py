from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.quality.rhythm import arm_lag, concentration, knee_passes, lag_error, swing
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from tests.conftest import CLIPS

WALK, BOX = CLIPS["walk"], CLIPS["carry_box"]
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
PHASE = align(WALK, ROLES, RING).phase
UPPER = WALK.skeleton.subtree(ROLES.pelvis)


def test_arms_swing_in_phase_with_the_opposite_legs() -> None:
    assert abs(arm_lag(WALK, PHASE, ROLES)) < 0.1
    crossed = replace(ROLES, left_wrist=ROLES.right_wrist, left_shoulder=ROLES.right_shoulder,
                      right_wrist=ROLES.left_wrist, right_shoulder=ROLES.left_shoulder)  # fmt: skip
    assert abs(arm_lag(WALK, PHASE, crossed)) == pytest.approx(0.5, abs=0.1)
    assert np.isnan(arm_lag(BOX, align(BOX, ROLES, RING).phase, ROLES))


@pytest.mark.parametrize("part", [0.1, 0.25, -0.2])
def test_the_lag_of_late_arms_is_measured(part: float) -> None:
    frames = np.arange(60, WALK.frame_count - 60)
    late = np.interp(PHASE[frames] - part, PHASE, np.arange(WALK.frame_count))
    rotations = WALK.rotations[frames].copy()
    rotations[:, UPPER] = WALK.sampled(late)[1][:, UPPER]
    truth = WALK.frames(60, WALK.frame_count - 60)
    result = replace(truth, rotations=rotations)
    assert lag_error(result, truth, PHASE[frames], ROLES) == pytest.approx(2 * np.pi * abs(part), abs=0.06)
    assert arm_lag(result, PHASE[frames], ROLES) - arm_lag(truth, PHASE[frames], ROLES) == pytest.approx(part, abs=0.01)


def test_an_arm_that_the_legs_do_not_time_has_no_lag() -> None:
    """As when dribbling: the arms swing enough, but not in time with the legs."""
    frames = np.linspace(0.0, WALK.frame_count - 1.0, WALK.frame_count)
    rotations = WALK.rotations.copy()
    rotations[:, UPPER] = WALK.sampled(np.mod(2.37 * frames, WALK.frame_count - 1.0))[1][:, UPPER]
    other = replace(WALK, rotations=rotations)
    assert np.ptp(swing(other, ROLES, "left_wrist", "left_shoulder")) > 0.2
    assert np.isnan(arm_lag(other, PHASE, ROLES))


@pytest.mark.parametrize("locomotion", ["walk", "curve", "run", "stairs_up"])
def test_the_left_knee_passes_once_a_stride_at_one_phase(locomotion: str) -> None:
    clip = make(locomotion, seed=4, seconds=7.0)
    phase, passes = align(clip, ROLES, RING).phase, knee_passes(clip, ROLES)
    assert abs(len(passes) - (phase[-1] - phase[0])) <= 1.0
    assert concentration(phase[passes]) > 0.97
    apart = swing(clip, ROLES, "left_knee", "right_knee")
    assert np.all(apart[passes - 5] < apart[passes + 5])


def test_trembling_knees_do_not_count_as_passes() -> None:
    trembling = WALK.rotations.copy()
    still = trembling[:1].repeat(WALK.frame_count, axis=0)
    half = WALK.frame_count // 2
    stopped = replace(WALK, rotations=np.concatenate([trembling[:half], still[half:]]))
    assert np.all(knee_passes(stopped, ROLES) < half + 3)


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=20), st.floats(0.0, 1.0))
def test_phases_a_whole_number_of_strides_apart_agree(strides: list[int], phase: float) -> None:
    assert concentration(np.array(strides) + phase) == pytest.approx(1.0)


def test_phases_spread_evenly_over_the_stride_have_no_concentration() -> None:
    assert concentration(np.arange(8) / 8.0) == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(concentration(np.empty(0)))
