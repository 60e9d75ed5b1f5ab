"""Which whole cycles bring an action to a moment of one's choice, and a locomotion from its end back into itself.

Clips are given by number; numbers and times may be arrays, of many characters at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from runtime import arrays
from runtime.arrays import BankArrays
from runtime.bank import Bank
from runtime.lookup_kernels import IN_STEP

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Seconds = float | Floats
Clips = int | NDArray[np.integer]


def phase_at(bank: BankArrays, clip: Clips, seconds: Seconds) -> Floats:
    """The phase of a clip at a time of its own frames, cycles of the baseline; its ends' beyond them."""
    columns = bank.clips[clip]
    count = columns[..., arrays.FRAME_COUNT]
    at = np.clip(np.multiply(seconds, columns[..., arrays.RATE]), 0.0, count - 1.0)
    before = np.minimum(np.floor(at), count - 2.0)
    row = (columns[..., arrays.FIRST_ROW] + before).astype(np.int64)
    return np.asarray(bank.phases[row] + (at - before) * (bank.phases[row + 1] - bank.phases[row]))


def cycles_to(bank: BankArrays, locomotion: Clips, time: Seconds, action: Clips, phase: Seconds) -> Ints:
    """The `cycles` of a request without `start` whose action, when the locomotion is at `time`, is in step and at
    `phase` or less than a cycle after it."""
    wanted = np.ceil(phase - phase_at(bank, locomotion, time) - IN_STEP)
    return np.asarray(wanted - _cycles_from_the_first_frame(bank, locomotion, action), np.int64)


def action_phase(
    bank: BankArrays, locomotion: Clips, time: Seconds, action: Clips, cycles: int | NDArray[np.integer]
) -> Floats:
    """Where the action of such a request is, cycles of the baseline: beyond its last phase if it repeats."""
    first = _cycles_from_the_first_frame(bank, locomotion, action)
    return np.asarray(phase_at(bank, locomotion, time) + first + cycles)


def _cycles_from_the_first_frame(bank: BankArrays, locomotion: Clips, action: Clips) -> Floats:
    first = bank.clips[..., arrays.FIRST_PHASE]
    return np.asarray(np.ceil(first[action] - first[locomotion] - IN_STEP))


class WaysBack(NamedTuple):
    """Where each locomotion of a bank goes on when it is at its end: at times [C], seconds, cycles [C] earlier."""

    times: Floats
    cycles: Ints

    @classmethod
    def of(cls, bank: Bank) -> WaysBack:
        """By whole strides that are alike, so that it goes on as it stopped; to its beginning if it has none."""
        times, cycles = np.zeros(len(bank.clips)), np.zeros(len(bank.clips), np.int64)
        for number, entry in enumerate(bank.clips):
            phases = bank.phase(entry.name)
            back = phases[-1] - entry.loop
            if entry.loop > 0 and back >= phases[0]:
                after = min(max(int(np.searchsorted(phases, back)), 1), len(phases) - 1)
                part = (back - phases[after - 1]) / (phases[after] - phases[after - 1])
                times[number], cycles[number] = (after - 1 + part) / entry.rate, entry.loop
            else:
                cycles[number] = round(phases[-1] - phases[0])
        return cls(times, cycles)
