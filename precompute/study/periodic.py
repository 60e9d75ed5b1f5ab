"""Decomposition of a curve by the legs' phase: its trend, its drift, and the wave of each stride or step."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from motionsplice.motion.quaternion import Floats

Complexes = NDArray[np.complex128]

TREND_CUTOFF = 6.0  # waves per stride: a wave that fast keeps half its size in the trend; the step's wave keeps 99 %
DRIFT_DEGREE = 1  # of the drift's polynomial, plus one per whole stride: enough for a turn, a start and a stop
SAMPLES = 64  # per cycle


class Period(IntEnum):
    """A period, in waves per stride: motion of one leg repeats once a stride, motion of both legs twice."""

    STRIDE = 1
    STEP = 2

    def cycles(self, phase: Floats) -> int:
        """Returns how many periods a motion has, rounded to a whole number; `phase` [F] is in strides."""
        return round(float(phase[-1] - phase[0]) * self)


def trend(curve: Floats, phase: Floats) -> Floats:
    """Returns the trend [F] of a curve [F] at phases [F] in strides (Heck's thesis, 4.1, step 3).

    It is a smoothing spline where the thesis uses a polynomial, whose degree must be chosen for each length of clip.
    Unlike a sum of waves of the legs' period, a spline does not assume that period, so it also follows a curve that is
    not correlated with the legs.
    """
    smoothness = (2.0 * np.pi * TREND_CUTOFF) ** -4.0
    return np.asarray(make_smoothing_spline(phase, curve, w=np.gradient(phase), lam=smoothness)(phase))


def drift(curve: Floats, phase: Floats) -> Floats:
    """Returns the drift [F] of a curve [F] at phases [F] in strides: the polynomial slower than a stride.

    It is fitted together with the waves. Fitted alone, it would follow part of the waves that the clip's ends cut off.
    """
    root = np.sqrt(np.gradient(phase))  # every part of the stride has the same weight, however fast it passes
    slow = _slow(phase)
    design = np.concatenate([slow, *(_wave(phase, period) for period in Period)], axis=1)
    solution = np.linalg.lstsq(design * root[:, None], curve * root, rcond=None)[0]
    return np.asarray(slow @ solution[: slow.shape[1]])


@dataclass(frozen=True, eq=False)
class CycleWaves:
    """Measures the wave of each of K cycles (strides or steps) of a curve.

    A clip is cut into K equal parts, its number of cycles rounded. Drift and the other period's wave are first removed
    from the whole curve. In each part a straight line is fitted together with the wave, because strides differ.

    phase: [K * SAMPLES] strides, evenly spaced. period: the period of the waves. parts: [K * SAMPLES, m] drift and the
    other period's wave. fit: [m, K * SAMPLES] maps a curve to the coefficients of `parts`. readers: [K, 2, SAMPLES] map
    each cycle to the cosine and sine of its wave.
    """

    phase: Floats
    period: Period
    parts: Floats
    fit: Floats
    readers: Floats

    @classmethod
    def of(cls, phase: Floats, period: Period) -> CycleWaves:
        """Returns the measurement for curves at phases [F] in strides."""
        count = period.cycles(phase)
        even = phase[0] + (np.arange(count * SAMPLES) + 0.5) / (count * SAMPLES) * (phase[-1] - phase[0])
        (other,) = (one for one in Period if one is not period)
        parts = np.concatenate([_slow(even), _wave(even, other)], axis=1)
        fit = np.linalg.pinv(np.concatenate([parts, _wave(even, period)], axis=1))[: parts.shape[1]]
        line = np.tile(np.linspace(-1.0, 1.0, SAMPLES), count)
        columns = np.column_stack([_wave(even, period), np.ones_like(line), line]).reshape(count, SAMPLES, -1)
        return cls(even, period, parts, fit, np.asarray(np.linalg.pinv(columns)[:, :2], np.float64))

    def rest(self, curve: Floats, phase: Floats) -> Floats:
        """Returns a curve [F] at phases [F] without drift and the other period's wave [K, SAMPLES]."""
        even = np.interp(self.phase, phase, curve)
        return np.asarray(even - self.parts @ (self.fit @ even)).reshape(-1, SAMPLES)

    def read(self, rest: Floats) -> Complexes:
        """Returns the cycles' waves [K] from what `rest` returned.

        The absolute value is the amplitude; the angle is where in the cycle the wave peaks.
        """
        both = np.einsum("kcs,ks->kc", self.readers, rest)
        return np.asarray(both[:, 0] + 1j * both[:, 1])

    def rolled(self, rest: Floats) -> Complexes:
        """Returns what each cycle, rolled by each number of samples, adds to the waves of all cycles [K, SAMPLES, K].

        Removing the drift couples the cycles, so rolling one cycle changes all waves a little.
        """
        count = len(rest)
        rolls = np.stack([np.roll(rest, shift, axis=1) for shift in range(SAMPLES)], axis=1)
        taken = rolls @ self.fit.T.reshape(count, SAMPLES, -1)
        couple = np.einsum("jcs,jsm->mjc", self.readers, self.parts.reshape(count, SAMPLES, -1))
        both = -np.einsum("ksm,mjc->ksjc", taken, couple)
        own = np.arange(count)
        both[own, :, own] += np.einsum("kcs,kts->ktc", self.readers, rolls)
        return np.asarray(both[..., 0] + 1j * both[..., 1])


def _slow(phase: Floats) -> Floats:
    """Returns the drift's polynomials at phases [F]: Legendre polynomials in columns [F, n]."""
    length = phase[-1] - phase[0]
    return np.polynomial.legendre.legvander(2.0 * (phase - phase[0]) / length - 1.0, int(length) + DRIFT_DEGREE)


def _wave(phase: Floats, period: Period) -> Floats:
    """Returns cosine and sine of a period at phases [F], in columns [F, 2]."""
    angle = 2.0 * np.pi * period * phase
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
