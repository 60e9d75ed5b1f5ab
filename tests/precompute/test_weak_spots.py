"""Cases in which alignment could fail: the starting foot, standing still, and different rates in one bank."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.quality.rhythm import arm_lag, lag_error
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import LEAST_SWING, find_baseline
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.conftest import CLIPS

WALK = CLIPS["walk"]
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
CURVE, TRUTH = make("curve", seed=21), make("curve", "wave", seed=21)
WAVE = make("walk", "wave", seed=22, seconds=7.0)


def bank_of(folder: Path, **actions: Clip) -> Bank:
    """Returns a bank of a walk, a curve and actions whose neutral is the walk."""
    (folder / "clips").mkdir()
    for name, clip in {"walk": WALK, "curve": CURVE, **actions}.items():
        (folder / "clips" / f"{name}.bvh").write_bytes(dump_bvh(clip))
    settings = "".join(f'[{name}]\nkind = "action"\nneutral = "walk"\n' for name in actions)
    (folder / "clips" / "clips.toml").write_text(settings)
    build_bank([folder / "clips"], folder / "bank", baseline="walk")
    return Bank.open(folder / "bank")


def test_an_action_may_start_with_either_foot(tmp_path: Path) -> None:
    """Or anywhere in the stride: an action cut at each eighth of a stride is equally near to the truth."""
    stride = round(WAVE.rate * 1.08)
    cuts = {f"wave{eighth}": WAVE.frames(eighth * stride // 8, WAVE.frame_count) for eighth in range(8)}
    bank = bank_of(tmp_path, **cuts)
    evaluator = Evaluator(bank)
    for name in cuts:
        lag = lag_error(evaluator.clip(Splice("curve", name)), TRUTH, bank.phase("curve"), bank.roles)
        assert np.degrees(lag) < 8.0, name


def test_clips_of_different_rates_can_be_spliced(tmp_path: Path) -> None:
    bank = bank_of(tmp_path, slow=WAVE.resampled(30.0), own=WAVE, fast=WAVE.resampled(120.0))
    evaluator = Evaluator(bank)
    results = [joint_positions(evaluator.clip(Splice("curve", name))) for name in ("slow", "own", "fast")]
    for result in results[1:]:
        assert np.median(np.linalg.norm(result - results[0], axis=-1)) < 0.01
    assert np.degrees(lag_error(evaluator.clip(Splice("curve", "slow")), TRUTH, bank.phase("curve"), bank.roles)) < 8.0


@pytest.mark.parametrize("seconds", [0.5, 1.5])
def test_a_walk_is_in_step_again_after_standing_still(seconds: float) -> None:
    half, still = WALK.frame_count // 2, round(seconds * WALK.rate)
    frames = np.concatenate([np.arange(half), np.full(still, half), np.arange(half, WALK.frame_count)])
    stopped = replace(WALK, root_positions=WALK.root_positions[frames], rotations=WALK.rotations[frames])
    apart = align(stopped, ROLES, RING).phase - align(WALK, ROLES, RING).phase[frames]
    walking = np.r_[0 : half - 20, half + still + 20 : len(frames)]
    assert np.abs(apart - np.round(apart))[walking].max() < 0.06


def legs_of(swing: float, sway: float) -> Clip:
    """Returns 3 s in which the legs swing alike, by this angle in radians, while the root sways by this many metres."""
    seconds = np.arange(181) / 60.0
    rotations = np.tile(quaternion.IDENTITY, (len(seconds), WALK.skeleton.joint_count, 1))
    for hip, sign in ((ROLES.left_hip, 1.0), (ROLES.right_hip, -1.0)):
        rotations[:, hip] = quaternion.about([1.0, 0.0, 0.0], sign * swing * np.sin(2.0 * np.pi * seconds))
    root = np.stack([sway * np.sin(1.3 * seconds), 0.9 + 0.0 * seconds, 4.0 * swing * seconds], axis=-1)
    return Clip("legs", WALK.skeleton, 60.0, root, rotations)


def test_a_walk_with_equal_halves_is_locomotion_and_standing_is_not() -> None:
    symmetric = legs_of(0.4, 0.0)
    for ring in (RING, find_baseline(symmetric, ROLES)):
        assert align(symmetric, ROLES, ring).has_gait
        assert align(symmetric, ROLES, ring).swing > 3.0 * LEAST_SWING
        for standing in (legs_of(0.0, 0.0), legs_of(0.0, 0.05), legs_of(0.05, 0.03)):
            assert align(standing, ROLES, ring).swing < LEAST_SWING


def test_arms_keep_in_phase_walking_forward_backward_and_sideways(real_motion: Path) -> None:
    """09_12 walks forward up to 6 s, then backward and sideways; its arms stay in phase with the legs."""
    reading, walk = (read_clip(real_motion / f"{name}.amc") for name in ("09_12", "16_15"))
    clip, roles = reading.clip, reading.roles
    phase = align(clip, roles, find_baseline(walk.clip, walk.roles)).phase
    for first, last in ((0.0, 6.0), (6.0, 8.5), (8.5, 11.0), (11.0, 13.5), (13.5, 15.9)):
        window = slice(round(first * clip.rate), round(last * clip.rate))
        assert abs(arm_lag(clip.frames(window.start, window.stop), phase[window], roles)) < 0.12
