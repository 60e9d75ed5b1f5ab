"""Compares what is expected of splices with the truth: `python -m bench.quality.expectations [CLIPS]`.

Prints how `motionsplice.runtime.expectation` ranks the built-in pairs, or those of `bench/quality/pairs.csv` that have
a truth, as Spearman's correlation with their true errors; and how often it warns rightly that little is gained.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.stats import spearmanr

from bench.clips import bank_of
from bench.findings import Findings
from bench.quality.measures import upper_body_errors
from bench.quality.pair_list import PAIRS, Pair, grid_pairs, read_pairs, truth_of
from motionsplice.cli import run
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import LITTLE, expectation
from motionsplice.runtime.requests import Method
from motionsplice.runtime.splice import Splice

MUCH = 0.6  # of plain replacement's error: a splice below it clearly gains


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip; default: chosen automatically")] = None,
) -> None:
    """Prints how well expectations hold."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(bank_of(clips, baseline, Path(folder)))
        pairs = grid_pairs() if clips is None else [pair for pair in read_pairs(PAIRS) if pair.truth]
        compared(np.array([errors(evaluator, pair) for pair in pairs])).show()


def errors(evaluator: Evaluator, pair: Pair) -> tuple[float, float, float, float]:
    """Returns a pair's expected error and that of plain replacement, then the true ones, metres."""
    truth, found = truth_of(pair, evaluator.bank), expectation(evaluator, Splice(pair.locomotion, pair.action))
    assert truth is not None
    assert found is not None

    def off(method: Method) -> float:
        made = evaluator.clip(Splice(pair.locomotion, pair.action, method=method))
        return float(upper_body_errors(made, truth, evaluator.bank.roles).mean())

    return found.error, found.replaced, off("splice"), off("naive")


def compared(found: Floats) -> Findings:
    """Compares expected and true errors [n, 4]."""
    error, replaced, true_error, true_replaced = found.T
    ratio, true_ratio = error / replaced, true_error / true_replaced
    findings = Findings(f"What is expected of {len(found)} pairs, against the truth")
    for label, expected, truth in (
        ("error / plain replacement's", ratio, true_ratio),
        ("error", error, true_error),
        ("error of plain replacement", replaced, true_replaced),
    ):
        findings.add(f"rank correlation: {label}", float(spearmanr(expected, truth).statistic))
    for label, among in ((f"above {LITTLE}", true_ratio > LITTLE), (f"below {MUCH}", true_ratio < MUCH)):
        findings.add(
            f"warnings among {among.sum()} pairs that are {label}", float((ratio[among] > LITTLE).sum()), "{:.0f}"
        )
    return findings


if __name__ == "__main__":
    run(lambda: typer.run(main))
