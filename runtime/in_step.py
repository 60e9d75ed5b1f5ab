"""Which whole cycles bring an action to a moment of one's choice, and a locomotion from its end back into itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from runtime.bank import Bank
from runtime.lookup_kernels import IN_STEP


def phase_at(bank: Bank, clip: int, seconds: float) -> float:
    """The phase of a clip, by number, at a time of its own frames; cycles of the baseline."""
    entry = bank.clips[clip]
    phases = bank.phase(entry.name)
    return float(np.interp(seconds * entry.rate, np.arange(len(phases)), phases))


def cycles_to(bank: Bank, locomotion: int, time: float, action: int, phase: float) -> int:
    """The `cycles` of a request without `start` whose action, when the locomotion is at `time`, is in step and at
    `phase` or less than a cycle after it."""
    wanted = math.ceil(phase - phase_at(bank, locomotion, time) - IN_STEP)
    return wanted - _cycles_from_the_first_frame(bank, locomotion, action)


def action_phase(bank: Bank, locomotion: int, time: float, action: int, cycles: int) -> float:
    """Where the action of such a request is, cycles of the baseline: beyond its last phase if it repeats."""
    return phase_at(bank, locomotion, time) + _cycles_from_the_first_frame(bank, locomotion, action) + cycles


def _cycles_from_the_first_frame(bank: Bank, locomotion: int, action: int) -> int:
    return math.ceil(bank.clips[action].first_phase - bank.clips[locomotion].first_phase - IN_STEP)


@dataclass(frozen=True)
class WayBack:
    """Where a locomotion goes on when it is at its end: at `time`, seconds, which is `cycles` cycles earlier."""

    time: float
    cycles: int

    @classmethod
    def of(cls, bank: Bank, clip: int) -> WayBack:
        """By whole strides that are alike, so that it goes on as it stopped; to its beginning if it has none."""
        entry, phases = bank.clips[clip], bank.phase(bank.clips[clip].name)
        back = phases[-1] - entry.loop
        if entry.loop > 0 and back >= phases[0]:
            return cls(float(np.interp(back, phases, np.arange(len(phases)))) / entry.rate, entry.loop)
        return cls(0.0, round(phases[-1] - phases[0]))
