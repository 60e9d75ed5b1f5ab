"""A character's clock: phases, fades, root motion and events, from one frame to the next.

As `runtime.kernels`: nothing here checks, allocates or holds the GIL, and a step takes constant time.
"""

from __future__ import annotations

import math

import numpy as np

from runtime import arrays
from runtime import character_state as col
from runtime.arrays import BankArrays, Ground
from runtime.compiled import Array, inlined, kernel
from runtime.contacts import LEFT_FOOT, RIGHT_FOOT
from runtime.lookup_kernels import NAIVE, SPLICE, between, locate
from runtime.rotation_kernels import ONE
from runtime.transition_kernels import (
    UNKNOWN,
    action,
    begin_waiting,
    drop_actions,
    faded,
    frame_of,
    is_own_clock,
    leave_action,
    locomotion,
    phase_of,
    reference,
    share_locomotions,
)

SMOOTHING = 0.05  # seconds: each of two time constants with which weights follow what they are set to
CATCH_UP = 0.3  # of the locomotion's speed, by which an action out of step is faster or slower until it is in step
AGAIN = 0.3  # seconds of the fade into itself of a clip that has no two strides alike


@kernel
def begin(bank: BankArrays, states: Array, rows: Array) -> None:
    """Begins what characters [n] wait for, as far as that need not wait."""
    for row in rows:
        begin_waiting(bank, states[row], 0.0, 0)


@kernel
def advance(bank: BankArrays, ground: Ground, states: Array, seconds: float) -> int:
    """Moves characters on in time; returns all bits of events that happened to any of them."""
    happened, follow = 0, 1.0 - math.exp(-seconds / SMOOTHING)
    for number in range(len(states)):
        s = states[number]
        s[col.EVENTS] = 0.0
        fade(s, seconds, follow)
        passed = advance_locomotions(bank, ground, s, seconds)
        advance_actions(bank, s, seconds, passed)
        downs = step(bank, ground, s, passed)
        if s[col.NEXT_COUNT] > 0.0 or s[col.WHEN] > col.NEVER:
            begin_waiting(bank, s, passed, downs)
        happened |= int(s[col.EVENTS])
    return happened


@inlined
def fade(s: Array, seconds: float, follow: float) -> None:
    """All fades and weights of a character, `follow` of the way to what they are set to."""
    count = int(s[col.LOCOMOTIONS])
    if count > 1:
        for number in range(count):
            slot = locomotion(number)
            s[slot + col.ELAPSED] += seconds
            s[slot + col.LAGGING] += follow * (s[slot + col.GOAL] - s[slot + col.LAGGING])
            s[slot + col.WEIGHT] += follow * (s[slot + col.LAGGING] - s[slot + col.WEIGHT])
        share_locomotions(s)
    for number in range(int(s[col.ACTIONS])):
        slot = action(number)
        s[slot + col.ELAPSED] += seconds
        s[slot + col.LAGGING] += follow * (s[slot + col.GOAL] - s[slot + col.LAGGING])
        s[slot + col.WEIGHT] += follow * (s[slot + col.LAGGING] - s[slot + col.WEIGHT])
    if s[col.ACTIONS] > 1.0 or (s[col.ACTIONS] > 0.0 and s[col.FIRST_ACTION + col.KIND] == col.OWN):
        drop_actions(s)


@inlined
def advance_locomotions(bank: BankArrays, ground: Ground, s: Array, seconds: float) -> float:
    """Phases, frames and root motion; returns how many cycles the gaits went on, 0 if there is none."""
    count, ahead = int(s[col.LOCOMOTIONS]), seconds * s[col.SPEED]
    passed = gaits = 0.0
    if count > 1:
        for number in range(count):
            slot = locomotion(number)
            clip = int(s[slot + col.CLIP])
            if bank.clips[clip, arrays.GAIT] > 0.0:
                gaits += s[slot + col.SHARE]
                passed += s[slot + col.SHARE] * ahead * tempo(bank, clip, s[slot + col.FRAME])
        passed = passed / gaits if gaits > 0.0 else 0.0
    x = y = z = turn = 0.0
    for number in range(count):
        slot = locomotion(number)
        clip, before = int(s[slot + col.CLIP]), s[slot + col.FRAME]
        rate, phase = bank.clips[clip, arrays.RATE], s[slot + col.PHASE]
        loop, last = bank.clips[clip, arrays.LOOP], bank.clips[clip, arrays.ROW_COUNT] - 1.0
        if s[slot + col.LOOP] == 0.0 or loop == 0.0:
            loop, last = 0.0, bank.clips[clip, arrays.FRAME_COUNT] - 1.0
        if count > 1 and bank.clips[clip, arrays.GAIT] > 0.0:
            reached = phase + passed
            end = bank.clips[clip, arrays.LAST_PHASE]
            rounds = np.ceil((reached - end) / loop) if loop > 0.0 and reached > end else 0.0
            reached -= rounds * loop
            after = min(frame_of(bank, clip, reached), last)
        else:
            after, rounds, back = before + ahead * rate, 0.0, 0.0
            if after > last and loop > 0.0:
                back = frame_of(bank, clip, bank.clips[clip, arrays.LAST_PHASE] - loop)
                rounds = np.ceil((after - last) / (last - back))
                after -= rounds * (last - back)
            after = min(after, last)
            reached = phase_of(bank, clip, after)
            if count == 1 and bank.clips[clip, arrays.GAIT] > 0.0:
                passed = reached - phase + rounds * loop
        s[slot + col.PHASE], s[slot + col.FRAME] = reached, after
        if loop == 0.0:
            end_locomotion(s, number, before, after, last, rate)
        dx, dy, dz, dh = travelled(bank, ground, clip, before, after, rounds)
        share = s[slot + col.SHARE]
        x, y, z, turn = x + share * dx, y + share * dy, z + share * dz, turn + share * dh
    cos, sin = math.cos(s[col.HEADING]), math.sin(s[col.HEADING])
    s[col.PLACE] += cos * x + sin * z
    s[col.PLACE + 1] += y
    s[col.PLACE + 2] += cos * z - sin * x
    s[col.HEADING] += turn
    s[col.DELTA], s[col.DELTA + 1], s[col.DELTA + 2], s[col.DELTA + 3] = x, y, z, turn
    return passed


