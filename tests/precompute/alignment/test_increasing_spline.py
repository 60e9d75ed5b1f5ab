from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.increasing_spline import (
    DEGREE,
    LEAST_SLOPE,
    fit_increasing,
    normal_equations,
)
from tests import naive


def staircase(seed: int, count: int) -> Floats:
    steps = np.random.default_rng(seed).choice([0.0, 1.0, 4.0], size=count - 1, p=[0.5, 0.4, 0.1])
    return np.concatenate([[0.0], np.cumsum(steps)]) + np.linspace(0.0, 1.0, count)


@given(st.integers(0, 10**6), st.integers(3, 300))
@settings(max_examples=50)
def test_the_spline_rises_everywhere(seed: int, count: int) -> None:
    x, y = np.arange(float(count)), staircase(seed, count)
    curve = fit_increasing(x, y, 6.0)
    dense = curve(np.linspace(x[0], x[-1], 10 * count))
    assert np.diff(dense).min() > 0.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("stiffness", [0.0, 1.0, 30.0])
def test_the_spline_is_the_bounded_least_squares_fit(seed: int, stiffness: float) -> None:
    x, y = np.arange(200.0), staircase(seed, 200)
    curve = fit_increasing(x, y, 6.0, stiffness)
    design = BSpline.design_matrix(x, curve.t, DEGREE).toarray()
    abscissae = np.array([curve.t[i + 1 : i + 1 + DEGREE].mean() for i in range(len(curve.c))])
    steps = np.diff(abscissae) / np.diff(abscissae).max()
    slopes = np.diff(np.eye(len(curve.c)), axis=0) / steps[:, None]
    bend = np.diff(slopes, axis=0) / np.sqrt(0.5 * (steps[:-1] + steps[1:]))[:, None]
    stiff = np.concatenate([design, np.sqrt(stiffness * len(x) / len(curve.c)) * bend])
    floor = LEAST_SLOPE * (y[-1] - y[0]) / (x[-1] - x[0]) * np.diff(abscissae)
    wanted = naive.increasing_coefficients(stiff, np.concatenate([y, np.zeros(len(bend))]), floor)
    np.testing.assert_allclose(curve.c, wanted, atol=1e-3)


def test_a_stiffer_spline_changes_its_speed_less() -> None:
    x, y = np.arange(200.0), staircase(5, 200)
    bent = [np.abs(np.diff(fit_increasing(x, y, 6.0, stiffness)(x), 2)).mean() for stiffness in (0.0, 1.0, 30.0)]
    assert bent[0] > bent[1] > bent[2]


@pytest.mark.parametrize("stiffness", [0.0, 1.0, 100.0])
def test_a_straight_line_is_fitted_exactly(stiffness: float) -> None:
    x = np.linspace(0.0, 10.0, 80)
    np.testing.assert_allclose(fit_increasing(x, 3.0 * x - 2.0, 0.5, stiffness)(x), 3.0 * x - 2.0, atol=1e-4)


@given(st.integers(0, 10**6), st.integers(3, 60), st.floats(0.0, 30.0))
@settings(max_examples=30, deadline=None)
def test_the_normal_equations_are_those_of_the_dense_matrices(seed: int, count: int, stiffness: float) -> None:
    rng = np.random.default_rng(seed)
    x, y = np.sort(rng.integers(0, count, count)).astype(np.float64), rng.normal(size=count)
    x[0], x[-1] = 0.0, count
    curve = fit_increasing(x, np.sort(y), 4.0)
    steps = np.diff([curve.t[i + 1 : i + 1 + DEGREE].mean() for i in range(len(curve.c))])
    bands, right = normal_equations(x, y, curve.t, steps, stiffness)
    design = BSpline.design_matrix(x, curve.t, DEGREE).toarray()
    slopes = steps.max() * np.diff(np.eye(len(curve.c)), axis=0) / steps[:, None]
    bend = np.diff(slopes, axis=0) * np.sqrt(2.0 * steps.max() / (steps[:-1] + steps[1:]))[:, None]
    normal = design.T @ design + stiffness * bend.T @ bend
    for offset, band in enumerate(bands):
        np.testing.assert_allclose(band[: len(band) - offset], np.diag(normal, -offset), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(right, design.T @ y, atol=1e-9)
