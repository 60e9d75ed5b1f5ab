from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.kinematics import end_positions, joint_positions, world_transforms
from motionsplice.motion.procedural.body import SKELETON
from motionsplice.motion.procedural.library import ACTIONS, LOCOMOTIONS, make, sample_clips, truth
from tests.gauges import RATE, SIDES, ahead, at, bend, knee, lean, period

PAIRS = [(locomotion, action) for locomotion in LOCOMOTIONS for action in (None, *ACTIONS)]
RUNNING = ("run", "walk_to_run")


def test_the_body_has_human_proportions() -> None:
    bind = np.tile(quaternion.IDENTITY, (1, SKELETON.joint_count, 1))
    positions, world = world_transforms(SKELETON, np.zeros((1, 3)), bind)
    points = np.concatenate([positions[0], end_positions(SKELETON, positions, world)[0]])
    stature = np.ptp(points[:, 1])
    assert 21 <= SKELETON.joint_count <= 31
    assert 1.7 < stature < 1.85
    assert 0.95 < np.ptp(points[:, 0]) / stature < 1.12  # arm span
    assert 0.48 < (points[SKELETON.index("LeftUpLeg"), 1] - points[:, 1].min()) / stature < 0.54


def test_unknown_names_and_impossible_lengths_are_refused() -> None:
    steady = {"walk", "slow_walk", "curve", "run", "stairs_up", "stairs_down", "side_step"}
    assert steady | {"turn_180", "walk_to_run", "step_up"} == set(LOCOMOTIONS)
    assert {"carry_box", "carry_cup", "punch", "push", "wave"} == set(ACTIONS)
    with pytest.raises(SettingsError, match="Did you mean 'walk'"):
        make("wlak")
    with pytest.raises(SettingsError, match="carry_box"):
        make("walk", "carry_bx")
    with pytest.raises(SettingsError, match="seconds"):
        make("walk", seconds=float("nan"))
    with pytest.raises(SettingsError, match="frames per second"):
        make("walk", rate=0.0)


def test_sample_clips_include_every_locomotion_and_action() -> None:
    clips = sample_clips()
    assert set(clips) == {*LOCOMOTIONS, *ACTIONS}
    assert all(clip.skeleton is SKELETON for clip in clips.values())


@pytest.mark.parametrize("locomotion", LOCOMOTIONS)
def test_the_truth_of_every_action_has_the_locomotions_root_motion(locomotion: str) -> None:
    plain = sample_clips()[locomotion]
    for action in ACTIONS:
        real = truth(locomotion, action)
        np.testing.assert_array_equal(real.root_positions, plain.root_positions)
        assert np.abs(real.rotations - plain.rotations).max() > 0.05


@pytest.mark.parametrize(("locomotion", "action"), PAIRS)
def test_every_pair_is_smooth_and_has_the_locomotions_lower_body(locomotion: str, action: str | None) -> None:
    clip = make(locomotion, action, seconds=4.0, seed=5)
    plain = make(locomotion, seconds=4.0, seed=5)
    lower = [joint for joint in range(SKELETON.joint_count) if "Leg" in SKELETON.names[joint] or joint == 0]
    lower += [SKELETON.index(side + name) for side in SIDES for name in ("Foot", "ToeBase")]
    np.testing.assert_array_equal(clip.root_positions, plain.root_positions)
    np.testing.assert_array_equal(clip.rotations[:, lower], plain.rotations[:, lower])
    acceleration = np.linalg.norm(np.diff(joint_positions(clip), 2, axis=0), axis=-1) * clip.rate**2
    assert acceleration.max() < (250.0 if locomotion in RUNNING else 90.0)
    if action is not None:
        assert np.abs(clip.rotations - plain.rotations).max() > 0.05


