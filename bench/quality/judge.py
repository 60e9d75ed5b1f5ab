"""Splices of one pair, and how close they are to its truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.quality.claims import CLAIMS, Performance
from bench.quality.measures import mismatch, upper_body_errors
from bench.quality.pair_list import Pair, truth_of
from bench.quality.scores import Form, PairScore, Spliced, score_pair, splice_pair
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator

STRIP_RATE = 30.0  # frames per second of the error strips


@dataclass(frozen=True, eq=False)
class Judged:
    """One pair, its truth if known, its splices and their scores."""

    pair: Pair
    truth: Clip | None
    splices: list[Spliced]
    score: PairScore


def judge(evaluator: Evaluator, pair: Pair, forms: Sequence[Form]) -> Judged:
    """Splices one pair in each form, and scores the splices."""
    truth = truth_of(pair, evaluator.bank)
    splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
    return Judged(pair, truth, splices, score_pair(evaluator, pair.locomotion, pair.action, truth, splices))


def claim_values(bank: Bank, judged: Judged) -> dict[str, float]:
    """Returns the number of a pair's claim for each splice, for the truth and for the action alone.

    If the truth is unknown, the locomotion stands in for it.
    """
    pair = judged.pair
    phase, measure = bank.phase(pair.locomotion), CLAIMS[pair.claim].measure
    action = Performance(bank.motion(pair.action), bank.phase(pair.action), bank.roles)
    clips = {one.form.label: one.clip for one in judged.splices}
    clips["truth"] = judged.truth or bank.motion(pair.locomotion)
    values = {
        label: measure(Performance(clip, phase[: clip.frame_count], bank.roles), action)
        for label, clip in clips.items()
    }
    return {**values, "action": measure(action, action)}


def errors_over_time(bank: Bank, judged: Judged) -> dict[str, Floats]:
    """Returns each splice's error [F] in cm, the mean over joints, at STRIP_RATE; empty if the truth is unknown."""
    if judged.truth is None:
        return {}
    truth = judged.truth.resampled(STRIP_RATE)
    clips = {one.form.label: one.clip.resampled(STRIP_RATE) for one in judged.splices}
    return {label: 100.0 * upper_body_errors(clip, truth, bank.roles).mean(axis=1) for label, clip in clips.items()}


def legs_over_time(bank: Bank, judged: Judged) -> dict[str, Floats]:
    """Returns the distance of the legs at aligned frames [F] in cm, at STRIP_RATE, for each splice that has these."""
    pair, values = judged.pair, {}
    locomotion = bank.motion(pair.locomotion)
    for one in judged.splices:
        if one.action_frames is not None:
            action = bank.motion(pair.action, seam=one.form.how == "splice")
            apart = 100.0 * mismatch(locomotion, action, one.action_frames, bank.roles)
            moments = np.arange(int(one.clip.duration * STRIP_RATE + 1e-6) + 1) / STRIP_RATE
            values[one.form.label] = np.interp(moments * locomotion.rate, np.arange(len(apart)), apart)
    return values
