from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionsplice.motion.errors import ClipError
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.ring import MOST_ADVANCE, MOST_ZERO_STEPS, walk_ring, wind, wind_steadily
from motionsplice.precompute.alignment.timewarp import MOST_FLAT_STEPS, align_pair, cheapest_paths, trace
from tests import naive

Winding = Callable[[Floats], NDArray[np.int64]]


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 6), st.integers(1, 3))
@settings(max_examples=40)
def test_path_costs_equal_those_of_trying_every_path(seed: int, rows: int, columns: int, most_flat: int) -> None:
    grid = np.random.default_rng(seed).random((rows, columns))
    by_row = [cheapest_paths(grid[:stop], most_flat)[0].min(axis=1) for stop in range(1, rows + 1)]
    by_column = [cheapest_paths(grid[:, :stop], most_flat)[1].min(axis=1) for stop in range(1, columns + 1)]
    np.testing.assert_allclose(np.stack(by_row), naive.cheapest_path_cost(grid, most_flat))
    np.testing.assert_array_equal(np.stack(by_column, axis=1), np.stack(by_row))


@given(st.integers(0, 10**6))
@settings(max_examples=20)
def test_a_traced_path_is_legal_and_has_the_reported_cost(seed: int) -> None:
    grid = np.random.default_rng(seed).random((20, 20))
    last_row, last_column, came = cheapest_paths(grid, MOST_FLAT_STEPS)
    np.testing.assert_array_equal(last_row[19], last_column[19])
    path = trace(came, 19, 19, int(np.argmin(last_row[19])))
    steps = np.diff(path, axis=0)
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [19, 19]
    assert set(map(tuple, steps.tolist())) <= {(1, 1), (1, 0), (0, 1)}
    runs = [len(list(run)) for step, run in itertools.groupby(map(tuple, steps.tolist())) if step != (1, 1)]
    assert max(runs, default=0) <= MOST_FLAT_STEPS
    np.testing.assert_allclose(grid[path[:, 0], path[:, 1]].sum(), last_row[19].min())


@given(st.integers(0, 10**6), st.integers(2, 5), st.integers(3, 5), st.booleans())
@settings(max_examples=10)
def test_winding_finds_the_cheapest_path(seed: int, frames: int, cells: int, waits: bool) -> None:
    random = np.random.default_rng(seed)
    distances, pace, steadiness = random.random((frames, cells)), 2.0 * random.random(), 0.5 * random.random()
    if waits:  # for as long as it may
        distances[:, 0], pace = 0.0, 0.0
    wound = walk_ring(distances, pace, steadiness).tolist()
    cost = naive.ring_cost(distances, wound, pace, steadiness)
    assert cost == pytest.approx(naive.best_ring_cost(distances, pace, steadiness, MOST_ADVANCE, MOST_ZERO_STEPS))


@given(st.integers(0, 10**6))
@settings(max_examples=20)
@pytest.mark.parametrize("winding", [wind, wind_steadily])
def test_winding_keeps_its_limits(winding: Winding, seed: int) -> None:
    wound = winding(np.random.default_rng(seed).random((200, 12)))
    steps = np.diff(wound)
    assert 0 <= wound[0] < 12
    assert steps.min() >= 0
    assert steps.max() <= MOST_ADVANCE
    assert "0" * (MOST_ZERO_STEPS + 1) not in "".join(str(step) for step in steps)


@pytest.mark.parametrize("winding", [wind, wind_steadily])
def test_winding_follows_a_known_path_within_half_a_cell(winding: Winding) -> None:
    truth = 5.0 + np.cumsum(1.2 + 0.7 * np.sin(np.linspace(0.0, 9.0, 200)))
    distances = 1.0 - np.cos(2.0 * np.pi * (truth[:, None] - np.arange(16)) / 16)
    apart = np.abs(winding(distances) - truth)
    assert apart.max() < 1.5
    assert np.median(apart) < 0.5


def test_steady_winding_keeps_its_pace_where_the_legs_say_little() -> None:
    distances = 1.0 - np.cos(2.0 * np.pi * (np.arange(120)[:, None] - np.arange(16)) / 16)
    distances[40:80] = 1.0 - 0.01 * (np.arange(16) == 8)  # one cell is a little nearer than others
    waits, keeps = (np.std(np.diff(winding(distances))[40:79]) for winding in (wind, wind_steadily))
    assert keeps < 0.5 * waits


def test_pairwise_alignment_recovers_a_known_warp() -> None:
    locomotion = np.linspace(0.0, 8.0, 160)  # phase of each frame
    action = np.interp(np.linspace(0, 1, 150), [0.0, 0.4, 1.0], [0.7, 3.0, 8.4])
    warp = align_pair(pacing(locomotion), pacing(action), 30.0)
    inside = np.arange(warp.path[-1, 0] + 1)
    found = np.interp(warp.curve(inside), np.arange(150), action)
    error = np.abs(np.mod(found - locomotion[inside] + 0.5, 1.0) - 0.5)
    assert np.median(error) < 0.02
    assert np.percentile(error, 95) < 0.06
    assert warp.mean_cost < 0.02


def test_the_grid_takes_little_more_than_a_byte_per_state() -> None:
    grid = np.random.default_rng(1).random((100, 120))
    size = sum(array.nbytes for array in cheapest_paths(grid, MOST_FLAT_STEPS))
    assert size < 1.5 * grid.size * (2 * MOST_FLAT_STEPS + 1)


def test_clips_too_long_for_a_grid_are_refused_before_it_is_allocated() -> None:
    hours = pacing(np.linspace(0.0, 3600.0, 3600 * 30))
    with pytest.raises(ClipError, match=r"3600 s and 3\d{3} s are too long.*--method splice"):
        align_pair(hours, hours, 30.0)


def pacing(phase: Floats) -> Floats:
    """Returns root and knees [n, 3, 3] of a body that walks on the spot; `phase` [n] in cycles."""
    swing = 2.0 * np.pi * phase
    root = np.stack([0.0 * swing, 0.02 * np.cos(2.0 * swing), 0.0 * swing], axis=-1)
    left = root + np.stack([0.1 + 0.0 * swing, -0.4 + 0.05 * np.cos(swing), 0.2 * np.sin(swing)], axis=-1)
    right = root + np.stack([-0.1 + 0.0 * swing, -0.4 - 0.05 * np.cos(swing), -0.2 * np.sin(swing)], axis=-1)
    return np.stack([root, left, right], axis=1)
