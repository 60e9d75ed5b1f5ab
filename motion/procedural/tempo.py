"""Tempo: phase as a function of time, including changes from one gait to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion.procedural.path import ease
from motionsplice.motion.quaternion import Floats

_ROUNDS = 8  # of Newton's method, each of which doubles the correct digits


def _eased(t: Floats) -> Floats:
    """Returns the integral of `ease` from 0 to `t`."""
    within = np.clip(t, 0.0, 1.0)
    return within**4 * (2.5 + within * (within - 3.0)) + np.maximum(t - 1.0, 0.0)


@dataclass(frozen=True)
class Change:
    """A change to another gait from phase `begin`, within `lasting` cycles, and back again from phase `back`."""

    begin: float = np.inf
    lasting: float = 1.0
    back: float = np.inf

    def weight(self, phase: Floats) -> Floats:
        """Returns the weight [n] of the second gait at phases [n], from 0 to 1."""
        return ease((phase - self.begin) / self.lasting) - ease((phase - self.back) / self.lasting)

    def total(self, phase: Floats) -> Floats:
        """Returns the integral [n] of `weight` up to phases [n]."""
        return self.lasting * (_eased((phase - self.begin) / self.lasting) - _eased((phase - self.back) / self.lasting))


@dataclass(frozen=True)
class Tempo:
    """Strides of `period` seconds that change to `other` seconds by `change`; time 0 is at phase `start`."""

    start: float
    period: float
    other: float
    change: Change

    def along(self, value: float, other: float, phase: Floats) -> Floats:
        """Returns the total [n], from time 0 to phases [n], of `value` per stride, or `other` in the second gait."""
        changed = self.change.total(phase) - self.change.total(np.array(self.start))
        return value * (phase - self.start) + (other - value) * changed

    def time(self, phase: Floats) -> Floats:
        """Returns the times [n] in seconds of phases [n]."""
        return self.along(self.period, self.other, phase)

    def phase(self, time: Floats) -> Floats:
        """Returns the phase [n], in cycles from the left heel strike, strictly increasing, at times [n] in seconds."""
        phase = time / self.period + self.start
        if self.other == self.period:
            return phase
        for _ in range(_ROUNDS):
            pace = self.period + (self.other - self.period) * self.change.weight(phase)
            phase = phase - (self.time(phase) - time) / pace
        return phase

    def weight(self, time: Floats) -> Floats:
        """Returns the weight [n] of the second gait at times [n]."""
        return self.change.weight(self.phase(time))
