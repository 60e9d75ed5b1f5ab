"""The numbers of the quality report as a file, which `motionsplice serve --report` shows at /view/report."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from bench.quality.judge import STRIP_RATE, Judged, errors_over_time, legs_over_time
from bench.quality.scores import ClipScore
from bench.quality.targets import OURS, Target
from motionsplice import __version__
from motionsplice.runtime.bank import Bank


def document(
    bank: Bank, judged: Iterable[Judged], clips: Sequence[ClipScore], targets: Sequence[Target]
) -> dict[str, Any]:
    """Returns all numbers, and of which bank they are. A pair that was judged twice is there once, with its title."""
    pairs = {(one.pair.locomotion, one.pair.action, one.score.truth): one for one in judged}
    return {
        "bank": bank.digest,
        "version": __version__,
        "rate": STRIP_RATE,
        "targets": [asdict(one) for one in targets],
        "pairs": [_pair(bank, one) for one in pairs.values()],
        "clips": [asdict(one) for one in clips],
    }


def _pair(bank: Bank, judged: Judged) -> dict[str, Any]:
    """Returns the scores of a pair, what was measured over time, and the moment at which the bank's splice is worst.

    That is the error, or if the truth is unknown, the distance of the legs at aligned frames. Both are in cm.
    """
    measure = "legs" if judged.truth is None else "error"
    over_time = legs_over_time(bank, judged) if judged.truth is None else errors_over_time(bank, judged)
    worst = int(np.argmax(over_time[OURS]))
    score = judged.score
    scores = asdict(score)
    del scores["lacks"]
    return {
        **scores,
        "oracle": score.oracle,
        "lacking": {**score.lacking, "lag_seconds": score.lacks.lag_seconds} if score.lacks else None,
        "group": judged.pair.group,
        "example": judged.pair.example,
        "measure": measure,
        "over_time": {label: np.round(values, 2).tolist() for label, values in over_time.items()},
        "worst": {"time": round(worst / STRIP_RATE, 4), "value": round(float(over_time[OURS][worst]), 2)},
    }
