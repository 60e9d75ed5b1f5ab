"""The clocks of locomotions: gaits of a mix in step, others at their own speed; and the root motion of both."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import BEFORE, PASSED, REACHED, ROUNDS, SLOT, STANDS, Ground
from motionsplice.runtime.characters.feet_kernels import NOTHING, Sums, add_step, feet_at, step_of
from motionsplice.runtime.characters.slots import locomotion_slot
from motionsplice.runtime.characters.transition_kernels import in_turned_frame, keep_place, keep_turn, path_at
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import frame_after_last
from motionsplice.runtime.kernels.phase import own_step, phase_of
from motionsplice.runtime.simd.compiled import Array, inlined, kernel

LEAST_STEP = 1e-12  # cycles: at nearly no speed, a step is lost in the rounding of its phase
AGAIN = 0.3  # seconds: fade of a clip into its own beginning, if it has no loop


@inlined
def begin_in_step(bank: BankArrays, s: Array, c: int, k: int, ahead: float, clock: Array, slots: int) -> int:
    """Finds the cycles that the gaits of a mix advance together in `ahead` seconds, and the phase that each reaches.

    Puts the cycles, 0 without a mix, and the gaits into the clock; returns how many slots it then has.
    """
    count, clock[PASSED + k] = int(s[c + col.LOCOMOTIONS]), 0.0
    if count > 1:
        clock[PASSED + k] = common_step(bank, s, c, count, ahead)
        for number in range(count):
            slot = locomotion_slot(c, number)
            clip = int(s[slot + col.CLIP])
            if bank.clips[clip, arrays.GAIT] > 0.0:
                loop, _ = end_of(bank, s, slot)
                reached, end = s[slot + col.PHASE] + clock[PASSED + k], bank.clips[clip, arrays.LAST_PHASE]
                rounds = np.ceil((reached - end) / loop) if loop > 0.0 and reached > end else 0.0
                reached -= rounds * loop
                clock[SLOT + slots], clock[REACHED + slots] = slot, reached
                clock[BEFORE + slots], clock[ROUNDS + slots] = s[slot + col.FRAME], rounds
                slots += 1
    return slots


@inlined
def advance_locomotions(
    bank: BankArrays, ground: Ground, s: Array, c: int, k: int, seconds: float, clock: Array, slots: int
) -> tuple[int, Sums, Sums]:
    """Advances phases and frames, and sets the root motion that the clips mix to.

    Frames of gaits in a mix are those in the clock. A gait alone sets the cycles that it advances there. Returns the
    number of the next slot in the clock; and if feet may stand, the sums of the left and the right foot.
    """
    count, ahead, stand = int(s[c + col.LOCOMOTIONS]), seconds * s[c + col.SPEED], clock[STANDS + k] > 0.0
    x = y = z = turn = 0.0
    lefts, rights = NOTHING, NOTHING
    for number in range(count):
        slot = locomotion_slot(c, number)
        clip, rate = int(s[slot + col.CLIP]), bank.clips[int(s[slot + col.CLIP]), arrays.RATE]
        loop, last = end_of(bank, s, slot)
        if count > 1 and bank.clips[clip, arrays.GAIT] > 0.0:
            before, rounds, after = clock[BEFORE + slots], clock[ROUNDS + slots], min(s[slot + col.FRAME], last)
            slots += 1
        else:
            before, phase, rounds = s[slot + col.FRAME], s[slot + col.PHASE], 0.0
            after = before + ahead * rate
            if after > last and loop > 0.0:
                lasting = last - frame_after_last(bank, clip)
                rounds = np.ceil((after - last) / lasting)
                after -= rounds * lasting
            after = min(max(after, 0.0), last)  # after millions of loops `rounds * lasting` is not exact
            s[slot + col.PHASE] = phase_of(bank, clip, after)
            if count == 1 and bank.clips[clip, arrays.GAIT] > 0.0:
                clock[PASSED + k] = s[slot + col.PHASE] - phase + rounds * loop
        s[slot + col.FRAME] = after
        if loop == 0.0:
            end_locomotion(s, c, number, before, after, last, rate)
        dx, dy, dz, dh = travelled(bank, ground, s, slot, rounds)
        share = s[slot + col.SHARE]
        x, y, z, turn = x + share * dx, y + share * dy, z + share * dz, turn + share * dh
        if stand:
            own, was, now = step_of(dx, dz, dh), feet_at(bank, ground, clip, before), feet_at(bank, ground, clip, after)
            lefts = add_step(share, was[0], now[0], own, lefts)
            rights = add_step(share, was[1], now[1], own, rights)
    s[c + col.DELTA], s[c + col.DELTA + 1], s[c + col.DELTA + 2], s[c + col.DELTA + 3] = x, y, z, turn
    return slots, lefts, rights


@inlined
def end_of(bank: BankArrays, s: Array, slot: int) -> tuple[float, float]:
    """Returns the strides by which a slot's clip jumps back at its end, 0 if it is held, and its last frame."""
    clip = int(s[slot + col.CLIP])
    if s[slot + col.LOOP] == 0.0 or bank.clips[clip, arrays.LOOP] == 0.0:
        return 0.0, bank.clips[clip, arrays.FRAME_COUNT] - 1.0
    return bank.clips[clip, arrays.LOOP], bank.clips[clip, arrays.ROW_COUNT] - 1.0


