from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.body import ANKLE_HEIGHT, BALL, HEEL, SKELETON
from motionsplice.motion.procedural.library import LOCOMOTIONS, make
from motionsplice.motion.procedural.tempo import Change, Tempo
from tests.gauges import (
    RATE,
    SIDES,
    ahead,
    at,
    bend,
    footholds,
    heading,
    knee,
    lean,
    leans,
    part,
    period,
    resting,
    soles,
    speed,
)

SEEDS = (0, 1, 2)
FLAT = tuple(name for name in LOCOMOTIONS if name not in ("stairs_up", "stairs_down", "step_up"))
ONWARD = tuple(name for name in LOCOMOTIONS if name not in ("turn_180", "side_step"))
STEADY = ("walk", "slow_walk", "run", "side_step")
RUNNING = ("run", "walk_to_run")


def test_a_changing_tempo_is_continuous_and_phase_and_time_are_inverse() -> None:
    tempo = Tempo(start=0.3, period=1.1, other=0.7, change=Change(begin=2.0, lasting=1.5, back=6.0))
    time = np.linspace(0.0, 12.0, 1201)
    phase = tempo.phase(time)
    np.testing.assert_allclose(tempo.time(phase), time, atol=1e-12)
    assert phase[0] == pytest.approx(0.3)
    rate = np.diff(phase) / np.diff(time)
    assert np.all((rate > 1.0 / 1.1 - 1e-9) & (rate < 1.0 / 0.7 + 1e-9))
    assert np.abs(np.diff(rate)).max() < 0.01
    assert rate[[0, 450, -1]] == pytest.approx([1.0 / 1.1, 1.0 / 0.7, 1.0 / 1.1])


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
@pytest.mark.parametrize(("locomotion", "climb"), [("stairs_up", 1), ("stairs_down", -1)])
def test_feet_stand_on_even_stairs_and_clear_their_edges(locomotion: str, climb: int, seed: int) -> None:
    clip = make(locomotion, rate=RATE, seed=seed, seconds=8.0)
    stairs = footholds(clip)
    np.testing.assert_allclose(np.diff(stairs[:, 1]), climb * 0.17, atol=1e-6)
    np.testing.assert_allclose(np.diff(stairs[:, 2]), 0.29, atol=1e-6)
    assert stairs[:, 1].min() > ANKLE_HEIGHT - 1e-6
    tops = stairs[:, 1] - ANKLE_HEIGHT
    # Upstairs the whole foot is on the stair; downstairs only up to the ball, with the toes over the edge.
    edges = stairs[:, 2] + (HEEL[0] - 0.01 if climb > 0 else BALL[0] + 0.025)
    for side in SIDES:
        for point in soles(clip, side):
            stair = np.searchsorted(edges, point[:, 2]) - (climb > 0)
            inside = (stair >= 0) & (stair < len(tops)) & (point[:, 2] > stairs[0, 2])
            assert (point[inside, 1] - tops[stair[inside]]).min() > -0.001
        assert resting(clip, side) > 0.45


@pytest.mark.parametrize("seed", SEEDS)
def test_a_walk_follows_the_norms(seed: int) -> None:
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
def test_a_run_follows_the_norms_and_has_a_flight_phase(seed: int) -> None:
    clip = make("run", rate=RATE, seed=seed)
    lowest = np.stack([np.stack(soles(clip, side))[..., 1].min(axis=0) for side in SIDES])
    assert 0.1 < np.mean(lowest.min(axis=0) > 0.03) < 0.5
    assert all(90.0 < knee(clip, side).max() < 110.0 for side in SIDES)
    assert bend(clip, "LeftArm", "LeftForeArm", "LeftHand").min() > 60.0
    assert 6.0 < lean(clip) < 12.0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_walk_becomes_a_run(seed: int) -> None:
    clip = make("walk_to_run", rate=RATE, seed=seed, seconds=8.0)
    walking, running = part(clip, 0.0, 3.0), part(clip, 5.2, 8.0)
    assert 1.0 < speed(walking) < 1.45
    assert 2.5 < speed(running) < 3.4
    assert 0.92 < period(knee(walking, "Left")) / RATE < 1.2
    assert 0.65 < period(knee(running, "Left")) / RATE < 0.82
    assert 55.0 < knee(walking, "Left").max() < 67.0
    assert 90.0 < knee(running, "Left").max() < 110.0
    aloft = [
        np.mean(np.min([point[:, 1] for side in SIDES for point in soles(piece, side)], axis=0) > 0.03)
        for piece in (walking, running)
    ]
    assert aloft[0] == 0.0
    assert 0.1 < aloft[1] < 0.5
    assert lean(running) > lean(walking) + 4.0
    twists = [np.ptp(ahead(piece, "LeftArm", "RightArm")) for piece in (walking, running)]
    assert twists[1] > 1.6 * twists[0]
    elbows = [bend(piece, "LeftArm", "LeftForeArm", "LeftHand") for piece in (walking, running)]
    assert elbows[1].min() > elbows[0].max() + 15.0
    pace = np.diff(clip.root_positions[:, 2]) * RATE
    over_strides = np.convolve(pace, np.full(100, 0.01), "valid")
    assert np.diff(over_strides[::20]).min() > -0.15  # it never slows down


