from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.precompute.alignment.harmonics import fitted, waves


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.booleans())
def test_a_series_is_recovered_from_its_values(seed: int, harmonics: int, weighted: bool) -> None:
    draw = np.random.default_rng(seed)
    phase, coefficients = draw.uniform(-1.0, 2.0, 200), draw.normal(size=(1 + 2 * harmonics, 3))
    weights = draw.uniform(0.5, 2.0, 200) if weighted else None
    rows = waves(phase, harmonics)
    found = fitted(rows @ coefficients, rows, 1e-12, weights)
    np.testing.assert_allclose(found, coefficients, atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 10.0))
def test_steadying_makes_all_but_the_mean_smaller(seed: int, steadying: float) -> None:
    phase = np.arange(100) / 100.0
    values = np.random.default_rng(seed).normal(size=(100, 2))
    free, steady = (fitted(values, waves(phase, 2), one) for one in (0.0, steadying))
    np.testing.assert_allclose(steady[0], values.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(steady[1:], free[1:] / (1.0 + 2.0 * steadying), atol=1e-12)
