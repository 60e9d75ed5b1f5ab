from __future__ import annotations

import numpy as np
import pytest

from bench.quality.measures import upper_body_errors
from motionsplice.motion.procedural.library import truth
from motionsplice.motion.samples import write_sample_clips
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import LEGS, REPETITIONS, Expectation, expectation
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


def test_nothing_is_expected_without_an_action(evaluator: Evaluator) -> None:
    assert expectation(evaluator, Splice("walk")) is None
