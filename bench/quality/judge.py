"""Splices of one pair, and how near they come to its truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.quality.claims import CLAIMS, Performance
from bench.quality.measures import upper_body_errors
from bench.quality.pair_list import Pair, truth_of
from bench.quality.scores import Form, PairScore, Spliced, score_pair, splice_pair
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator

SHOWN_RATE = 30.0  # frames per second of the strips that show errors over time


@dataclass(frozen=True, eq=False)
class Judged:
    """One pair, its truth if it is known, its splices and their scores."""

    pair: Pair
    truth: Clip | None
    splices: list[Spliced]
    score: PairScore


def judge(evaluator: Evaluator, pair: Pair, forms: Sequence[Form]) -> Judged:
    """Splices one pair in every form, and scores that."""
    truth = truth_of(pair, evaluator.bank)
    splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
    return Judged(pair, truth, splices, score_pair(evaluator, pair.locomotion, pair.action, truth, splices))


def claimed(bank: Bank, judged: Judged) -> dict[str, float]:
    """The number of a pair's claim for each splice, the truth (else the locomotion itself) and the action itself."""
    pair = judged.pair
    phase, measure = bank.phase(pair.locomotion), CLAIMS[pair.claim].measure
    action = Performance(bank.motion(pair.action), bank.phase(pair.action), bank.roles)
    shown = {one.form.label: one.clip for one in judged.splices}
    shown["truth"] = judged.truth or bank.motion(pair.locomotion)
    values = {
        label: measure(Performance(clip, phase[: clip.frame_count], bank.roles), action)
        for label, clip in shown.items()
    }
    return {**values, "action": measure(action, action)}


def errors_over_time(bank: Bank, judged: Judged) -> dict[str, Floats]:
    """Each splice's error [F], cm, mean over joints, at SHOWN_RATE; nothing without a truth."""
    if judged.truth is None:
        return {}
    truth = judged.truth.resampled(SHOWN_RATE)
    clips = {one.form.label: one.clip.resampled(SHOWN_RATE) for one in judged.splices}
    return {label: 100.0 * upper_body_errors(clip, truth, bank.roles).mean(axis=1) for label, clip in clips.items()}
