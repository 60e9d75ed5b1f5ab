"""Which motions of the upper body go with the legs: the correlation study of Heck's thesis, 4.1 (docs/study.md).

The thesis found by eye which trends are in phase with the hips' swing or opposite to it. Here each curve is cut into
cycles, and the wave of each is a complex number. Their sum over K cycles, as a part of what it would be if all peaked
at one point of the cycle, is the curve's *strength* (its cross-correlation with the legs at that period); where the
sum peaks is its *lag*.

What would chance do? Each cycle is rolled round by a random part of itself, which keeps the curve's shape and breaks
every tie to the legs, and the strength is measured anew, from taking out the drift on. A few strides are few
witnesses, so each is cut as finely as the question allows: in strides for what comes once a stride, in steps, twice
as many, for what comes with each step. Finer cuts would prove more than there is: within half a cycle any slow wave
keeps step. Two strides still prove little (a wave must come back within some 9 degrees), three or four much. White
noise passes in 1 of 20 curves, as LEVEL says; noise as slow as a step, which drifts from one to the next, in 1 of 10.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import NamedTuple

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError, ClipError
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.baseline import align, find_baseline
from motionsplice.precompute.study.body_angles import Axis, Curve, View, thigh_swing, upper_body_curves
from motionsplice.precompute.study.periodic import SAMPLES, Complexes, CycleWaves, Period

SHUFFLES = 2999
SEED = 0
LEVEL = 0.05  # of p, and of the share of false discoveries among all
STILL = np.radians(0.3)  # amplitude below which a curve is noise, whatever its p
NEAR = np.radians(45.0)  # of a cycle: nearer to the swing, or to its opposite, is in phase with it
FEWEST_STRIDES = 2
TINY = np.finfo(np.float64).tiny


class Verdict(StrEnum):
    """How a curve goes with the legs' swing: significantly, by its lag, or not."""

    IN_PHASE = "in phase"
    OPPOSITE = "opposite"
    AT_A_LAG = "at a lag"
    NONE = "none"
    STILL = "still"

    @property
    def correlated(self) -> bool:
        return self not in (Verdict.NONE, Verdict.STILL)


class Survival(StrEnum):
    """What became of a correlation: it holds within `NEAR`, it holds at another lag, or it is no more than chance."""

    KEPT = "kept"
    CHANGED = "changed"
    LOST = "lost"


class Key(NamedTuple):
    """What a correlation is called in every motion."""

    view: View
    period: Period
    axis: Axis
    joint: str


@dataclass(frozen=True, eq=False)
class Correlation:
    """How a curve goes with the legs at one period.

    amplitude: radians, root mean square of the cycles' waves. strength: 0 to 1. lag: radians of the cycle in
    (-pi, pi] by which it peaks after a thigh is foremost: the left one for the stride's period, either one for the
    step's. p: the share of shuffled curves that are as strong, 1 for a still one.
    """

    curve: Curve
    period: Period
    amplitude: float
    strength: float
    lag: float
    p: float
    verdict: Verdict

    @property
    def key(self) -> Key:
        return Key(self.curve.view, self.period, self.curve.axis, self.curve.joint)


@dataclass(frozen=True, eq=False)
class Study:
    """A motion's correlations: every curve at every period.

    seconds: [F]. phase: [F] strides, whole where the left thigh is foremost. thighs: [2, F] radians, the swing of
    the left and the right thigh.
    """

    name: str
    seconds: Floats
    phase: Floats
    thighs: Floats
    correlations: tuple[Correlation, ...]

    @property
    def found(self) -> dict[Key, Correlation]:
        """Those that are no chance."""
        return {one.key: one for one in self.correlations if one.verdict.correlated}


def study(clip: Clip, roles: Roles) -> Study:
    """The correlations of a motion's upper body with its legs. The same clip gives the same numbers.

    Raises BaselineError if it has no stride, and ClipError if it has fewer than two, to the nearest whole one.
    """
    try:
        stride = find_baseline(clip, roles)
    except BaselineError as error:
        raise BaselineError(error.problem, mend="Give a motion that walks or runs for two strides or more") from None
    phase = align(clip, roles, stride).phase
    if Period.STRIDE.cycles(phase) < FEWEST_STRIDES:
        raise ClipError(
            f"it has {phase[-1] - phase[0]:.1f} strides, and what comes once proves nothing",
            place=f"clip {clip.name!r}",
            mend=f"Give at least {FEWEST_STRIDES} strides, better four or more",
        )
    thighs = thigh_swing(clip, roles, phase)
    waves = CycleWaves.of(phase, Period.STRIDE)
    foremost = np.angle(waves.read(waves.rest(thighs[0] - thighs[1], phase)).sum())
    phase = phase - foremost / (2.0 * np.pi)
    curves = upper_body_curves(clip, roles, phase)
    correlations = correlate(curves, phase)
    return Study(clip.name, np.arange(clip.frame_count) / clip.rate, phase, thighs, correlations)


