from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation, Slerp

from motion import quaternion
from motion.quaternion import Floats

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


@given(rotations, rotations)
def test_angle_is_scipys(a: Floats, b: Floats) -> None:
    expected = (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude()
    np.testing.assert_allclose(quaternion.angle(a, b), expected, atol=1e-7)


@given(rotations, rotations, st.floats(0.0, 1.0))
def test_slerp_is_scipys(a: Floats, b: Floats, t: float) -> None:
    if quaternion.angle(a, b) > np.pi - 1e-3:
        return  # halfway round, both arcs are as short
    expected = Slerp([0.0, 1.0], Rotation.from_quat(np.stack([a, b])))(t).as_quat()
    assert quaternion.angle(quaternion.slerp(a, b, t), expected) < 1e-7


@given(vectors.filter(lambda v: float(np.linalg.norm(v)) > 0.1), st.floats(-3.0, 3.0))
def test_about_an_axis_is_scipys(axis: Floats, radians: float) -> None:
    unit = axis / np.linalg.norm(axis)
    expected = Rotation.from_rotvec(unit * radians).as_quat()
    assert quaternion.angle(quaternion.about(unit, radians), expected) < 1e-7


def test_one_hemisphere_keeps_rotations_and_makes_neighbours_near() -> None:
    turns = Rotation.from_rotvec(np.linspace([0.0, 0.0, 0.0], [20.0, 0.0, 0.0], 200)).as_quat()
    signs = np.where(np.random.default_rng(0).random(200) < 0.5, -1.0, 1.0)
    mended = quaternion.one_hemisphere((turns * signs[:, None])[:, None])[:, 0]
    assert np.all(np.sum(mended[1:] * mended[:-1], axis=1) > 0.0)
    assert np.all(np.isclose(np.abs(np.sum(mended * turns, axis=1)), 1.0))
