"""A curve taken apart by the legs' phase: its trend, its drift, and the wave of each of its strides or steps."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from motionsplice.motion.quaternion import Floats

Complexes = NDArray[np.complex128]

TREND_CUTOFF = 6.0  # waves per stride of which the trend keeps half: of the step's wave it keeps 99 %
DRIFT_DEGREE = 1  # of the drift's polynomial, beside one for each stride: it follows a turn, a start and a stop
SAMPLES = 64  # of a cycle


class Period(IntEnum):
    """In waves per stride: what goes with one leg comes round once, what goes with both comes round twice."""

    STRIDE = 1
    STEP = 2

    def cycles(self, phase: Floats) -> int:
        """How many of it a motion has, to the nearest whole number; phase [F] is in strides."""
        return round(float(phase[-1] - phase[0]) * self)


def trend(curve: Floats, phase: Floats) -> Floats:
    """The trend curve [F] of a curve [F] at phases [F] in strides (thesis 4.1, step 3).

    A smoothing spline in place of the thesis's polynomial: a polynomial must have its degree chosen anew for each
    length of clip. It knows nothing of the legs' period, unlike a sum of that period's waves, so a curve that does
    not go with the legs is drawn as what it is.
    """
    smoothness = (2.0 * np.pi * TREND_CUTOFF) ** -4.0
    return np.asarray(make_smoothing_spline(phase, curve, w=np.gradient(phase), lam=smoothness)(phase))


def drift(curve: Floats, phase: Floats) -> Floats:
    """What of a curve [F] at phases [F] in strides is slower than a stride [F]: a polynomial.

    It is fitted together with the waves: alone it would take its part of those that the clip's ends cut off.
    """
    root = np.sqrt(np.gradient(phase))  # so that every part of the stride counts alike, however fast it passes
    slow = _slow(phase)
    design = np.concatenate([slow, *(_wave(phase, period) for period in Period)], axis=1)
    solution = np.linalg.lstsq(design * root[:, None], curve * root, rcond=None)[0]
    return np.asarray(slow @ solution[: slow.shape[1]])


@dataclass(frozen=True, eq=False)
class CycleWaves:
    """Reads off curves the wave of each of K cycles: strides, or steps.

    A clip is cut into as many equal parts as it has cycles, to the nearest. Drift and the other period's wave are
    taken out of the whole of it beforehand, and in each part a line is fitted with the wave, for no stride is quite
    like the next.

    phase: [K * SAMPLES] strides, evenly spaced. period: whose waves. parts: [K * SAMPLES, m] drift and the other
    period's wave; fit: [m, K * SAMPLES] how much of each there is. readers: [K, 2, SAMPLES] a part's cosine and sine.
    """

    phase: Floats
    period: Period
    parts: Floats
    fit: Floats
    readers: Floats

    @classmethod
    def of(cls, phase: Floats, period: Period) -> CycleWaves:
        """For curves at phases [F] in strides."""
        count = period.cycles(phase)
        even = phase[0] + (np.arange(count * SAMPLES) + 0.5) / (count * SAMPLES) * (phase[-1] - phase[0])
        (other,) = (one for one in Period if one is not period)
        parts = np.concatenate([_slow(even), _wave(even, other)], axis=1)
        fit = np.linalg.pinv(np.concatenate([parts, _wave(even, period)], axis=1))[: parts.shape[1]]
        line = np.tile(np.linspace(-1.0, 1.0, SAMPLES), count)
        columns = np.column_stack([_wave(even, period), np.ones_like(line), line]).reshape(count, SAMPLES, -1)
        return cls(even, period, parts, fit, np.asarray(np.linalg.pinv(columns)[:, :2], np.float64))

    def rest(self, curve: Floats, phase: Floats) -> Floats:
        """A curve [F] at phases [F] without drift and the other period's wave [K, SAMPLES]."""
        even = np.interp(self.phase, phase, curve)
        return np.asarray(even - self.parts @ (self.fit @ even)).reshape(-1, SAMPLES)

    def read(self, rest: Floats) -> Complexes:
        """The cycles' waves [K] in what `rest` gave: size is amplitude, angle where in the cycle they peak."""
        both = np.einsum("kcs,ks->kc", self.readers, rest)
        return np.asarray(both[:, 0] + 1j * both[:, 1])

    def rolled(self, rest: Floats) -> Complexes:
        """What each cut k, rolled by each number of samples s, adds to the waves of all [K, SAMPLES, K].

        Taking out the drift couples the cuts, so that rolling one changes all a little.
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
    length = phase[-1] - phase[0]
    return np.polynomial.legendre.legvander(2.0 * (phase - phase[0]) / length - 1.0, int(length) + DRIFT_DEGREE)


def _wave(phase: Floats, period: Period) -> Floats:
    angle = 2.0 * np.pi * period * phase
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
