"""Converts between frames and phases of a clip, and advances a clip by its own speed."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import between, frame_after_last, locate
from motionsplice.runtime.simd.compiled import inlined


@inlined
def row_of(bank: BankArrays, clip: int, frame: float) -> tuple[np.uint64, float]:
    """Returns the row before a real-valued frame of a clip or its seam, and the share of the next row."""
    return locate(frame, bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT])


@inlined
def phase_of(bank: BankArrays, clip: int, frame: float) -> float:
    """Returns a clip's phase at a frame."""
    row, t = row_of(bank, clip, frame)
    return between(bank.phases, row, t) + bank.clips[clip, arrays.PHASE_SHIFT]


@inlined
def own_step(bank: BankArrays, clip: int, frame: float, phase: float, ahead: float) -> float:
    """Returns the cycles that a clip advances in `ahead` seconds at its own speed, from a frame with a given phase.

    Past its end it advances as its loop does, or as fast as in its last frames if it has no loop.
    """
    after, last = frame + ahead * bank.clips[clip, arrays.RATE], bank.clips[clip, arrays.ROW_COUNT] - 1.0
    if after <= last:
        return phase_of(bank, clip, after) - phase
    to_end, beyond = bank.clips[clip, arrays.LAST_PHASE] - phase, after - last
    if bank.clips[clip, arrays.LOOP] == 0.0:
        return to_end + bank.clips[clip, arrays.LAST_PHASE] - phase_of(bank, clip, last - beyond)
    again = frame_after_last(bank, clip)
    return to_end + phase_of(bank, clip, again + beyond) - phase_of(bank, clip, again)