def correlate(curves: tuple[Curve, ...], phase: Floats) -> tuple[Correlation, ...]:
    """How curves go with the legs at each period; phase [F] in strides, whole where the left thigh is foremost."""
    measured = [
        _measured(curve, phase, waves) for waves in map(partial(CycleWaves.of, phase), Period) for curve in curves
    ]
    measured.sort(key=lambda one: (one.curve.view, one.period))
    bound = largest_real(np.array([one.p for one in measured if one.verdict is not Verdict.STILL]))
    return tuple(
        replace(one, verdict=_verdict(one.lag)) if one.verdict is Verdict.NONE and one.p <= bound else one
        for one in measured
    )


def survival(first: Correlation, study: Study) -> Survival | None:
    """What became of a correlation of one motion in another's study; None if that rig has no such joint."""
    if all(one.key != first.key for one in study.correlations):
        return None
    later = study.found.get(first.key)
    if later is None:
        return Survival.LOST
    return Survival.KEPT if abs(lag_between(first, later)) <= NEAR else Survival.CHANGED


def lag_between(first: Correlation, later: Correlation) -> float:
    """By how many radians of the cycle a curve peaks later than it did, in (-pi, pi]."""
    return float(np.angle(np.exp(1j * (later.lag - first.lag))))


def largest_real(p: Floats) -> float:
    """The largest of the p-values [n] that are taken for real; 0 if none is.

    At most LEVEL each, and by Benjamini and Hochberg's rule at most a LEVEL's part of all that are taken is chance.
    The rule supposes that all n could be chance. In a walk few are, so their count is first estimated from the
    p-values above one half, which are (Storey 2002).
    """
    if len(p) == 0:
        return 0.0
    chances = min(len(p), 2 * (1 + int(np.count_nonzero(p > 0.5))))
    ordered = np.sort(p)
    real = ordered[ordered <= np.minimum(LEVEL, LEVEL * np.arange(1, len(p) + 1) / chances)]
    return float(real[-1]) if len(real) else 0.0


def _measured(curve: Curve, phase: Floats, waves: CycleWaves) -> Correlation:
    """A curve's correlation, not yet judged by the others'."""
    rest = waves.rest(curve.angles, phase)
    cycles = waves.read(rest)
    amplitude = float(np.sqrt(np.mean(np.abs(cycles) ** 2)))
    strength, lag = float(_strength(cycles)), float(np.angle(cycles.sum()))
    if amplitude < STILL:
        return Correlation(curve, waves.period, amplitude, strength, lag, 1.0, Verdict.STILL)
    rolls = np.random.default_rng(SEED).integers(0, SAMPLES, (SHUFFLES, len(cycles)))
    parts = waves.rolled(rest)
    shuffled = np.zeros((SHUFFLES, len(cycles)), np.complex128)
    for cycle, part in enumerate(parts):
        shuffled += part[rolls[:, cycle]]
    as_strong = int(np.count_nonzero(_strength(shuffled) >= strength * (1.0 - 1e-9)))
    p = (1 + as_strong) / (1 + SHUFFLES)
    return Correlation(curve, waves.period, amplitude, strength, lag, p, Verdict.NONE)


def _strength(cycles: Complexes) -> Floats:
    """How well the waves of K cycles [..., K] agree, 0 to 1."""
    power = np.sum(np.abs(cycles) ** 2, axis=-1)
    return np.asarray(np.abs(cycles.sum(axis=-1)) / np.sqrt(cycles.shape[-1] * np.maximum(power, TINY)))


def _verdict(lag: float) -> Verdict:
    if abs(lag) <= NEAR:
        return Verdict.IN_PHASE
    return Verdict.OPPOSITE if abs(lag) >= np.pi - NEAR else Verdict.AT_A_LAG
