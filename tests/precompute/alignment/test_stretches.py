"""The stretches of clips that stand and walk by turns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.joined import begins, joined
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.stances import Performer, standing_action
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.stretches import runs, steadied, stretches_of

WALK = make("walk", seconds=4.0)
ROLES = find_roles(WALK.skeleton)
RING = find_baseline(WALK, ROLES)
STAND = standing_action("hail", Performer())
flags = arrays(np.bool_, st.integers(2, 60))


@given(flags)
def test_runs_are_equal_flags_and_cover_all(stands: NDArray[np.bool_]) -> None:
    found = runs(stands)
    assert [frame for begin, end in found for frame in range(begin, end)] == list(range(len(stands)))
    assert all(len(set(stands[begin:end].tolist())) == 1 for begin, end in found)
    assert all(stands[begin] != stands[begin - 1] for begin, _ in found[1:])


@given(st.lists(st.integers(3, 20), min_size=2, max_size=6), st.booleans(), st.integers(0, 1000))
def test_a_steadied_phase_is_even_in_standing_stretches_and_in_step_after_them(
    lengths: list[int], first: bool, seed: int
) -> None:
    stands = np.concatenate([np.full(length, first ^ (number % 2 == 1)) for number, length in enumerate(lengths)])
    cycles = np.cumsum(np.random.default_rng(seed).uniform(0.01, 0.1, len(stands)))
    found = steadied(cycles, stands)
    steps, before = np.diff(found), np.diff(cycles)
    for begin, end in runs(stands):
        if stands[begin]:
            assert np.ptp(steps[begin : end - 1]) < 1e-9
        else:
            np.testing.assert_allclose(steps[begin : end - 1], before[begin : end - 1], atol=1e-12)
    walking = np.flatnonzero(~stands)
    apart = (found - cycles)[walking] - (found - cycles)[walking[0]]
    np.testing.assert_allclose(apart, np.round(apart), atol=1e-9)


@pytest.mark.parametrize("order", ["SW", "WS", "WSW", "SWS"])
def test_the_stretches_of_a_generated_clip_are_found(order: str) -> None:
    parts = [STAND if one == "S" else WALK for one in order]
    found = align(joined("both", parts), ROLES, RING).stretches
    assert [one.stands for one in found] == [one == "S" for one in order]
    assert [one.begin for one in found] == pytest.approx(begins(parts), abs=0.7)
    assert [one.end for one in found[:-1]] == [one.begin for one in found[1:]]


@pytest.mark.parametrize("clip", [WALK, STAND, make("turn_180"), make("step_up"), make("stairs_up")])
def test_a_clip_that_only_walks_or_only_stands_has_none(clip: Clip) -> None:
    assert align(clip, ROLES, RING).stretches == ()


def test_a_short_stop_does_not_count() -> None:
    stop = STAND.frames(0, 90)
    assert align(joined("stop", [WALK, stop, WALK]), ROLES, RING).stretches == ()


def test_stretches_lie_end_to_end() -> None:
    found = stretches_of(np.array([True, True, False, False, False]), 4.0)
    assert [(one.begin, one.end, one.stands) for one in found] == [(0.0, 1.5, True), (1.5, 4.0, False)]
