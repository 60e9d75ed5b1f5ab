from __future__ import annotations

import numpy as np
import pytest

from motion import quaternion
from motion.clip import Clip
from motion.errors import SettingsError
from motion.kinematics import end_positions, joint_positions, world_transforms
from motion.procedural.body import ANKLE_HEIGHT, HEEL, SKELETON
from motion.procedural.library import ACTIONS, LOCOMOTIONS, make, sample_clips
from motion.quaternion import Floats

RATE = 100.0
PAIRS = [(locomotion, action) for locomotion in LOCOMOTIONS for action in (None, *ACTIONS)]
SEEDS = (0, 1, 2)
SIDES = ("Left", "Right")
FLAT = tuple(name for name in LOCOMOTIONS if name != "stairs_up")
ONWARD = tuple(name for name in LOCOMOTIONS if name not in ("turn_180", "side_step"))
STEADY = ("walk", "slow_walk", "run", "side_step")


def at(clip: Clip, name: str) -> Floats:
    return joint_positions(clip)[:, SKELETON.index(name)]


def bend(clip: Clip, upper: str, middle: str, lower: str) -> Floats:
    """Degrees [F] by which a limb is off straight."""
    first = at(clip, middle) - at(clip, upper)
    second = at(clip, lower) - at(clip, middle)
    cosine = np.sum(first * second, axis=-1) / np.linalg.norm(first, axis=-1) / np.linalg.norm(second, axis=-1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def knee(clip: Clip, side: str) -> Floats:
    return bend(clip, side + "UpLeg", side + "Leg", side + "Foot")


def heading(clip: Clip) -> Floats:
    """Unit vectors [F, 3] over the floor: where the pelvis faces."""
    facing = quaternion.rotate(clip.rotations[:, 0], [0.0, 0.0, 1.0]) * [1.0, 0.0, 1.0]
    return np.asarray(facing / np.linalg.norm(facing, axis=-1, keepdims=True))


def ahead(clip: Clip, name: str, of: str = "Hips") -> Floats:
    """Metres [F] by which one joint is ahead of another, as the pelvis faces."""
    return np.asarray(np.sum((at(clip, name) - at(clip, of)) * heading(clip), axis=-1))


def soles(clip: Clip, side: str) -> tuple[Floats, Floats, Floats]:
    """World positions [F, 3] of heel, ball and the tip of the toes."""
    positions, world = world_transforms(SKELETON, clip.root_positions, clip.rotations)
    foot, toe = SKELETON.index(side + "Foot"), SKELETON.index(side + "ToeBase")
    heel = positions[:, foot] + quaternion.rotate(world[:, foot], [0.0, HEEL[1], HEEL[0]])
    tips = end_positions(SKELETON, positions, world)
    return heel, positions[:, toe], tips[:, SKELETON.end_parents.tolist().index(toe)]


def lean(clip: Clip) -> float:
    """Mean forward lean of the trunk in degrees."""
    return float(
        np.degrees(np.arctan2(ahead(clip, "Neck", "Spine"), (at(clip, "Neck") - at(clip, "Spine"))[:, 1])).mean()
    )


def period(curve: Floats) -> int:
    """The frames after which a curve repeats best, among 0.5 to 1.7 seconds."""
    lags = range(int(0.5 * RATE), int(1.7 * RATE))
    return min(lags, key=lambda lag: float(np.mean((curve[lag:] - curve[:-lag]) ** 2)))


def test_the_body_has_human_proportions() -> None:
    bind = np.tile(quaternion.IDENTITY, (1, SKELETON.joint_count, 1))
    positions, world = world_transforms(SKELETON, np.zeros((1, 3)), bind)
    points = np.concatenate([positions[0], end_positions(SKELETON, positions, world)[0]])
    stature = np.ptp(points[:, 1])
    assert 21 <= SKELETON.joint_count <= 31
    assert 1.7 < stature < 1.85
    assert 0.95 < np.ptp(points[:, 0]) / stature < 1.12  # arm span
    assert 0.48 < (points[SKELETON.index("LeftUpLeg"), 1] - points[:, 1].min()) / stature < 0.54


def test_names_are_listed_and_unknown_ones_refused_with_near_ones() -> None:
    assert {"walk", "slow_walk", "curve", "run", "stairs_up", "side_step", "turn_180"} == set(LOCOMOTIONS)
    assert {"carry_box", "carry_cup", "punch", "push", "wave"} == set(ACTIONS)
    with pytest.raises(SettingsError, match="Did you mean 'walk'"):
        make("wlak")
    with pytest.raises(SettingsError, match="carry_box"):
        make("walk", "carry_bx")
    with pytest.raises(SettingsError, match="seconds"):
        make("walk", seconds=float("nan"))
    with pytest.raises(SettingsError, match="frames per second"):
        make("walk", rate=0.0)


def test_sample_clips_are_every_locomotion_and_every_action() -> None:
    clips = sample_clips()
    assert set(clips) == {*LOCOMOTIONS, *ACTIONS}
    assert all(clip.skeleton is SKELETON for clip in clips.values())


@pytest.mark.parametrize(("locomotion", "action"), PAIRS)
def test_every_pair_is_smooth_and_its_lower_body_is_the_locomotions(locomotion: str, action: str | None) -> None:
    clip = make(locomotion, action, seconds=4.0, seed=5)
    plain = make(locomotion, seconds=4.0, seed=5)
    lower = [joint for joint in range(SKELETON.joint_count) if "Leg" in SKELETON.names[joint] or joint == 0]
    lower += [SKELETON.index(side + name) for side in SIDES for name in ("Foot", "ToeBase")]
    np.testing.assert_array_equal(clip.root_positions, plain.root_positions)
    np.testing.assert_array_equal(clip.rotations[:, lower], plain.rotations[:, lower])
    acceleration = np.linalg.norm(np.diff(joint_positions(clip), 2, axis=0), axis=-1) * clip.rate**2
    assert acceleration.max() < (250.0 if locomotion == "run" else 90.0)
    if action is not None:
        assert np.abs(clip.rotations - plain.rotations).max() > 0.05


def test_the_same_seed_is_the_same_motion_and_another_is_another() -> None:
    one, same, other = (make("walk", "wave", seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.rotations, same.rotations)
    assert np.abs(one.rotations - other.rotations).max() > 0.05
    periods = {period(knee(make("walk", rate=RATE, seed=seed), "Left")) for seed in range(6)}
    assert len(periods) > 3
    assert max(periods) / min(periods) < 1.18


def test_the_rate_samples_one_motion() -> None:
    fine, coarse = make("turn_180", "punch", rate=120.0), make("turn_180", "punch", rate=30.0)
    np.testing.assert_allclose(joint_positions(fine)[::4], joint_positions(coarse), atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("locomotion", FLAT)
def test_standing_feet_neither_slide_nor_sink(locomotion: str, seed: int) -> None:
    clip = make(locomotion, rate=RATE, seed=seed)
    for side in SIDES:
        heel, ball, tip = soles(clip, side)
        for point, floor in ((heel, 0.0), (tip, 0.0), (ball, 0.02)):
            assert point[:, 1].min() > floor - 0.01
        flat = (heel[:-1, 1] < 0.001) & (ball[:-1, 1] < 0.0245)
        rolling = (heel[:-1, 1] < 0.05) & (np.abs(ball[:-1, 1] - 0.024) < 0.0005)
        assert flat.mean() > 0.06
        assert rolling.mean() > 1.3 * flat.mean()
        for point, standing in ((heel, flat), (ball, rolling)):
            speed = np.linalg.norm(np.diff(point, axis=0)[:, [0, 2]], axis=-1) * RATE
            assert speed[standing].max() < 0.05


@pytest.mark.parametrize("seed", SEEDS)
def test_feet_stand_on_stairs_of_one_rise_and_tread_and_clear_their_edges(seed: int) -> None:
    clip = make("stairs_up", rate=RATE, seed=seed, seconds=8.0)
    placed = []
    for side in SIDES:
        foot = at(clip, side + "Foot")
        still = np.linalg.norm(np.diff(foot, axis=0), axis=-1) * RATE < 0.02
        for run in np.split(np.flatnonzero(still), np.flatnonzero(np.diff(np.flatnonzero(still)) > 1) + 1):
            if len(run) > 10:
                placed.append(foot[run[len(run) // 2]])
    stairs = np.array(sorted(placed, key=lambda place: float(place[1])))
    np.testing.assert_allclose(np.diff(stairs[:, 1]), 0.17, atol=1e-6)
    np.testing.assert_allclose(np.diff(stairs[:, 2]), 0.29, atol=1e-6)
    assert stairs[0, 1] > ANKLE_HEIGHT - 1e-6
    edges, tops = stairs[:, 2] + HEEL[0] - 0.01, stairs[:, 1] - ANKLE_HEIGHT
    for side in SIDES:
        for point in soles(clip, side):
            passed = np.searchsorted(edges, point[:, 2]) - 1
            inside = passed >= 0
            assert (point[inside, 1] - tops[passed[inside]]).min() > -0.001


@pytest.mark.parametrize("seed", SEEDS)
def test_walking_follows_the_norms(seed: int) -> None:
    clip = make("walk", rate=RATE, seed=seed)
    for side in SIDES:
        bent = knee(clip, side)
        assert 55.0 < bent.max() < 67.0
        assert 3.0 < bent.min() < 12.0
        loading = bent[:-1][at(clip, side + "ToeBase")[:-1, 1] < 0.0245]
        assert 15.0 < np.median(np.sort(loading)[-len(loading) // 4 :]) < 40.0
        thigh = at(clip, side + "Leg") - at(clip, side + "UpLeg")
        hip = np.degrees(np.arctan2(np.sum(thigh * heading(clip), axis=-1), -thigh[:, 1]))
        assert 34.0 < np.ptp(hip) < 47.0
    height = clip.root_positions[:, 1]
    assert 0.02 < np.ptp(height) < 0.06
    step = round(period(knee(clip, "Left")) / 2)
    assert np.corrcoef(height[step:], height[:-step])[0, 1] > 0.95  # twice a stride


@pytest.mark.parametrize("seed", SEEDS)
def test_running_follows_the_norms_and_flies(seed: int) -> None:
    clip = make("run", rate=RATE, seed=seed)
    lowest = np.stack([np.stack(soles(clip, side))[..., 1].min(axis=0) for side in SIDES])
    assert 0.1 < np.mean(lowest.min(axis=0) > 0.03) < 0.5
    assert all(90.0 < knee(clip, side).max() < 110.0 for side in SIDES)
    assert bend(clip, "LeftArm", "LeftForeArm", "LeftHand").min() > 60.0
    assert 6.0 < lean(clip) < 12.0


@pytest.mark.parametrize("locomotion", LOCOMOTIONS)
def test_knees_and_elbows_bend_one_way_and_without_pops(locomotion: str) -> None:
    clip = make(locomotion, rate=60.0, seed=1)
    for side in SIDES:
        assert (ahead(clip, side + "Leg", side + "UpLeg") - 0.49 * ahead(clip, side + "Foot", side + "UpLeg")).min() > 0
        hand, arm = ahead(clip, side + "Hand", side + "Arm"), ahead(clip, side + "ForeArm", side + "Arm")
        if locomotion != "turn_180":  # there the shoulders turn before the pelvis, which is what `ahead` goes by
            assert (0.56 * hand - arm).min() > 0.0
        bent = knee(clip, side)
        assert np.abs(np.diff(bent, 2)).max() * 60.0**2 < (60000.0 if locomotion == "run" else 30000.0)
        assert bent.min() > 5.0


@pytest.mark.parametrize("locomotion", STEADY)
def test_left_and_right_are_half_a_cycle_apart(locomotion: str) -> None:
    clip = make(locomotion, rate=RATE, seconds=8.0, seed=2)
    left, right = at(clip, "LeftFoot")[:, 1], at(clip, "RightFoot")[:, 1]
    stride = period(left)
    half = round(stride / 2)
    mirrored = np.abs(left[half:] - right[:-half]).mean()
    assert mirrored < 0.25 * np.abs(left - right).mean()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("locomotion", ONWARD)
def test_arms_swing_against_the_legs_and_shoulders_against_the_pelvis(locomotion: str, seed: int) -> None:
    clip = make(locomotion, rate=RATE, seed=seed)
    hands = ahead(clip, "LeftHand", "RightHand")
    feet = ahead(clip, "LeftFoot", "RightFoot")
    assert np.corrcoef(hands, feet)[0, 1] < -0.7
    shoulders = ahead(clip, "LeftArm", "RightArm")
    assert np.corrcoef(shoulders - shoulders.mean(), feet)[0, 1] < -0.7


def test_a_curve_leans_inwards_and_turns_left() -> None:
    clip = make("curve", seed=1)
    left = np.stack([heading(clip)[:, 2], np.zeros(clip.frame_count), -heading(clip)[:, 0]], axis=-1)
    inward = np.sum((at(clip, "Neck") - at(clip, "Hips")) * left, axis=-1)
    assert inward.mean() > 0.015
    turned = np.unwrap(np.arctan2(heading(clip)[:, 0], heading(clip)[:, 2]))
    assert turned[-1] - turned[0] > np.radians(90.0)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_about_turn_leads_back_and_begins_with_the_head(seed: int) -> None:
    clip = make("turn_180", rate=RATE, seed=seed)
    world = world_transforms(SKELETON, clip.root_positions, clip.rotations)[1]
    half = []
    for name in ("Head", "Spine2", "Hips"):
        facing = quaternion.rotate(world[:, SKELETON.index(name)], [0.0, 0.0, 1.0])
        yaw = np.unwrap(np.arctan2(facing[:, 0], facing[:, 2]))
        assert yaw[-1] - yaw[0] == pytest.approx(np.pi, abs=0.35)
        half.append(int(np.argmax(yaw > np.pi / 2)))
    assert half[0] < half[1] < half[2]
    ways = clip.root_positions[[0, clip.frame_count // 2, -1], 2]
    assert ways[1] > ways[0] + 1.0
    assert ways[2] < ways[1] - 1.0
    assert np.linalg.norm(np.diff(clip.root_positions, axis=0), axis=-1).max() * RATE < 2.2


def test_side_steps_go_left_and_never_cross() -> None:
    clip = make("side_step", seed=1)
    assert (at(clip, "LeftFoot") - at(clip, "RightFoot"))[:, 0].min() > 0.08
    assert clip.root_positions[-1, 0] > clip.root_positions[0, 0] + 1.5
    assert np.ptp(clip.root_positions[:, 2]) < 0.05


@pytest.mark.parametrize("locomotion", LOCOMOTIONS)
def test_a_box_is_held_level_between_both_hands_and_leant_back_for(locomotion: str) -> None:
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
def test_punches_alternate_one_to_a_step(locomotion: str) -> None:
    clip = make(locomotion, "punch", rate=RATE, seed=1)
    reach = np.stack([ahead(clip, side + "Hand", "Spine") for side in SIDES])
    stride = period(at(clip, "LeftFoot")[:, 1] - clip.root_positions[:, 1])
    lead = reach[0] - reach[1]
    assert period(lead) == pytest.approx(stride, abs=2)
    assert reach.max(axis=1).min() > 0.5
    assert np.minimum(*reach).max() < 0.45  # never both arms out


def test_pushing_leans_forward_with_both_arms_out() -> None:
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
