from __future__ import annotations

from pathlib import Path

from bench.clips import bank_of
from bench.quality.pair_list import Pair
from bench.quality.starts import ratio
from motionsplice.runtime.evaluator import Evaluator


def test_a_clip_that_is_its_own_truth_is_far_closer_than_replacement_at_other_starts(tmp_path: Path) -> None:
    evaluator = Evaluator(bank_of(None, "walk", tmp_path / "bank"))
    assert ratio(evaluator, Pair("walk", "walk", "walk")) < 0.3
