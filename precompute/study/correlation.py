"""The correlation of upper body and legs: the study of Heck's thesis, 4.1 (docs/study.md).

The thesis judged by eye which trends are in phase with the swing of the hips, or opposite to it. Here each curve is cut
into cycles, and the wave of each cycle is a complex number. The sum of these over K cycles, divided by its value if all
waves peaked at the same point of the cycle, is the curve's *strength*: its cross-correlation with the legs at that
period. Where the sum peaks is the curve's *lag*.

Significance is tested against chance by shuffling. Each cycle is rolled by a random part of itself, which keeps the
curve's shape and breaks its relation to the legs. Then the strength is measured again, including the removal of the
drift. A few strides are few samples, so curves are cut as finely as is valid: into strides for motion that repeats once
a stride, into steps (twice as many) for motion that repeats with each step. Finer cuts would overstate the evidence:
within half a cycle any slow wave keeps in step. Two strides prove little (a wave must recur within about 9 degrees),
three or four prove much. White noise passes in 1 of 20 curves, as LEVEL says. Noise as slow as a step, which drifts
from one step to the next, passes in 1 of 10.
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
from motionsplice.precompute.alignment.alignment import align
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.study.body_angles import Axis, Curve, View, thigh_swing, upper_body_curves
from motionsplice.precompute.study.periodic import SAMPLES, Complexes, CycleWaves, Period

SHUFFLES = 2999
SEED = 0
LEVEL = 0.05  # of p, and of the false discovery rate
STILL = np.radians(0.3)  # a curve of smaller amplitude counts as noise, for any p
NEAR = np.radians(45.0)  # of a cycle: a lag this near to the swing, or to its opposite, counts as in phase or opposite
FEWEST_STRIDES = 2
TINY = np.finfo(np.float64).tiny


class Verdict(StrEnum):
    """How a curve correlates with the legs' swing: named by its lag if significant, else `none` or `still`."""

    IN_PHASE = "in phase"
    OPPOSITE = "opposite"
    AT_A_LAG = "at a lag"
    NONE = "none"
    STILL = "still"

    @property
    def correlated(self) -> bool:
        """Whether the correlation is significant."""
        return self not in (Verdict.NONE, Verdict.STILL)


class Survival(StrEnum):
    """The fate of a correlation in another motion: kept (lag within NEAR), changed (another lag) or lost (chance)."""

    KEPT = "kept"
    CHANGED = "changed"
    LOST = "lost"


class Key(NamedTuple):
    """The name of a correlation, the same in every motion."""

    view: View
    period: Period
    axis: Axis
    joint: str


@dataclass(frozen=True, eq=False)
class Correlation:
    """The correlation of a curve with the legs at one period.

    amplitude: radians, root mean square of the cycles' waves. strength: 0 to 1. lag: radians of the cycle, in
    (-pi, pi], by which the curve peaks after a thigh is foremost: the left thigh for the stride's period, either thigh
    for the step's. p: the share of shuffled curves that are as strong; 1 for a still curve.
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

    seconds: [F]. phase: [F] strides, a whole number where the left thigh is foremost. thighs: [2, F] radians, the swing
    of left and right thigh.
    """

    name: str
    seconds: Floats
    phase: Floats
    thighs: Floats
    correlations: tuple[Correlation, ...]

    @property
    def found(self) -> dict[Key, Correlation]:
        """The significant correlations."""
        return {one.key: one for one in self.correlations if one.verdict.correlated}


def study(clip: Clip, roles: Roles) -> Study:
    """Returns the correlations of a motion's upper body with its legs. The same clip always gives the same numbers.

    Raises BaselineError if the clip has no stride, ClipError if it has fewer than two, rounded to whole strides.
    """
    try:
        stride = find_baseline(clip, roles)
    except BaselineError as error:
        raise BaselineError(error.problem, mend="Use a motion that walks or runs for two strides or more") from None
    phase = align(clip, roles, stride).phase
    if Period.STRIDE.cycles(phase) < FEWEST_STRIDES:
        raise ClipError(
            f"it has {phase[-1] - phase[0]:.1f} strides, too few to find a correlation",
            place=f"clip {clip.name!r}",
            mend=f"Use at least {FEWEST_STRIDES} strides, better four or more",
        )
    thighs = thigh_swing(clip, roles, phase)
    waves = CycleWaves.of(phase, Period.STRIDE)
    foremost = np.angle(waves.read(waves.rest(thighs[0] - thighs[1], phase)).sum())
    phase = phase - foremost / (2.0 * np.pi)
    curves = upper_body_curves(clip, roles, phase)
    correlations = correlate(curves, phase)
    return Study(clip.name, np.arange(clip.frame_count) / clip.rate, phase, thighs, correlations)


def correlate(curves: tuple[Curve, ...], phase: Floats) -> tuple[Correlation, ...]:
    """Returns the correlations of curves with the legs at each period.

    phase: [F] strides, a whole number where the left thigh is foremost.
    """
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
    """Returns the fate of a correlation in the study of another motion; None if that rig does not have the joint."""
    if all(one.key != first.key for one in study.correlations):
        return None
    later = study.found.get(first.key)
    if later is None:
        return Survival.LOST
    return Survival.KEPT if abs(lag_between(first, later)) <= NEAR else Survival.CHANGED


def lag_between(first: Correlation, later: Correlation) -> float:
    """Returns by how many radians of the cycle `later` peaks after `first`, in (-pi, pi]."""
    return float(np.angle(np.exp(1j * (later.lag - first.lag))))


def largest_real(p: Floats) -> float:
    """Returns the largest of the p-values [n] that is significant; 0 if none is.

    A significant p-value is at most LEVEL. By Benjamini and Hochberg's rule, at most a share LEVEL of the significant
    ones is chance. The rule assumes that all n could be chance. In a walk few are, so the number of chance ones is
    first estimated from the p-values above one half (Storey 2002).
    """
    if len(p) == 0:
        return 0.0
    chances = min(len(p), 2 * (1 + int(np.count_nonzero(p > 0.5))))
    ordered = np.sort(p)
    real = ordered[ordered <= np.minimum(LEVEL, LEVEL * np.arange(1, len(p) + 1) / chances)]
    return float(real[-1]) if len(real) else 0.0


def _measured(curve: Curve, phase: Floats, waves: CycleWaves) -> Correlation:
    """Returns a curve's correlation, with verdict `none` until all p-values are compared, or `still`."""
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
    """Returns how well the waves of K cycles [..., K] agree, 0 to 1."""
    power = np.sum(np.abs(cycles) ** 2, axis=-1)
    return np.asarray(np.abs(cycles.sum(axis=-1)) / np.sqrt(cycles.shape[-1] * np.maximum(power, TINY)))


def _verdict(lag: float) -> Verdict:
    """Returns the verdict on a significant correlation, from its lag in radians."""
    if abs(lag) <= NEAR:
        return Verdict.IN_PHASE
    return Verdict.OPPOSITE if abs(lag) >= np.pi - NEAR else Verdict.AT_A_LAG
