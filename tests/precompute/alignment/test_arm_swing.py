from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.arm_swing import WEIGHT, arm_joints, arm_swing, swing_distances
from motionsplice.precompute.alignment.baseline import find_baseline

WALK = make("walk", seconds=8.0)
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
CELLS = 33


def swings(clip: Clip) -> np.ndarray:
    return arm_swing(joint_positions(clip)[:, list(arm_joints(ROLES))])


def test_arms_swing_against_each_other_wherever_the_walker_faces() -> None:
    swing = swings(WALK)
    assert np.corrcoef(swing.T)[0, 1] < -0.9
    assert np.ptp(swing, axis=0).min() > 0.2
    about = quaternion.about([0.0, 1.0, 0.0], 2.0)
    turned = WALK.rotations.copy()
    turned[:, 0] = quaternion.multiply(about, turned[:, 0])
    positions = quaternion.rotate(about, WALK.root_positions)
    np.testing.assert_allclose(swings(replace(WALK, root_positions=positions, rotations=turned)), swing, atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(1, 9))
def test_the_swing_is_that_of_the_slow_twin(seed: int, frames: int) -> None:
    positions = np.random.default_rng(seed).normal(size=(frames, 6, 3))
    ahead = np.cross(positions[:, 0] - positions[:, 1], [0.0, 1.0, 0.0])
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    wanted = np.sum((positions[:, 4:] - positions[:, 2:4]) * ahead[:, None], axis=2)
    np.testing.assert_allclose(arm_swing(positions), wanted, rtol=0.0, atol=1e-13)


@given(st.integers(0, 2**32 - 1), st.floats(1.5, 6.0), st.floats(0.1, 0.4))
def test_an_arm_in_time_is_nearest_where_it_is_and_an_arm_out_of_time_counts_little(
    seed: int, cycles: float, size: float
) -> None:
    draw = np.random.default_rng(seed)
    phase = np.linspace(0.0, cycles, 200) + draw.uniform()
    swing = size * np.stack([np.cos(2.0 * np.pi * phase), -np.cos(2.0 * np.pi * phase)], axis=1)
    found = swing_distances(swing, phase, CELLS, 0.9)
    here = np.round(phase * CELLS).astype(int) % CELLS
    assert found[np.arange(200), here].max() < 0.05 * found.max()
    noise = swing_distances(size * draw.normal(size=(200, 2)), phase, CELLS, 0.9)
    assert noise.mean() < 0.1 * found.mean()


def test_arms_of_less_than_a_stride_and_still_arms_say_nothing() -> None:
    phase = np.linspace(0.0, 0.9, 60)
    wave = np.tile(np.cos(2.0 * np.pi * phase)[:, None], 2)
    assert not swing_distances(wave, phase, CELLS, 0.9).any()
    still = swing_distances(1e-4 * wave, 3.0 * phase, CELLS, 0.9)
    assert still.max() < 1e-3 * (WEIGHT * 0.9) ** 2


@pytest.mark.parametrize("late", [0.06, -0.06])
def test_a_stride_whose_arms_are_late_has_a_later_phase_than_its_legs(late: float) -> None:
    """The arms lag by `late` seconds in the middle of the clip only."""
    frames = np.arange(WALK.frame_count)
    lag = late * WALK.rate * np.exp(-(((frames - 240) / 40.0) ** 2))
    upper = WALK.skeleton.subtree(ROLES.pelvis)
    rotations = WALK.rotations.copy()
    rotations[:, upper] = WALK.sampled(frames - lag)[1][:, upper]
    plain, moved = (align(clip, ROLES, RING).phase for clip in (WALK, replace(WALK, rotations=rotations)))
    change = (moved - plain)[[60, 240, 420]]
    assert abs(change[1] - 0.5 * (change[0] + change[2])) > 0.01
    assert np.sign(change[1] - 0.5 * (change[0] + change[2])) == -np.sign(late)