@inlined
def tempo(bank: BankArrays, clip: int, frame: float) -> float:
    """Cycles a second of a clip at a frame."""
    row, _ = locate(frame, bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT])
    return (bank.phases[row + ONE] - bank.phases[row]) * bank.clips[clip, arrays.RATE]


@inlined
def end_locomotion(s: Array, number: int, before: float, after: float, last: float, rate: float) -> None:
    """What becomes of a clip that does not go on by itself: it is held, or its group begins again over itself."""
    slot = locomotion(number)
    if s[slot + col.LOOP] == 0.0:
        if before < last and after >= last:
            s[col.EVENTS] = int(s[col.EVENTS]) | col.LOCOMOTION_ENDED
        return
    head = number
    while s[locomotion(head) + col.HEAD] == 0.0:
        head -= 1
    size = int(s[locomotion(head) + col.HEAD])
    newest = head + size == int(s[col.LOCOMOTIONS])
    if newest and s[col.NEXT_COUNT] == 0.0 and last - after <= AGAIN * rate * s[col.SPEED]:
        for one in range(size):
            s[col.NEXT_CLIPS + one] = s[locomotion(head + one) + col.CLIP]
            s[col.NEXT_WEIGHTS + one] = s[locomotion(head + one) + col.GOAL]
        s[col.NEXT_COUNT], s[col.NEXT_TIME], s[col.NEXT_LOOP] = size, 0.0, 1.0
        s[col.NEXT_LASTING], s[col.NEXT_CURVE] = AGAIN, col.SMOOTH


@inlined
def travelled(
    bank: BankArrays, ground: Ground, clip: int, before: float, after: float, rounds: float
) -> tuple[float, float, float, float]:
    """The way from one frame of a clip to another, `rounds` of its loop later, as seen from where it began."""
    if rounds == 0.0:
        return leg(bank, ground, clip, before, after)
    last = bank.clips[clip, arrays.ROW_COUNT] - 1.0
    back = frame_of(bank, clip, bank.clips[clip, arrays.LAST_PHASE] - bank.clips[clip, arrays.LOOP])
    x, y, z, turn = leg(bank, ground, clip, before, last)
    for number in range(int(rounds)):
        dx, dy, dz, dh = leg(bank, ground, clip, back, after if number == int(rounds) - 1 else last)
        cos, sin = math.cos(turn), math.sin(turn)
        x, y, z, turn = x + cos * dx + sin * dz, y + dy, z + cos * dz - sin * dx, turn + dh
    return x, y, z, turn


@inlined
def leg(
    bank: BankArrays, ground: Ground, clip: int, before: float, after: float
) -> tuple[float, float, float, float]:
    """The same within a clip."""
    x0, y0, z0, h0 = way(bank, ground, clip, before)
    x1, y1, z1, h1 = way(bank, ground, clip, after)
    cos, sin, dx, dz = math.cos(h0), math.sin(h0), x1 - x0, z1 - z0
    return cos * dx - sin * dz, y1 - y0, cos * dz + sin * dx, h1 - h0


@inlined
def way(bank: BankArrays, ground: Ground, clip: int, frame: float) -> tuple[float, float, float, float]:
    """A clip's path at a frame."""
    row, t = locate(frame, bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT])
    here, there = ground.paths[row], ground.paths[row + ONE]
    return (
        here[0] + t * (there[0] - here[0]),
        here[1] + t * (there[1] - here[1]),
        here[2] + t * (there[2] - here[2]),
        here[3] + t * (there[3] - here[3]),
    )


