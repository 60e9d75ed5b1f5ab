"""When which step is taken: phase as a function of time, also where one gait gives way to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion.procedural.path import ease
from motionsplice.motion.quaternion import Floats

_ROUNDS = 8  # of Newton's method, which doubles its digits in each


def _eased(t: Floats) -> Floats:
    """The integral of `ease` from 0 to `t`."""
    within = np.clip(t, 0.0, 1.0)
    return within**4 * (2.5 + within * (within - 3.0)) + np.maximum(t - 1.0, 0.0)


@dataclass(frozen=True)
class Change:
    """One gait gives way to another from phase `begin` on, within `lasting` cycles; from `back` on, it comes back."""

    begin: float = np.inf
    lasting: float = 1.0
    back: float = np.inf

    def weight(self, phase: Floats) -> Floats:
        """How far [n] the first gait has given way at phases [n]: from 0 to 1."""
        return ease((phase - self.begin) / self.lasting) - ease((phase - self.back) / self.lasting)

    def total(self, phase: Floats) -> Floats:
        """The integral [n] of `weight` up to phases [n]."""
        return self.lasting * (_eased((phase - self.begin) / self.lasting) - _eased((phase - self.back) / self.lasting))


@dataclass(frozen=True)
class Tempo:
    """Strides from phase `start` at time 0: of `period` seconds, then of `other`, as `change` says."""

    start: float
    period: float
    other: float
    change: Change

    def along(self, value: float, other: float, phase: Floats) -> Floats:
        """What has come together [n] from time 0 to phases [n] at `value` a stride, then at `other`."""
        changed = self.change.total(phase) - self.change.total(np.array(self.start))
        return value * (phase - self.start) + (other - value) * changed

    def time(self, phase: Floats) -> Floats:
        """The seconds [n] at which phases [n] are reached."""
        return self.along(self.period, self.other, phase)

    def phase(self, time: Floats) -> Floats:
        """The phase [n] in cycles from the left heel strike, strictly growing, at times [n] in seconds."""
        phase = time / self.period + self.start
        if self.other == self.period:
            return phase
        for _ in range(_ROUNDS):
            pace = self.period + (self.other - self.period) * self.change.weight(phase)
            phase = phase - (self.time(phase) - time) / pace
        return phase

    def weight(self, time: Floats) -> Floats:
        """How far [n] the first gait has given way at times [n]."""
        return self.change.weight(self.phase(time))