@inlined
def common_step(bank: BankArrays, s: Array, c: int, count: int, ahead: float) -> float:
    """Returns the cycles that all gaits advance together, so that on average they play as fast as captured.

    Clips that are held at their end do not count. The seconds per cycle are averaged, not the cycles per second, as in
    Kovar and Gleicher's registration curves (2003, section 4): so a clip whose phase hardly moves for a moment is not
    rushed through this moment by the others.
    """
    gaits = times = 0.0
    for number in range(count):
        slot = locomotion_slot(c, number)
        clip, frame = int(s[slot + col.CLIP]), s[slot + col.FRAME]
        loop, last = end_of(bank, s, slot)
        if bank.clips[clip, arrays.GAIT] > 0.0 and (loop > 0.0 or frame < last):
            gaits += s[slot + col.SHARE]
            times += s[slot + col.SHARE] / max(own_step(bank, clip, frame, s[slot + col.PHASE], ahead), LEAST_STEP)
    return gaits / times if gaits > 0.0 and ahead > 0.0 else 0.0


@kernel
def end_locomotion(s: Array, c: int, number: int, before: float, after: float, last: float, rate: float) -> None:
    """Handles the end of a clip without a seam: holds the last frame, or crossfades the group into its start."""
    slot = locomotion_slot(c, number)
    if s[slot + col.LOOP] == 0.0:
        if before < last and after >= last:
            s[c + col.EVENTS] = int(s[c + col.EVENTS]) | col.LOCOMOTION_ENDED
        return
    head = number
    while s[locomotion_slot(c, head) + col.HEAD] == 0.0:
        head -= 1
    size = int(s[locomotion_slot(c, head) + col.HEAD])
    newest = head + size == int(s[c + col.LOCOMOTIONS])
    if newest and s[c + col.NEXT_COUNT] == 0.0 and last - after <= AGAIN * rate * s[c + col.SPEED]:
        for one in range(size):
            s[c + col.NEXT_CLIPS + one] = s[locomotion_slot(c, head + one) + col.CLIP]
            s[c + col.NEXT_WEIGHTS + one] = s[locomotion_slot(c, head + one) + col.GOAL]
        s[c + col.NEXT_COUNT], s[c + col.NEXT_TIME], s[c + col.NEXT_LOOP] = size, 0.0, 1.0
        s[c + col.NEXT_LASTING], s[c + col.NEXT_CURVE] = AGAIN, col.SMOOTH


@inlined
def travelled(
    bank: BankArrays, ground: Ground, s: Array, slot: int, rounds: float
) -> tuple[float, float, float, float]:
    """Returns the root motion x, y, z and turn from the path kept in a slot to its new frame, `rounds` loops later.

    It is relative to the old place and heading. Keeps the new path in the slot.
    """
    x0, y0, z0, h0 = s[slot + col.PATH], s[slot + col.PATH + 1], s[slot + col.PATH + 2], s[slot + col.PATH + 3]
    sin, cos = s[slot + col.PATH_SIN], s[slot + col.PATH_COS]
    x = y = z = turn = 0.0
    if rounds > 0.0:
        clip = int(s[slot + col.CLIP])
        x1, y1, z1, h1 = path_at(bank, ground, clip, bank.clips[clip, arrays.ROW_COUNT] - 1.0)
        x, z = in_turned_frame(sin, cos, x1 - x0, z1 - z0)
        y, turn = y1 - y0, h1 - h0
        x0, y0, z0, h0 = path_at(bank, ground, clip, frame_after_last(bank, clip))
        if rounds > 1.0:
            times, half = rounds - 1.0, 0.5 * (h1 - h0)
            half -= math.pi * np.round(half / math.pi)  # whole turns do not matter, but rounding near them would
            # a sum of equal steps, each turned by 2 half from the one before: it points as the middle one does
            middle = 0.5 * (h0 - turn) - 0.5 * (times - 1.0) * half
            size = math.sin(times * half) / math.sin(half) if half != 0.0 else times
            dx, dz = in_turned_frame(math.sin(middle), math.cos(middle), x1 - x0, z1 - z0)
            x, y, z, turn = x + size * dx, y + times * (y1 - y0), z + size * dz, turn + times * (h1 - h0)
        sin, cos = math.sin(0.5 * (h0 - turn)), math.cos(0.5 * (h0 - turn))
    heading = s[slot + col.PATH + 3]
    keep_place(bank, ground, s, slot)
    if s[slot + col.PATH + 3] != heading:
        keep_turn(s, slot)
    dx, dz = in_turned_frame(sin, cos, s[slot + col.PATH] - x0, s[slot + col.PATH + 2] - z0)
    return x + dx, y + s[slot + col.PATH + 1] - y0, z + dz, turn + s[slot + col.PATH + 3] - h0
