"""A clip's phase and its frames: one from the other, and how far a clip goes on by itself."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import between, frame_at, frame_near, locate
from motionsplice.runtime.simd.compiled import inlined


@inlined
def row_of(bank: BankArrays, clip: int, frame: float) -> tuple[np.uint64, float]:
    """The row before a real-valued frame of a clip, its seam's among them, and how far past it."""
    return locate(frame, bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT])


@inlined
def phase_of(bank: BankArrays, clip: int, frame: float) -> float:
    """A clip's phase at a frame."""
    row, t = row_of(bank, clip, frame)
    return between(bank.phases, row, t)


@inlined
def frame_of(bank: BankArrays, clip: int, phase: float) -> float:
    """A clip's real-valued frame at a phase; its ends' beyond them."""
    last = bank.clips[clip, arrays.ROW_COUNT] - 1.0
    return min(max(frame_at(bank, clip, phase, frame_near(bank, clip, phase)), 0.0), last)


@inlined
def frame_after_last(bank: BankArrays, clip: int) -> float:
    """The frame at which a clip with a loop goes on after its last one."""
    return frame_of(bank, clip, bank.clips[clip, arrays.LAST_PHASE] - bank.clips[clip, arrays.LOOP])


@inlined
def own_step(bank: BankArrays, clip: int, frame: float, phase: float, ahead: float) -> float:
    """Cycles that a clip goes on by itself in so many seconds from a frame, whose phase is given; past its end as its
    loop does, or as its last frames did."""
    after, last = frame + ahead * bank.clips[clip, arrays.RATE], bank.clips[clip, arrays.ROW_COUNT] - 1.0
    if after <= last:
        return phase_of(bank, clip, after) - phase
    to_end, beyond = bank.clips[clip, arrays.LAST_PHASE] - phase, after - last
    if bank.clips[clip, arrays.LOOP] == 0.0:
        return to_end + bank.clips[clip, arrays.LAST_PHASE] - phase_of(bank, clip, last - beyond)
    again = frame_after_last(bank, clip)
    return to_end + phase_of(bank, clip, again + beyond) - phase_of(bank, clip, again)
