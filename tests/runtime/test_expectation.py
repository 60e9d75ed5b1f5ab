from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.quality.measures import upper_body_errors
from motionsplice.motion.comparison import at_frames
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make, truth
from motionsplice.motion.samples import write_sample_clips
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import LEGS, MOST, REPETITIONS, Expectation, expectation, some_of
from motionsplice.runtime.splice import Splice


@pytest.fixture(scope="module")
def evaluator(tmp_path_factory: pytest.TempPathFactory) -> Evaluator:
    folder = tmp_path_factory.mktemp("expectation")
    write_sample_clips(folder / "clips")
    build_bank([folder / "clips"], folder / "bank")
    return Evaluator(Bank.open(folder / "bank"))


def found(evaluator: Evaluator, locomotion: str, action: str) -> Expectation:
    known = expectation(evaluator, Splice(locomotion, action))
    assert known is not None
    return known


def test_a_clip_on_itself_is_expected_to_be_off_by_its_own_repetition(evaluator: Evaluator) -> None:
    own = found(evaluator, "walk", "walk")
    assert own.legs < 1e-3
    assert own.repetition == evaluator.bank.clip("walk").repetition > 0.0
    assert own.error == pytest.approx(np.hypot(REPETITIONS * own.repetition, LEGS * own.legs))
    assert own.replaced == pytest.approx(own.error, abs=2e-3)
    assert own.slowest == pytest.approx(1.0, abs=0.01)
    assert own.fastest == pytest.approx(1.0, abs=0.01)


def test_what_is_expected_of_replacement_is_what_it_is(evaluator: Evaluator) -> None:
    for locomotion, action in (("curve", "punch"), ("run", "wave"), ("slow_walk", "carry_cup")):
        replaced = evaluator.clip(Splice(locomotion, action, method="naive"))
        off = float(upper_body_errors(replaced, truth(locomotion, action), evaluator.bank.roles).mean())
        assert found(evaluator, locomotion, action).replaced == pytest.approx(off, rel=0.4)


def test_legs_that_match_worse_make_a_splice_less_certain(evaluator: Evaluator) -> None:
    alike, unlike = (found(evaluator, locomotion, "wave") for locomotion in ("walk", "side_step"))
    assert alike.legs < unlike.legs
    assert alike.ratio < unlike.ratio < 1.0


def test_little_is_gained_where_a_splice_is_near_replacement() -> None:
    assert Expectation(0.01, 0.01, 1.0, 1.0, error=0.09, replaced=0.1).gains_little
    assert not Expectation(0.01, 0.01, 1.0, 1.0, error=0.05, replaced=0.1).gains_little
    assert not Expectation(0.01, 0.01, 1.0, 1.0, error=0.004, replaced=0.004).gains_little  # nothing is wrong with it


def test_nothing_is_expected_without_an_action(evaluator: Evaluator) -> None:
    assert expectation(evaluator, Splice("walk")) is None


def test_the_paces_are_those_of_the_alignment(evaluator: Evaluator) -> None:
    frames = evaluator.action_frames(Splice("run", "carry_box"), evaluator.frame_times("run"))
    steps = np.diff(frames[::2])
    steps = steps[steps > 0.0] / 2.0
    known = found(evaluator, "run", "carry_box")
    assert known.slowest == pytest.approx(steps.min(), abs=0.02)
    assert known.fastest == pytest.approx(steps.max(), abs=0.02)
    assert known.slowest > 1.0


def test_of_a_long_locomotion_a_part_shows_what_all_of_it_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_sample_clips(tmp_path / "clips")
    (tmp_path / "clips" / "long_run.bvh").write_bytes(dump_bvh(make("run", seed=7, seconds=40.0)))
    build_bank([tmp_path / "clips"], tmp_path / "bank", baseline="walk")
    evaluator = Evaluator(Bank.open(tmp_path / "bank"))
    some = found(evaluator, "long_run", "wave")
    monkeypatch.setattr("motionsplice.runtime.expectation.MOST", 10 * MOST)
    every = found(evaluator, "long_run", "wave")
    assert some.error == pytest.approx(every.error, rel=0.1)
    assert some.replaced == pytest.approx(every.replaced, rel=0.1)
    assert some != every


@given(st.integers(1, 5000), st.integers(1, 400))
def test_some_moments_are_spread_over_all_and_in_order(count: int, most: int) -> None:
    moments = 2 * np.arange(count)
    some = some_of(moments, most)
    assert len(some) == min(count, most)
    assert np.isin(some, moments).all()
    assert (np.diff(some) >= 0).all()
    assert np.diff(some, prepend=0, append=moments[-1]).max(initial=0) <= 2 * (2 * count / len(some) + 1)


def test_frames_of_a_clip_are_those_of_the_whole_clip(evaluator: Evaluator) -> None:
    bank, frames = evaluator.bank, np.array([7.25, 3.0, 3.5, 0.0, 330.5, 359.99])
    for name in ("wave", "wave~mirror"):
        whole, some = at_frames(bank.motion(name, seam=True), frames), bank.motion_at(name, frames)
        np.testing.assert_allclose(some.root_positions, whole.root_positions, atol=1e-12)
        dots = np.abs(np.einsum("fji,fji->fj", some.rotations, whole.rotations))
        np.testing.assert_allclose(dots, 1.0, atol=1e-12)
