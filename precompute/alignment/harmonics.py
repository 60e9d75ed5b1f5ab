"""Fourier series over the stride: what a gait repeats."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.quaternion import Floats


def waves(phase: Floats, harmonics: int) -> Floats:
    """Returns 1, cosines and sines of the first harmonics [n, 1 + 2 harmonics] at `phase` [n], in cycles."""
    angles = 2.0 * np.pi * np.multiply.outer(phase, np.arange(1, harmonics + 1))
    return np.concatenate([np.ones((len(phase), 1)), np.cos(angles), np.sin(angles)], axis=1)


def fitted(values: Floats, rows: Floats, steadying: float, weights: Floats | None = None) -> Floats:
    """Returns the coefficients [1 + 2 harmonics, n] that fit values [F, n] best, given the `waves` at their phases.

    steadying: of the squares of all coefficients but the mean, against the mean squared misfit; it keeps those small
    that the phases do not determine. weights: [F] of the misfits; equal if omitted.
    """
    if weights is not None:
        rows, values = rows * weights[:, None], values * weights[:, None]
    normal = rows.T @ rows + steadying * len(rows) * np.diag([0.0] + [1.0] * (rows.shape[1] - 1))
    return np.asarray(np.linalg.solve(normal, rows.T @ values))
