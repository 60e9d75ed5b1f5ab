from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.precompute.body.turned_points import turned_points


@given(st.integers(0, 2**32 - 1), st.integers(1, 9), st.integers(1, 4))
def test_points_turn_as_the_slow_twin_turns_them(seed: int, frames: int, points: int) -> None:
    rng = np.random.default_rng(seed)
    turns, at = quaternion.normalise(rng.normal(size=(frames, 4))), rng.normal(size=(frames, points, 3))
    wanted = quaternion.rotate(turns[:, None], at)
    np.testing.assert_allclose(turned_points(turns, at), wanted, atol=1e-14)
    np.testing.assert_array_equal(turned_points(turns[::-1], at[::-1]), turned_points(turns, at)[::-1])