def test_a_seed_determines_the_motion_and_another_seed_gives_another() -> None:
    one, same, other = (make("walk", "wave", seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.rotations, same.rotations)
    assert np.abs(one.rotations - other.rotations).max() > 0.05
    periods = {period(knee(make("walk", rate=RATE, seed=seed), "Left")) for seed in range(6)}
    assert len(periods) > 3
    assert max(periods) / min(periods) < 1.18


@pytest.mark.parametrize("locomotion", ["turn_180", "walk_to_run", "step_up"])
def test_all_rates_sample_the_same_motion(locomotion: str) -> None:
    fine, coarse = make(locomotion, "punch", rate=120.0), make(locomotion, "punch", rate=30.0)
    np.testing.assert_allclose(joint_positions(fine)[::4], joint_positions(coarse), atol=1e-9)


@pytest.mark.parametrize("locomotion", LOCOMOTIONS)
def test_a_box_is_held_level_between_both_hands_by_a_body_that_leans_back(locomotion: str) -> None:
    clip, plain = make(locomotion, "carry_box", seed=1), make(locomotion, seed=1)
    across = at(clip, "LeftHand") - at(clip, "RightHand")
    assert np.abs(across[:, 1]).max() < 0.06
    assert np.ptp(np.linalg.norm(across, axis=-1)) < 0.01
    assert 8.0 < lean(plain) - lean(clip) < 14.0
    assert all(60.0 < bend(clip, side + "Arm", side + "ForeArm", side + "Hand").mean() < 110.0 for side in SIDES)


def test_a_cup_is_carried_on_a_level_forearm_while_the_other_arm_swings() -> None:
    clip, plain = make("walk", "carry_cup", seed=1), make("walk", seed=1)
    forearm = at(clip, "RightHand") - at(clip, "RightForeArm")
    assert np.degrees(np.abs(np.arcsin(forearm[:, 1] / np.linalg.norm(forearm, axis=-1)))).max() < 12.0
    assert np.ptp(ahead(clip, "RightHand")) < 0.3 * np.ptp(ahead(clip, "LeftHand"))
    assert np.ptp(ahead(clip, "LeftHand")) > 0.85 * np.ptp(ahead(plain, "LeftHand"))


@pytest.mark.parametrize("locomotion", ["walk", "run", "stairs_up"])
def test_punches_alternate_once_per_step(locomotion: str) -> None:
    clip = make(locomotion, "punch", rate=RATE, seed=1)
    reach = np.stack([ahead(clip, side + "Hand", "Spine") for side in SIDES])
    stride = period(at(clip, "LeftFoot")[:, 1] - clip.root_positions[:, 1])
    lead = reach[0] - reach[1]
    assert period(lead) == pytest.approx(stride, abs=2)
    assert reach.max(axis=1).min() > 0.5
    assert np.minimum(*reach).max() < 0.45  # never both arms extended


def test_pushing_leans_forward_with_both_arms_extended() -> None:
    clip = make("walk", "push", seed=1)
    assert 11.0 < lean(clip) < 19.0
    assert all(ahead(clip, side + "Hand", "Spine2").min() > 0.35 for side in SIDES)


def test_a_wave_has_a_rhythm_of_its_own() -> None:
    clip = make("walk", "wave", rate=RATE, seed=1, seconds=20.0)
    assert (at(clip, "RightHand") - at(clip, "RightArm"))[:, 1].min() > 0.0
    spread = at(clip, "RightHand") - at(clip, "RightForeArm")
    beats = np.abs(np.fft.rfft(spread[:, 0] - spread[:, 0].mean()))
    waved = float(np.fft.rfftfreq(clip.frame_count, 1.0 / RATE)[beats.argmax()])
    assert 1.3 < waved < 2.1
    steps = waved * period(knee(clip, "Left")) / RATE
    assert abs(steps - round(steps)) > 0.05


@pytest.mark.parametrize(("locomotion", "action"), PAIRS)
def test_hands_stay_out_of_the_trunk(locomotion: str, action: str | None) -> None:
    clip = make(locomotion, action, seed=2)
    positions, world = world_transforms(SKELETON, clip.root_positions, clip.rotations)
    chest = SKELETON.index("Spine2")
    for side in SIDES:
        for name in ("ForeArm", "Hand"):
            apart = positions[:, SKELETON.index(side + name)] - positions[:, chest]
            local = quaternion.rotate(quaternion.conjugate(world[:, chest]), apart)
            beside = np.hypot(local[:, 0] / 0.15, local[:, 2] / 0.11)
            above = local[:, 1] > 0.2
            assert np.all(above | (beside > 1.0)), (side, name)
