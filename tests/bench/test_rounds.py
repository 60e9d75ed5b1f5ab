from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench import rounds
from bench.rounds import Work, evict_caches, fit_slope, interleaved, paced, paired_ratio, summaries


@given(st.floats(-10.0, 10.0), st.floats(20.0, 50.0))
def test_the_slope_of_a_straight_line_is_exact(slope: float, height: float) -> None:
    x = np.array([1.0, 2.0, 4.0])
    fit = fit_slope(x, height + slope * (x - 2.0))
    assert fit.slope == pytest.approx(slope, abs=1e-9)
    assert fit.error == pytest.approx(0.0, abs=1e-6)
    assert fit.relative == pytest.approx(slope / height, abs=1e-9)  # the middle point is at x = 2


def test_the_error_of_a_slope_matches_the_textbook() -> None:
    x, y = np.array([0.0, 1.0, 2.0, 3.0]), np.array([10.0, 12.0, 11.0, 13.0])
    fit = fit_slope(x, y)
    # slope 0.8, residuals -0.3, 0.9, -0.9, 0.3: sqrt(1.8 / 2 / 5)
    assert fit.slope == pytest.approx(0.8)
    assert fit.error == pytest.approx(np.sqrt(1.8 / 2.0 / 5.0))
    assert fit.relative_error == pytest.approx(fit.error / 11.5)


def test_ratios_are_taken_within_rounds() -> None:
    naive = np.array([1.0, 10.0, 100.0])
    assert paired_ratio(2.0 * naive, naive) == 2.0


def test_a_summary_is_per_character() -> None:
    seconds = {"naive": np.full(100, 4.0), "splice": np.arange(1.0, 101.0), "copy": np.full(100, 2.0)}
    naive, splice, _ = summaries(seconds, 10)
    assert (naive.median, naive.worst, naive.rounds, naive.characters) == (0.4, 0.4, 100, 10)
    assert splice.median == pytest.approx(5.05)
    assert splice.p95 < splice.p99 < splice.worst == 10.0
    assert naive.ratios == {"naive": 1.0, "copy": 2.0}
    assert splice.ratios["copy"] == pytest.approx(25.25)


def recorder(called: list[tuple[str, int]], name: str) -> Work:
    return lambda number: called.append((name, number))


def test_warm_work_runs_in_turns_with_one_untimed_call_each() -> None:
    called: list[tuple[str, int]] = []
    seconds = interleaved({name: recorder(called, name) for name in "abc"}, rounds=5, calls=2)
    assert {name: one.shape for name, one in seconds.items()} == {"a": (10,), "b": (10,), "c": (10,)}
    turns = [called[at : at + 3] for at in range(0, len(called), 3)]
    assert all(len({name for name, _ in turn}) == 1 for turn in turns)
    assert [{name for ((name, _), *_) in turns[at : at + 3]} for at in range(0, 18, 3)] == [{"a", "b", "c"}] * 6
    assert [number for name, number in called if name == "a"] == list(range(-1, 17))


def test_caches_are_evicted_before_each_call_of_cold_work() -> None:
    called: list[tuple[str, int]] = []
    work = {name: recorder(called, name) for name in "ab"}
    interleaved(work, 3, before=lambda: called.append(("evict", 0)))
    assert [name for name, _ in called[::2]] == ["evict"] * 8
    assert sorted(name for name, _ in called[1::2]) == ["a"] * 4 + ["b"] * 4


def test_paced_work_runs_in_turns_on_separate_ticks() -> None:
    called: list[str] = []
    seconds = paced({"a": lambda _: called.append("a"), "b": lambda _: called.append("b")}, ticks=3)
    assert [sorted(called[at : at + 2]) for at in range(0, 8, 2)] == [["a", "b"]] * 4
    assert {name: len(one) for name, one in seconds.items()} == {"a": 3, "b": 3}


def test_evicting_writes_memory() -> None:
    before = int(rounds.EVICTING[-1])
    evict_caches()
    assert int(rounds.EVICTING[-1]) == (before + 1) % 256
