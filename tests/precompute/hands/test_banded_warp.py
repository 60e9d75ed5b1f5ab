from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.errors import SettingsError
from motionsplice.precompute.hands.banded_warp import FramePair, cheapest_path, limits, medians, straight_band
from tests import naive_hands

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(2, 30), st.integers(2, 30), st.floats(0.05, 1.0))
@settings(max_examples=60)
def test_paths_are_the_cheapest_in_their_band(seed: int, frames: int, others: int, width: float) -> None:
    band = straight_band(frames, others, width, [])
    costs = np.random.default_rng(seed).random((frames, band.width)).astype(np.float32)
    path = cheapest_path(costs, band.low, band.high)
    steps = np.diff(path, axis=0)
    assert set(map(tuple, steps.tolist())) <= {(0, 1), (1, 0), (1, 1)}
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [frames - 1, others - 1]
    found = sum(float(costs[i, j - band.low[i]]) for i, j in path)
    assert found == pytest.approx(naive_hands.path_cost(costs.astype(np.float64), band.low, band.high), abs=1e-4)


@given(seeds, st.integers(2, 200), st.integers(2, 200), st.sampled_from([0.02, 0.1, 0.3, 1.0]), st.data())
@settings(max_examples=100)
def test_pairs_bend_any_band_and_are_met(
    seed: int, frames: int, others: int, width: float, data: st.DataObject
) -> None:
    draw, count = np.random.default_rng(seed), data.draw(st.integers(0, min(6, frames)))
    body = np.sort(draw.choice(frames, count, replace=False))
    hands = np.sort(draw.integers(0, others, count))
    pairs = [FramePair(int(a), int(b), int(draw.integers(0, 6))) for a, b in zip(body, hands, strict=True)]
    band = straight_band(frames, others, width, pairs)
    path = cheapest_path(draw.random((frames, band.width)).astype(np.float32), band.low, band.high)
    assert np.all(np.diff(path, axis=0) >= 0)
    assert np.all((path[:, 1] >= band.low[path[:, 0]]) & (path[:, 1] <= band.high[path[:, 0]]))
    least, most = limits(frames, others, pairs)
    taken = np.clip(medians(path, frames), least, most)
    assert np.all(np.diff(taken) >= 0.0)
    for one in pairs:
        assert abs(taken[one.body] - one.hands) <= one.tolerance


def test_pairs_are_parsed_and_formatted() -> None:
    assert FramePair.parse("300:288~5") == FramePair(300, 288, 5)
    assert [str(FramePair.parse(text)) for text in ("120:95", " 3 : 4 ~ 0 ")] == ["120:95", "3:4"]
    for text in ("120", "a:b", "1:2~", "-1:3", "1:2:3", "1:99999999999"):
        with pytest.raises(SettingsError, match="not a pair of frames"):
            FramePair.parse(text)