@inlined
def advance_actions(bank: BankArrays, s: Array, seconds: float, passed: float) -> None:
    """The phases and frames of all actions: with the gaits, or by their own clock as far as there are none."""
    count = int(s[col.ACTIONS])
    if count > 0:
        gaits, phase = 0.0, UNKNOWN
        for number in range(int(s[col.LOCOMOTIONS])):
            slot = locomotion(number)
            if bank.clips[int(s[slot + col.CLIP]), arrays.GAIT] > 0.0:
                gaits, phase = gaits + s[slot + col.SHARE], s[slot + col.PHASE]
        for number in range(count):
            slot = action(number)
            if s[slot + col.KIND] == SPLICE:
                advance_splice(bank, s, slot, seconds, passed, min(gaits, 1.0), phase)
            elif s[slot + col.KIND] == NAIVE:
                clip = int(s[slot + col.CLIP])
                s[slot + col.FRAME] += seconds * s[col.SPEED] * bank.clips[clip, arrays.RATE]
        end_actions(bank, s, count, seconds)


@inlined
def advance_splice(
    bank: BankArrays, s: Array, slot: int, seconds: float, passed: float, gaits: float, phase: float
) -> None:
    clip, frame, reached = int(s[slot + col.CLIP]), s[slot + col.FRAME], s[slot + col.PHASE]
    own = seconds * s[col.SPEED] * tempo(bank, clip, frame)
    if gaits == 0.0 or is_own_clock(s, slot, frame):
        reached += own
    else:
        astray = reached - phase + passed
        astray -= np.round(astray)
        reached += gaits * (passed - min(max(astray, -CATCH_UP * passed), CATCH_UP * passed)) + (1.0 - gaits) * own
    end, loop = bank.clips[clip, arrays.LAST_PHASE], bank.clips[clip, arrays.LOOP]
    if s[slot + col.LOOP] > 0.0 and loop > 0.0:
        if reached > end:
            reached -= loop * np.ceil((reached - end) / loop)
    s[slot + col.PHASE], s[slot + col.FRAME] = reached, frame_of(bank, clip, reached)


@inlined
def end_actions(bank: BankArrays, s: Array, count: int, seconds: float) -> None:
    """Has the newest action faded out in time before it ends, or begun again over itself."""
    slot = action(count - 1)
    clip, kind = int(s[slot + col.CLIP]), s[slot + col.KIND]
    if kind == col.OWN or s[slot + col.LEAVING] > 0.0 or count == col.MOST_ACTIONS:
        return
    goes_on = s[slot + col.LOOP] > 0.0
    if goes_on and (kind == NAIVE or bank.clips[clip, arrays.LOOP] > 0.0):
        return
    left = (bank.clips[clip, arrays.FRAME_COUNT] - 1.0 - s[slot + col.FRAME]) / bank.clips[clip, arrays.RATE]
    fading = s[slot + col.FADING_OUT]
    if left > max(fading * s[col.SPEED], seconds * s[col.SPEED]):
        return
    if not goes_on:
        leave_action(s, count - 1, fading)
    elif s[col.WHEN] == col.NEVER:
        for column in range(col.ACTION_COLUMNS):
            s[col.NEXT_ACTION + column] = s[slot + column]
        s[col.NEXT_ACTION + col.PHASE], s[col.NEXT_ACTION + col.FRAME] = bank.clips[clip, arrays.FIRST_PHASE], 0.0
        s[col.NEXT_ACTION + col.LASTING], s[col.WHEN] = fading, col.NOW


@inlined
def step(bank: BankArrays, ground: Ground, s: Array, passed: float) -> int:
    """Tells of strides and of feet that come down and go up, by the locomotion that gives most; returns the downs."""
    most = 0
    for number in range(1, int(s[col.LOCOMOTIONS])):
        if s[locomotion(number) + col.SHARE] > s[locomotion(most) + col.SHARE]:
            most = number
    slot = locomotion(most)
    clip, phase = int(s[slot + col.CLIP]), s[slot + col.PHASE]
    row, _ = locate(
        s[slot + col.FRAME], bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT]
    )
    now, before, events = int(ground.contacts[row]), int(s[col.STANDING]), int(s[col.EVENTS])
    downs, ups = now & ~before, before & ~now
    events |= col.LEFT_DOWN if downs & LEFT_FOOT else 0
    events |= col.RIGHT_DOWN if downs & RIGHT_FOOT else 0
    events |= col.LEFT_UP if ups & LEFT_FOOT else 0
    events |= col.RIGHT_UP if ups & RIGHT_FOOT else 0
    events |= col.STRIDE if np.floor(phase) > np.floor(phase - passed) else 0
    s[col.STANDING], s[col.EVENTS] = now, events
    return downs
