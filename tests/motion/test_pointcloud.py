from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.pointcloud import horn_rotation, planar_distance, planar_distances, planar_lag_distances
from motionsplice.motion.quaternion import Floats
from tests import naive

seeds = st.integers(0, 2**32 - 1)


def clouds(seed: int, count: int, points: int = 4) -> Floats:
    return np.random.default_rng(seed).normal(size=(count, points, 3))


@given(seeds)
@settings(max_examples=10)
def test_planar_distance_is_the_least_over_turns_and_shifts(seed: int) -> None:
    a, b = clouds(seed, 2)
    np.testing.assert_allclose(planar_distances([a], [b])[0, 0], naive.planar_distance(a, b), rtol=1e-5)


@given(seeds, st.floats(-3.0, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_planar_distance_ignores_turns_and_floor_shifts_of_either_cloud(
    seed: int, turn: float, x: float, z: float
) -> None:
    a, b = clouds(seed, 3), clouds(seed + 1, 5)
    moved = quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], turn), a) + np.array([x, 0.0, z])
    np.testing.assert_allclose(planar_distances(moved, b), planar_distances(a, b), atol=1e-9)
    np.testing.assert_allclose(planar_distances(b, moved), planar_distances(b, a), atol=1e-9)
    np.testing.assert_allclose(planar_distances(a, moved).diagonal(), 0.0, atol=1e-9)


@given(seeds, st.floats(0.1, 2.0))
def test_planar_distance_includes_heights(seed: int, height: float) -> None:
    a = clouds(seed, 1)
    np.testing.assert_allclose(planar_distances(a, a + np.array([0.0, height, 0.0])), 4 * height**2, rtol=1e-9)


@given(seeds)
def test_planar_distance_is_the_diagonal_of_planar_distances(seed: int) -> None:
    a, b = clouds(seed, 6), clouds(seed + 1, 6)
    np.testing.assert_allclose(planar_distance(a, b), planar_distances(a, b).diagonal(), atol=1e-9)


@given(seeds, st.integers(2, 7))
def test_horn_finds_a_known_rotation(seed: int, points: int) -> None:
    source = clouds(seed, 3, points)
    known = Rotation.random(3, random_state=seed).as_quat()
    assert quaternion.angle(horn_rotation(quaternion.rotate(known[:, None], source), source), known).max() < 1e-6


@given(seeds)
def test_horn_agrees_with_scipys_least_squares(seed: int) -> None:
    target, source = clouds(seed, 2)
    expected = Rotation.align_vectors(target, source)[0].as_quat()
    assert quaternion.angle(horn_rotation(target, source), expected) < 1e-5


@given(seeds, st.integers(0, 9), st.integers(1, 8))
def test_lag_distances_are_the_distances_of_pairs(seed: int, first: int, count: int) -> None:
    a = clouds(seed, 10)
    for lag, distances in enumerate(planar_lag_distances(a, range(first, first + count)), first):
        pairs = max(10 - lag, 0)
        np.testing.assert_allclose(distances[:pairs], planar_distance(a[:pairs], a[lag:]), atol=1e-9)
        assert np.all(np.isinf(distances[pairs:]))
