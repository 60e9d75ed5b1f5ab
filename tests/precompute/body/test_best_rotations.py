from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.precompute.body.best_rotations import best_rotations


@given(st.integers(0, 2**32 - 1), st.integers(1, 70), st.integers(1, 9))
def test_best_rotations_equal_horns_rotation_of_each_frame(seed: int, frames: int, points: int) -> None:
    draw = np.random.default_rng(seed)
    targets, sources = draw.normal(size=(2, frames, points, 3))
    targets[::3] = sources[::3]
    targets[1::5] *= [0.0, 1.0, 0.0]  # on a line
    found, expected = best_rotations(targets, sources), horn_rotation(targets, sources)
    clear = np.linalg.eigvalsh(_horn_matrix(targets, sources))[:, -2:] @ [-1.0, 1.0] > 1e-2
    assert quaternion.angle(found, expected)[clear].max(initial=0.0) < 1e-6
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)


def _horn_matrix(targets: quaternion.Floats, sources: quaternion.Floats) -> quaternion.Floats:
    """Returns the matrix [n, 4, 4] of the quadratic form sum(target . q source), from values of the form."""

    def value(q: quaternion.Floats) -> quaternion.Floats:
        return np.asarray(np.sum(targets * _turned(q, sources), axis=(1, 2)))

    axes = np.eye(4)
    matrix = np.empty((len(targets), 4, 4))
    for i in range(4):
        for j in range(4):
            matrix[:, i, j] = 0.5 * (value(axes[i] + axes[j]) - value(axes[i]) - value(axes[j]))
    return matrix


def _turned(q: quaternion.Floats, vectors: quaternion.Floats) -> quaternion.Floats:
    """Returns q v q^*, quadratic in q, which need not be a unit quaternion."""
    pure = np.concatenate([vectors, np.zeros((*vectors.shape[:-1], 1))], axis=-1)
    return quaternion.multiply(quaternion.multiply(q, pure), quaternion.conjugate(q))[..., :3]