@pytest.mark.parametrize("seed", range(6))
def test_both_feet_clear_a_step_and_the_body_leans_into_it(seed: int) -> None:
    clip = make("step_up", rate=RATE, seed=seed)
    placed = footholds(clip)
    lead = int(np.argmax(placed[:, 1] > ANKLE_HEIGHT + 0.1))
    np.testing.assert_allclose(placed[:lead, 1], ANKLE_HEIGHT, atol=1e-6)
    np.testing.assert_allclose(placed[lead:, 1], ANKLE_HEIGHT + 0.26, atol=1e-6)
    assert 2 < lead < len(placed) - 2
    edge = placed[lead, 2] + HEEL[0] - 0.05
    assert edge > placed[lead - 1, 2] + BALL[0] + 0.15
    for side in SIDES:
        for point, sole in zip(soles(clip, side), (0.0, 0.02, 0.0), strict=True):
            ground = np.where(point[:, 2] > edge, 0.26, 0.0) + sole
            assert (point[:, 1] - ground).min() > -0.002
            assert np.interp(edge, point[:, 2], point[:, 1]) > 0.26 + 0.025  # above the edge as it passes
        assert 80.0 < knee(clip, side).max() < 110.0
        assert resting(clip, side) > 0.45
    height = clip.root_positions[:, 1]
    stride = round(period(knee(part(clip, 0.0, 2.5), "Left")))
    assert height[-stride:].mean() - height[:stride].mean() == pytest.approx(0.26, abs=0.005)
    rising = int(np.argmax(height > height[:stride].max() + 0.02))
    assert leans(clip)[:rising].max() > leans(clip)[:stride].mean() + 6.0


@pytest.mark.parametrize("seed", SEEDS)
def test_walking_downstairs_is_upright_on_the_forefoot_with_bent_knees(seed: int) -> None:
    clip = make("stairs_down", rate=RATE, seed=seed)
    assert -4.0 < lean(clip) < 1.0
    for side in SIDES:
        bent = knee(clip, side)
        assert 85.0 < bent.max() < 100.0
        heel, ball, tip = soles(clip, side)
        arriving = np.flatnonzero((np.diff(ball[:, 1])[:-1] < -0.001) & (np.diff(ball[:, 1])[1:] >= -0.001))
        assert len(arriving) > 3
        assert np.all(heel[arriving, 1] > ball[arriving, 1] - 0.024 + 0.01)  # the ball lands before the heel
        assert np.all(tip[arriving, 1] > ball[arriving, 1] - 0.018)  # the toes land flat
    assert np.diff(clip.root_positions[:, 1]).max() * RATE < 0.2


@pytest.mark.parametrize("locomotion", LOCOMOTIONS)
def test_knees_and_elbows_bend_one_way_without_pops(locomotion: str) -> None:
    clip = make(locomotion, rate=60.0, seed=1)
    for side in SIDES:
        assert (ahead(clip, side + "Leg", side + "UpLeg") - 0.49 * ahead(clip, side + "Foot", side + "UpLeg")).min() > 0
        hand, arm = ahead(clip, side + "Hand", side + "Arm"), ahead(clip, side + "ForeArm", side + "Arm")
        if locomotion != "turn_180":  # there the shoulders turn before the pelvis, to which `ahead` is relative
            assert (0.56 * hand - arm).min() > 0.0
        bent = knee(clip, side)
        assert np.abs(np.diff(bent, 2)).max() * 60.0**2 < (60000.0 if locomotion in RUNNING else 30000.0)
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
def test_a_turn_of_180_degrees_begins_with_the_head_and_leads_back(seed: int) -> None:
    clip = make("turn_180", rate=RATE, seed=seed)
    world = world_transforms(SKELETON, clip.root_positions, clip.rotations)[1]
    half = []
    for name in ("Head", "Spine2", "Hips"):
        facing = quaternion.rotate(world[:, SKELETON.index(name)], [0.0, 0.0, 1.0])
        yaw = np.unwrap(np.arctan2(facing[:, 0], facing[:, 2]))
        assert yaw[-1] - yaw[0] == pytest.approx(np.pi, abs=0.35)
        half.append(int(np.argmax(yaw > np.pi / 2)))
    assert half[0] < half[1] < half[2]
    places = clip.root_positions[[0, clip.frame_count // 2, -1], 2]
    assert places[1] > places[0] + 1.0
    assert places[2] < places[1] - 1.0
    assert np.linalg.norm(np.diff(clip.root_positions, axis=0), axis=-1).max() * RATE < 2.2


def test_side_steps_go_left_and_never_cross() -> None:
    clip = make("side_step", seed=1)
    assert (at(clip, "LeftFoot") - at(clip, "RightFoot"))[:, 0].min() > 0.08
    assert clip.root_positions[-1, 0] > clip.root_positions[0, 0] + 1.5
    assert np.ptp(clip.root_positions[:, 2]) < 0.05
