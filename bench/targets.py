"""What is wanted of the scores, and whether it is met."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bench.scores import ClipScore, MethodScore, PairScore

OURS, REFERENCE = "splice", "exact"


@dataclass(frozen=True)
class Target:
    """A number found, the bound it is held to, and whether that is met; `found` names the worst where there is one."""

    what: str
    found: str
    wanted: str
    met: bool


def targets(pairs: Sequence[PairScore], clips: Sequence[ClipScore], mean_ratio: float) -> list[Target]:
    """All targets that the scores say something of. mean_ratio is what the mean error over the naive one's may be."""
    found = [_worst(pairs, *bound) for bound in BOUNDS]
    judged = [one for one in pairs if one.truth]
    if judged:
        mean = float(np.mean([one.of(OURS).ratio for one in judged]))
        found.insert(0, _at_most("error over the naive splice's, mean of all pairs", mean, mean_ratio))
        errors = {name: np.mean([one.of(name).ratio for one in judged]) for name in (OURS, REFERENCE)}
        found.insert(2, _at_most("bank over the papers' whole-clip splice", errors[OURS] / errors[REFERENCE], 1.1))
        oracle = np.mean([one.of(OURS).error for one in judged]) / np.mean([one.oracle for one in judged])
        found.insert(3, _at_most("error over that of an oracle that knows the truth", float(oracle), 1.6))
    walks = [one for one in clips if one.kind == "locomotion" and one.concentration is not None]
    if walks:
        least = min(walks, key=lambda one: one.concentration or 0.0)
        value = least.concentration or 0.0
        found.append(
            Target("phase concentration, worst locomotion", f"{value:.3f} ({least.clip})", ">= 0.93", value >= 0.93)
        )
    return [one for one in found if one is not None]


Bound = tuple[str, Callable[[MethodScore], float | None], float]
BOUNDS: tuple[Bound, ...] = (
    ("error over the naive splice's, worst pair", lambda one: one.ratio, 0.7),
    ("arms out of step with the legs, worst pair, degrees of a stride", lambda one: one.lag, 15.0),
    ("neck's jitter over the larger source's, worst pair", lambda one: one.jitter, 1.1),
    ("posture off what its form promises, worst pair, degrees", lambda one: one.posture, 1.5),
    ("turn within either half against its source, worst pair, degrees", lambda one: one.change, 0.05),
)


def _worst(
    pairs: Sequence[PairScore], what: str, measure: Callable[[MethodScore], float | None], most: float
) -> Target | None:
    known = [(value, one.name) for one in pairs if (value := measure(one.of(OURS))) is not None]
    if not known:
        return None
    value, name = max(known)
    return Target(what, f"{value:.3g} ({name})", f"<= {most:g}", bool(value <= most))


def _at_most(what: str, value: float, most: float) -> Target:
    return Target(what, f"{value:.2f}", f"<= {most:g}", bool(value <= most))
