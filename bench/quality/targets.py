"""Targets for the scores, and whether they are met."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from bench.quality.scores import ClipScore, MethodScore, PairScore

OURS, REFERENCE = "splice", "exact"
LEAST_CONCENTRATION = 0.93
LEAST_RANKING = 0.6
FEW = 8  # pairs: fewer have no order to speak of


@dataclass(frozen=True)
class Bounds:
    """Upper bounds for the scores of one kind of motion; None for no bound.

    If `walking` is given, the arms' timing is judged on these locomotions only. On stairs and in side steps, the
    built-in arms are not timed like the knees.
    """

    mean_ratio: float
    worst_ratio: float | None = None
    oracle: float | None = None
    floor: float | None = None
    walking: frozenset[str] | None = None


REAL = Bounds(mean_ratio=0.45, worst_ratio=0.7, oracle=1.6, floor=1.5)
BUILT_IN = Bounds(mean_ratio=0.35, walking=frozenset({"walk", "slow_walk", "curve", "turn_180", "step_up"}))


@dataclass(frozen=True)
class Target:
    """A measured number, its bound, and whether the bound is met.

    what: the measure. found: its value, with the name of the worst pair or clip where there is one. wanted: the bound.
    """

    what: str
    found: str
    wanted: str
    met: bool


def targets(pairs: Sequence[PairScore], clips: Sequence[ClipScore], bounds: Bounds) -> list[Target]:
    """Returns all targets that apply to the scores."""
    results: list[Target | None] = []
    judged = [one for one in pairs if one.truth]
    if judged:
        ratios = {name: _mean([one.of(name).ratio for one in judged]) for name in (OURS, REFERENCE)}
        error, oracle = _mean([one.of(OURS).error for one in judged]), _mean([one.oracle for one in judged])
        known = [one for one in judged if one.floor is not None]
        floor = _mean([one.of(OURS).error for one in known]) / _mean([one.floor for one in known])
        results = [
            _at_most("error / naive splice, mean of all pairs", ratios[OURS], bounds.mean_ratio),
            _worst(judged, "error / naive splice, worst pair", lambda one: one.ratio, bounds.worst_ratio),
            _at_most("error / papers' whole-clip splice", ratios[OURS] / ratios[REFERENCE], 1.1),
            _at_most("error / oracle that knows the truth", error / oracle, bounds.oracle),
            _at_most("error / difference between the truth's own strides", floor, bounds.floor),
            _ranking(judged),
        ]
    walking = [one for one in judged if bounds.walking is None or one.locomotion in bounds.walking]
    results += [
        _worst(walking, "lag of the arms, worst walk, degrees of a stride", lambda one: one.lag, 15.0),
        _worst(pairs, "jitter of the neck / larger source, worst pair", lambda one: one.jitter, 1.1),
        _worst(pairs, "posture from the promised one, worst pair, degrees", lambda one: one.posture, 1.5),
        _worst(pairs, "change within either half, worst pair, degrees", lambda one: one.change, 0.05),
        _least_concentration(clips),
    ]
    return [one for one in results if one is not None]


def _worst(
    pairs: Sequence[PairScore], what: str, measure: Callable[[MethodScore], float | None], most: float | None
) -> Target | None:
    known = [(value, one.name) for one in pairs if (value := measure(one.of(OURS))) is not None]
    if not known or most is None:
        return None
    value, name = max(known)
    return Target(what, f"{value:.3g} ({name})", f"<= {most:g}", bool(value <= most))


def _ranking(pairs: Sequence[PairScore]) -> Target | None:
    known = [(one.expected, one.of(OURS).ratio) for one in pairs if one.expected is not None]
    if len(known) < FEW:
        return None
    value = float(spearmanr(*np.array(known, np.float64).T).statistic)
    what = "rank correlation of error / naive splice with what was expected"
    return Target(what, f"{value:.2f}", f">= {LEAST_RANKING}", value >= LEAST_RANKING)


def _at_most(what: str, value: float, most: float | None) -> Target | None:
    return None if most is None else Target(what, f"{value:.2f}", f"<= {most:g}", bool(value <= most))


def _least_concentration(clips: Sequence[ClipScore]) -> Target | None:
    walks = [one for one in clips if one.kind == "locomotion"]
    known = [(one.concentration, one.clip) for one in walks if one.concentration is not None]
    if not known:
        return None
    value, name = min(known)
    met = value >= LEAST_CONCENTRATION
    return Target("phase concentration, lowest locomotion", f"{value:.3f} ({name})", f">= {LEAST_CONCENTRATION}", met)


def _mean(values: Sequence[float | None]) -> float:
    return float(np.mean([value for value in values if value is not None]))
