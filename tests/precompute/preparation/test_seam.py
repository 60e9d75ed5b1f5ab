from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.quality.measures import accelerations
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.precompute.preparation.seam import SURE, WIDEST_TURN, Seamed, _gaps, add_seam, rough_gaps
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.conftest import CLIPS

ROLES = find_roles(CLIPS["walk"].skeleton)
RING = find_baseline(CLIPS["walk"], ROLES)
LOOPED = ("walk", "run", "carry_box", "wave", "side_step")


def seamed(clip: Clip, phase: Floats | None = None) -> Seamed:
    phase = align(clip, ROLES, RING).phase if phase is None else phase
    return add_seam(clip, phase, ROLES, foot_contacts(clip, ROLES))


@pytest.mark.parametrize("name", LOOPED)
def test_a_seam_leaves_the_clips_own_frames_unchanged(name: str) -> None:
    clip, result = CLIPS[name], seamed(CLIPS[name])
    assert result.strides >= 1
    np.testing.assert_array_equal(result.clip.root_positions[: clip.frame_count], clip.root_positions)
    assert quaternion.angle(result.clip.rotations[: clip.frame_count], clip.rotations).max() < 1e-7
    assert np.diff(result.phase).min() > 0.0


def test_a_long_clip_goes_back_by_many_strides_though_its_last_one_fits_best() -> None:
    """From stride to stride one arm sinks a little, so the last stride is the nearest."""
    clip = make("walk", seconds=10.0)
    sinking = quaternion.about([0.0, 0.0, 1.0], np.linspace(0.0, 0.5, clip.frame_count))
    rotations = clip.rotations.copy()
    rotations[:, ROLES.left_elbow] = quaternion.multiply(rotations[:, ROLES.left_elbow], sinking)
    assert seamed(replace(clip, rotations=rotations)).strides >= 6


@pytest.mark.parametrize("name", LOOPED)
def test_a_seam_ends_at_the_pose_of_whole_strides_before(name: str) -> None:
    clip, result = CLIPS[name], seamed(CLIPS[name])
    at = np.interp(result.phase[-1] - result.strides, result.phase, np.arange(len(result.phase)))
    there = clip.sampled([at])[1][0]
    assert quaternion.angle(result.clip.rotations[-1, 1:], there[1:]).max() < 1e-6


@pytest.mark.parametrize("name", LOOPED)
def test_nothing_jumps_at_a_seam(name: str) -> None:
    clip, result = CLIPS[name], seamed(CLIPS[name])
    own = np.percentile(accelerations(clip), 99)
    assert accelerations(result.clip)[len(accelerations(clip)) - 1 :].max() < 1.3 * own


def test_a_seam_goes_on_at_the_pace_of_the_last_frames_not_of_a_noisy_one() -> None:
    """By the last two frames alone, the arm would swing out by 0.18 radians."""
    clip, noise = CLIPS["walk"], 0.05
    rotations = clip.rotations.copy()
    disturbed = quaternion.about([1.0, 0.0, 0.0], noise)
    rotations[-1, ROLES.left_shoulder] = quaternion.multiply(rotations[-1, ROLES.left_shoulder], disturbed)
    phase = align(clip, ROLES, RING).phase
    smooth, noisy = (seamed(one, phase).clip for one in (clip, replace(clip, rotations=rotations)))
    apart = quaternion.angle(smooth.rotations[clip.frame_count :], noisy.rotations[clip.frame_count :])
    assert apart.max() < 2.0 * noise


def test_a_seam_finds_the_nearest_pose_although_the_phase_is_a_little_off() -> None:
    clip, strayed = CLIPS["walk"], 0.02
    phase = align(clip, ROLES, RING).phase
    off = phase + strayed * (phase - phase[0]) / (phase[-1] - phase[0])  # the end is said to be later than it is
    true, found = (seamed(clip, one) for one in (phase, off))
    assert true.strides == found.strides
    assert quaternion.angle(true.clip.rotations, found.clip.rotations).max() < 0.02
    assert np.diff(found.phase).min() > 0.0


def test_root_motion_continues_around_a_curve() -> None:
    curve = make("curve", seed=3, seconds=5.0)
    result = seamed(curve)
    steps = np.linalg.norm(np.diff(result.clip.root_positions[:, [0, 2]], axis=0), axis=1)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(*np.diff(result.clip.root_positions[:, [0, 2]], axis=0).T))))
    after = slice(curve.frame_count - 1, None)
    assert steps[after].min() > 0.8 * steps.min()
    assert steps[after].max() < 1.2 * steps.max()
    assert turns[curve.frame_count - 2 :].max() < 1.5 * turns[: curve.frame_count - 2].max()


def test_a_clip_shorter_than_a_stride_has_no_seam() -> None:
    result = seamed(CLIPS["walk"].frames(0, 40))
    assert (result.strides, result.clip.frame_count) == (0, 40)


def test_a_clip_with_unlike_strides_has_no_seam() -> None:
    clip = CLIPS["walk"]
    bent = clip.rotations.copy()
    turn = quaternion.about([0.0, 0.0, 1.0], np.linspace(0.0, 6.0, clip.frame_count))
    bent[:, 1:] = quaternion.multiply(bent[:, 1:], turn[:, None])
    assert seamed(replace(clip, rotations=bent), align(clip, ROLES, RING).phase).strides == 0


def test_one_arm_in_another_place_prevents_a_seam() -> None:
    clip = CLIPS["walk"]
    raised = clip.rotations.copy()
    turn = quaternion.about([0.0, 0.0, 1.0], 2.0 * (np.arange(clip.frame_count) > clip.frame_count - 25))
    raised[:, ROLES.left_shoulder] = quaternion.multiply(raised[:, ROLES.left_shoulder], turn)
    assert seamed(clip).strides > 0
    assert seamed(replace(clip, rotations=raised), align(clip, ROLES, RING).phase).strides == 0


def test_an_action_continues_past_its_end_without_a_jump(bank: Bank) -> None:
    assert bank.clip("wave").duration < 0.6 * bank.clip("walk").duration
    splice = Evaluator(bank).clip(Splice("walk", "wave"))
    own = max(np.percentile(accelerations(bank.motion(name)), 99) for name in ("walk", "wave"))
    assert accelerations(splice).max() < 2.0 * own


@pytest.mark.parametrize("name", LOOPED)
def test_rough_gaps_are_those_of_the_slow_twin(name: str) -> None:
    clip = CLIPS[name]
    frames = np.random.default_rng(1).uniform(0.0, clip.frame_count - 1.0, 60)
    gaps, widest = rough_gaps(clip.rotations, frames)
    turns = quaternion.angle(clip.sampled(frames)[1][:, 1:], clip.rotations[-1, 1:])
    np.testing.assert_allclose(widest, turns.max(axis=1), atol=0.1 * SURE)
    wanted = _gaps(clip, frames)
    np.testing.assert_array_equal(np.isinf(wanted), widest > WIDEST_TURN)
    assert np.isfinite(wanted).any()
    np.testing.assert_allclose(gaps[np.isfinite(wanted)], wanted[np.isfinite(wanted)], atol=0.1 * SURE)
