from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.body.facing import facing
from motionsplice.precompute.body.turned_points import turned_points


def slow_twin(positions: Floats) -> Floats:
    turns = quaternion.about([0.0, 1.0, 0.0], -heading(positions[:, 3] - positions[:, 4]))
    return turned_points(turns, positions[:, :3] - positions[:, :1] * np.array([1.0, 0.0, 1.0]))


@given(st.integers(0, 2**32 - 1), st.integers(1, 9))
def test_clouds_are_those_of_the_slow_twin(seed: int, frames: int) -> None:
    positions = np.random.default_rng(seed).normal(size=(frames, 5, 3))
    np.testing.assert_allclose(facing(positions), slow_twin(positions), rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(facing(np.asfortranarray(positions)), facing(positions))


@given(st.floats(-3.0, 3.0), st.integers(0, 2**32 - 1))
def test_place_and_heading_do_not_matter(turn: float, seed: int) -> None:
    positions = np.random.default_rng(seed).normal(size=(4, 5, 3))
    moved = quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], turn), positions) + np.array([3.0, 0.0, -2.0])
    np.testing.assert_allclose(facing(moved), facing(positions), atol=1e-12)
    hips = positions[:, 3] - positions[:, 4]
    np.testing.assert_allclose(facing(positions)[:, 0, [0, 2]], 0.0)
    assert np.all(heading(quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], -heading(hips)), hips)) < 1e-12)
