from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.precompute.body.sampled_rows import sampled_rows


@given(st.integers(0, 2**32 - 1), st.integers(1, 9), st.sampled_from([(), (2,), (3, 3)]), st.integers(1, 12))
def test_rows_between_frames_are_those_of_the_slow_twin(
    seed: int, frames: int, shape: tuple[int, ...], wanted: int
) -> None:
    rng = np.random.default_rng(seed)
    rows, at = rng.normal(size=(frames, *shape)), rng.uniform(-1.0, frames + 1.0, wanted)
    at[::3] = np.round(at[::3])
    np.testing.assert_array_equal(sampled_rows(rows, at), quaternion.interpolated(rows, at))
    np.testing.assert_array_equal(sampled_rows(rows[::-1], at), quaternion.interpolated(rows[::-1], at))
