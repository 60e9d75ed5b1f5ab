"""The clocks of actions: in step with the gaits, or at their own speed."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import REACHED, SLOT
from motionsplice.runtime.characters.slots import OFFSET, action_slot, locomotion_slot
from motionsplice.runtime.characters.transition_kernels import UNKNOWN, hand_over, is_own_clock, leave_action
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import NAIVE, SPLICE, frame_of
from motionsplice.runtime.kernels.phase import own_step
from motionsplice.runtime.simd.compiled import Array, inlined

CATCH_UP = 0.3  # share of the locomotion's speed by which an action out of step is faster or slower
MOST_PACE = 1.75  # times its captured speed: the most that an action plays at to be in step


@inlined
def advance_actions(bank: BankArrays, s: Array, c: int, seconds: float, passed: float, clock: Array, slots: int) -> int:
    """Advances all actions of a character. Puts spliced ones into the clock; returns how many slots it then has.

    They follow the gaits in step, blended with their own clock by the share of locomotions without a gait. Frames of
    spliced actions are left to `set_frames`.
    """
    count, ahead = int(s[c + col.ACTIONS]), seconds * s[c + col.SPEED]
    if count > 0:
        gaits, phase = 0.0, UNKNOWN
        for number in range(int(s[c + col.LOCOMOTIONS])):
            slot = locomotion_slot(c, number)
            if bank.clips[int(s[slot + col.CLIP]), arrays.GAIT] > 0.0:
                gaits, phase = gaits + s[slot + col.SHARE], s[slot + col.PHASE]
        for number in range(count):
            slot = action_slot(c, number)
            if s[slot + col.KIND] == SPLICE:
                reached = phase_reached(bank, s, slot, ahead, passed, min(gaits, 1.0), phase)
                clock[SLOT + slots], clock[REACHED + slots] = slot, reached
                slots += 1
            elif s[slot + col.KIND] == NAIVE:
                s[slot + col.FRAME] += ahead * bank.clips[int(s[slot + col.CLIP]), arrays.RATE]
    return slots


@inlined
def phase_reached(
    bank: BankArrays, s: Array, slot: int, ahead: float, passed: float, gaits: float, phase: float
) -> float:
    """Returns the phase that a spliced action reaches; `passed` are the cycles that the gaits advanced, `gaits` their
    share.

    It plays at MOST_PACE at most, unless it is told to follow the legs at any pace: so it falls behind them where they
    hurry it, and catches up where they do not.
    """
    clip, frame, reached = int(s[slot + col.CLIP]), s[slot + col.FRAME], s[slot + col.PHASE]
    own = own_step(bank, clip, frame, reached, ahead)
    if gaits == 0.0 or is_own_clock(s, slot, frame):
        reached += own
    else:
        phase_error = reached - phase + passed
        phase_error -= np.round(phase_error)
        in_step = passed - min(max(phase_error, -CATCH_UP * passed), CATCH_UP * passed)
        if s[slot + col.OWN_TO] != col.ANY_PACE:
            in_step = min(in_step, own_step(bank, clip, frame, reached, MOST_PACE * ahead))
        reached += gaits * in_step + (1.0 - gaits) * own
    end, loop = bank.clips[clip, arrays.LAST_PHASE], bank.clips[clip, arrays.LOOP]
    if s[slot + col.LOOP] > 0.0 and loop > 0.0 and reached > end:
        reached -= loop * np.ceil((reached - end) / loop)
    return reached


@inlined
def set_frames(bank: BankArrays, s: Array, clock: Array, first: int, stop: int) -> None:
    """Sets phases and frames of slots in the clock."""
    for number in range(first, stop):
        slot, reached = int(clock[SLOT + number]) & OFFSET, clock[REACHED + number]
        s[slot + col.PHASE], s[slot + col.FRAME] = reached, frame_of(bank, int(s[slot + col.CLIP]), reached)


@inlined
def end_actions(bank: BankArrays, s: Array, c: int, count: int, seconds: float) -> None:
    """Fades out the newest action near its end, or lets the next stretch of a hybrid take over.

    If the action should loop but its clip has no seam, crossfades it into its own start.
    """
    slot = action_slot(c, count - 1)
    clip, kind = int(s[slot + col.CLIP]), s[slot + col.KIND]
    if kind == col.OWN or s[slot + col.LEAVING] > 0.0 or count == col.MOST_ACTIONS:
        return
    if s[slot + col.LEAVING] == col.PLAYS_ON and bank.clips[clip, arrays.NEXT_STRETCH] >= 0.0:
        if s[slot + col.FRAME] >= bank.clips[clip, arrays.LEAVES]:
            hand_over(bank, s, c, slot)
        return
    goes_on = s[slot + col.LOOP] > 0.0
    if goes_on and (kind == NAIVE or bank.clips[clip, arrays.LOOP] > 0.0):
        return
    left = (bank.clips[clip, arrays.FRAME_COUNT] - 1.0 - s[slot + col.FRAME]) / bank.clips[clip, arrays.RATE]
    fading = s[slot + col.FADING_OUT]
    if left > max(fading * s[c + col.SPEED], seconds * s[c + col.SPEED]):
        return
    if not goes_on:
        leave_action(s, c, slot, fading)
    elif s[c + col.WHEN] == col.NEVER:
        for column in range(col.ACTION_COLUMNS):
            s[c + col.NEXT_ACTION + column] = s[slot + column]
        s[c + col.NEXT_ACTION + col.PHASE] = bank.clips[clip, arrays.FIRST_PHASE]
        s[c + col.NEXT_ACTION + col.FRAME] = 0.0
        s[c + col.NEXT_ACTION + col.LASTING], s[c + col.WHEN] = fading, col.NOW
