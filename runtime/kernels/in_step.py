"""Which whole cycles bring an action to a moment of one's choice.

Clips are given by number; numbers and times may be arrays, of many characters at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import IN_STEP

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
