"""A report of quality for tests, with the numbers of real splices."""

from __future__ import annotations

from typing import Any

from bench.quality.document import document
from bench.quality.judge import judge
from bench.quality.pair_list import Pair
from bench.quality.scores import Form, score_clip
from bench.quality.targets import BUILT_IN, targets
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator

PAIRS = (
    Pair("walk", "wave", "walk"),
    Pair("run", "carry_box", "run+carry_box", "Running with a box"),
    Pair("run", "wave"),
)


def report_of(bank: Bank) -> dict[str, Any]:
    """Returns a report of three pairs: with a truth of the bank, with one that it does not have, and without."""
    evaluator = Evaluator(bank)
    judged = [judge(evaluator, pair, (Form("naive"), Form("exact"), Form("splice"))) for pair in PAIRS]
    clips = [score_clip(bank, clip.name) for clip in bank.clips]
    return document(bank, judged, clips, targets([one.score for one in judged], clips, BUILT_IN))
