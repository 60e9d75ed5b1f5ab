from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation, Slerp

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats

vectors = arrays(np.float64, 3, elements=st.floats(-10.0, 10.0))
rotations = arrays(np.float64, 4, elements=st.floats(-1.0, 1.0)).filter(lambda q: float(np.linalg.norm(q)) > 0.1)
rotations = rotations.map(quaternion.normalise)


@given(rotations, rotations, vectors)
def test_product_turns_by_the_right_factor_first(a: Floats, b: Floats, v: Floats) -> None:
    turned = quaternion.rotate(quaternion.multiply(a, b), v)
    np.testing.assert_allclose(turned, quaternion.rotate(a, quaternion.rotate(b, v)), atol=1e-9)
    np.testing.assert_allclose(turned, (Rotation.from_quat(a) * Rotation.from_quat(b)).apply(v), atol=1e-9)


@given(rotations)
def test_conjugate_is_the_inverse(q: Floats) -> None:
    np.testing.assert_allclose(quaternion.multiply(q, quaternion.conjugate(q)), quaternion.IDENTITY, atol=1e-12)


@given(arrays(np.float64, (2, 3, 4), elements=st.floats(0.1, 1.0)).map(quaternion.normalise))
def test_matrices_agree_with_scipy(q: Floats) -> None:
    expected = Rotation.from_quat(q.reshape(-1, 4)).as_matrix().reshape(2, 3, 3, 3)
    np.testing.assert_allclose(quaternion.to_matrices(q), expected, atol=1e-12)


@given(rotations, rotations)
def test_angle_agrees_with_scipy(a: Floats, b: Floats) -> None:
    expected = (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude()
    np.testing.assert_allclose(quaternion.angle(a, b), expected, atol=1e-7)


@given(rotations, rotations, st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy(a: Floats, b: Floats, t: float) -> None:
    if quaternion.angle(a, b) > np.pi - 1e-3:
        return  # half a turn: both arcs are equally short
    expected = Slerp([0.0, 1.0], Rotation.from_quat(np.stack([a, b])))(t).as_quat()
    assert quaternion.angle(quaternion.slerp(a, b, t), expected) < 1e-7


@given(vectors.filter(lambda v: float(np.linalg.norm(v)) > 0.1), st.floats(-3.0, 3.0))
def test_about_agrees_with_scipy(axis: Floats, radians: float) -> None:
    unit = axis / np.linalg.norm(axis)
    expected = Rotation.from_rotvec(unit * radians).as_quat()
    assert quaternion.angle(quaternion.about(unit, radians), expected) < 1e-7


def test_one_hemisphere_keeps_rotations_and_aligns_successive_frames() -> None:
    turns = Rotation.from_rotvec(np.linspace([0.0, 0.0, 0.0], [20.0, 0.0, 0.0], 200)).as_quat()
    signs = np.where(np.random.default_rng(0).random(200) < 0.5, -1.0, 1.0)
    mended = quaternion.one_hemisphere((turns * signs[:, None])[:, None])[:, 0]
    assert np.all(np.sum(mended[1:] * mended[:-1], axis=1) > 0.0)
    assert np.all(np.isclose(np.abs(np.sum(mended * turns, axis=1)), 1.0))


@given(st.permutations("xyz"), st.integers(0, 3), vectors)
def test_euler_angles_agree_with_scipys_intrinsic_ones(order: list[str], count: int, angles: Floats) -> None:
    axes, halves = "".join(order)[:count], 0.5 * angles[:count]
    found = quaternion.from_euler(axes, np.sin(halves), np.cos(halves))
    expected = Rotation.from_euler(axes.upper(), angles[:count]).as_quat() if count else quaternion.IDENTITY
    np.testing.assert_allclose(quaternion.angle(found, expected), 0.0, atol=1e-7)


@given(rotations)
def test_log_and_exp_agree_with_scipy(q: Floats) -> None:
    vector = Rotation.from_quat(q).as_rotvec()
    if np.linalg.norm(vector) < np.pi - 1e-6:  # at half a turn the sign is ambiguous
        np.testing.assert_allclose(quaternion.log(q), vector, atol=1e-9)
    np.testing.assert_allclose(quaternion.exp(vector), Rotation.from_rotvec(vector).as_quat(), atol=1e-9)


@given(st.sampled_from([0.0, 1e-300, 1e-13, 1e-9]))
def test_log_and_exp_are_exact_for_tiny_rotations(angle: float) -> None:
    np.testing.assert_allclose(quaternion.log(quaternion.exp([0.0, angle, 0.0])), [0.0, angle, 0.0], rtol=1e-12)


def test_one_hemisphere_undoes_random_signs() -> None:
    q = quaternion.about([0.0, 1.0, 0.0], np.linspace(0.0, 5.0, 20))
    signs = np.random.default_rng(1).choice([-1.0, 1.0], (20, 1))
    joined = quaternion.one_hemisphere(q * signs)
    np.testing.assert_array_equal(joined, q * signs[0])
    np.testing.assert_array_equal(quaternion.one_hemisphere(q), q)


VECTORS = st.tuples(*[st.floats(-10.0, 10.0)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3)


@given(VECTORS, VECTORS)
def test_between_turns_one_direction_to_the_other_the_short_way(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    turn = quaternion.between(a, b)
    u, v = np.array(a) / np.linalg.norm(a), np.array(b) / np.linalg.norm(b)
    np.testing.assert_allclose(quaternion.rotate(turn, u), v, atol=1e-6)
    angle = 2.0 * np.arctan2(np.linalg.norm(u - v), np.linalg.norm(u + v))
    np.testing.assert_allclose(quaternion.angle(turn, quaternion.IDENTITY), angle, atol=1e-6)


@given(VECTORS)
def test_between_opposite_directions_is_half_a_turn_and_to_zero_is_none(a: tuple[float, ...]) -> None:
    turn = quaternion.between(a, np.negative(a))
    np.testing.assert_allclose(quaternion.rotate(turn, a), np.negative(a), atol=1e-6)
    assert np.all(quaternion.between(a, np.zeros(3)) == quaternion.IDENTITY)
