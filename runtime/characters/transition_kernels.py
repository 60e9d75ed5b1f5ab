"""Transitions: a new slot begins in step and fades in over older slots; covered slots are dropped.

Every command waits in the row until its moment has come, even if it can begin at once, so `begin_waiting` begins all
transitions.
"""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Ground
from motionsplice.runtime.characters.slots import action_slot, fade_of, hands_slot, locomotion_slot
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import IN_STEP, SPLICE, frame_of, is_mirrored
from motionsplice.runtime.kernels.phase import phase_of, row_of
from motionsplice.runtime.kernels.rotations import ONE
from motionsplice.runtime.kernels.stretches import HANDOVER, shift_of
from motionsplice.runtime.simd.compiled import ZERO, Array, inlined, kernel

UNKNOWN = np.inf  # the phase of a character that plays nothing with a phase


@inlined
def in_turned_frame(sin: float, cos: float, x: float, z: float) -> tuple[float, float]:
    """Returns a vector's x and z in a frame that is turned about Y by twice the angle of sin and cos."""
    cosine, sine = cos * cos - sin * sin, 2.0 * cos * sin
    return cosine * x - sine * z, cosine * z + sine * x


@inlined
def path_at(bank: BankArrays, ground: Ground, clip: int, frame: float) -> tuple[float, float, float, float]:
    """Returns a clip's root path at a frame: x, ground height, z and heading."""
    row, t = row_of(bank, clip, frame)
    x, y, z, h = ground.paths[row, 0], ground.paths[row, 1], ground.paths[row, 2], ground.paths[row, 3]
    after, side = row + ONE, -1.0 if is_mirrored(bank, clip) else 1.0
    return (
        side * (x + t * (ground.paths[after, 0] - x)),
        y + t * (ground.paths[after, 1] - y),
        z + t * (ground.paths[after, 2] - z),
        side * (h + t * (ground.paths[after, 3] - h)),
    )


@inlined
def keep_path(bank: BankArrays, ground: Ground, s: Array, slot: int) -> None:
    """Stores a clip's root path at its frame in its slot."""
    keep_place(bank, ground, s, slot)
    keep_turn(s, slot)


@inlined
def keep_place(bank: BankArrays, ground: Ground, s: Array, slot: int) -> None:
    """Stores place and heading of a clip's root path at its frame, without the heading's sine and cosine."""
    x, y, z, h = path_at(bank, ground, int(s[slot + col.CLIP]), s[slot + col.FRAME])
    s[slot + col.PATH], s[slot + col.PATH + 1], s[slot + col.PATH + 2], s[slot + col.PATH + 3] = x, y, z, h


@inlined
def keep_turn(s: Array, slot: int) -> None:
    """Stores sine and cosine of half the heading that is kept in a slot."""
    half = 0.5 * s[slot + col.PATH + 3]
    s[slot + col.PATH_SIN], s[slot + col.PATH_COS] = math.sin(half), math.cos(half)


@kernel
def reference(bank: BankArrays, s: Array, c: int) -> float:
    """Returns the phase that new slots must be in step with: the newest gait's, else the newest spliced action's."""
    for number in range(int(s[c + col.LOCOMOTIONS]) - 1, -1, -1):
        slot = locomotion_slot(c, number)
        if bank.clips[int(s[slot + col.CLIP]), arrays.GAIT] > 0.0:
            return s[slot + col.PHASE]
    for number in range(int(s[c + col.ACTIONS]) - 1, -1, -1):
        slot = action_slot(c, number)
        if s[slot + col.KIND] == SPLICE and bank.clips[int(s[slot + col.CLIP]), arrays.STANCE] < 0.0:
            return s[slot + col.PHASE]
    return UNKNOWN


@kernel
def in_step(bank: BankArrays, clip: int, start: float, phase: float) -> float:
    """Returns a clip's first phase from `start` on that differs from `phase` by whole cycles, else `start`."""
    if phase == UNKNOWN:
        return start
    found = phase + np.ceil(start - phase - IN_STEP)
    if found > bank.clips[clip, arrays.LAST_PHASE] and found - 1.0 >= bank.clips[clip, arrays.FIRST_PHASE]:
        found -= 1.0  # once is enough, since `found` is less than a cycle after `start`
    return found if found <= bank.clips[clip, arrays.LAST_PHASE] else start


@kernel
def begin_waiting(bank: BankArrays, ground: Ground, s: Array, c: int, passed: float, downs: int) -> None:
    """Begins what is waiting, if its moment has come and a slot is free.

    `passed` are the cycles that the phase has just advanced, `downs` the bits of feet that have just touched down.
    """
    if s[c + col.NEXT_COUNT] > 0.0:
        if s[c + col.NEXT_LASTING] <= 0.0:
            begin_locomotion(bank, ground, s, c, ZERO)
        elif s[c + col.LOCOMOTIONS] + s[c + col.NEXT_COUNT] <= col.MOST_LOCOMOTIONS:
            begin_locomotion(bank, ground, s, c, int(s[c + col.LOCOMOTIONS]))
    if s[c + col.WHEN] > col.NEVER and s[c + col.ACTIONS] < col.MOST_ACTIONS and is_time(bank, s, c, passed, downs):
        begin_action(bank, s, c)
    if s[c + col.HANDS_WAIT] > 0.0 and s[c + col.HANDS] < col.MOST_HANDS:
        begin_hands(s, c)


@kernel
def begin_hands(s: Array, c: int) -> None:
    """Begins the waiting hands, in a slot above all others."""
    slot = hands_slot(c, int(s[c + col.HANDS]))
    for column in range(col.HANDS_COLUMNS):
        s[slot + column] = s[c + col.NEXT_HANDS + column]
    s[c + col.HANDS] += 1.0
    s[c + col.HANDS_WAIT] = 0.0
    drop_hands(s, c)


@kernel
def drop_hands(s: Array, c: int) -> None:
    """Drops hands that are covered by the top slot, and the top slot too if it is BARE."""
    top = hands_slot(c, int(s[c + col.HANDS]) - 1)
    if s[top + col.ELAPSED] >= s[top + col.LASTING]:
        for column in range(col.HANDS_COLUMNS):
            s[c + col.FIRST_HANDS + column] = s[top + column]
        s[c + col.HANDS] = 0.0 if s[c + col.FIRST_HANDS + col.CLIP] == col.BARE else 1.0


@kernel
def begin_locomotion(bank: BankArrays, ground: Ground, s: Array, c: int, first: int) -> None:
    """Begins the waiting group, in the slots from `first` on."""
    count, phase = int(s[c + col.NEXT_COUNT]), reference(bank, s, c)
    for number in range(count):
        slot, clip = locomotion_slot(c, first + number), int(s[c + col.NEXT_CLIPS + number])
        start = phase_of(bank, clip, s[c + col.NEXT_TIME] * bank.clips[clip, arrays.RATE])
        gait = bank.clips[clip, arrays.GAIT] > 0.0
        begun = in_step(bank, clip, start, phase) if gait else start
        if gait and phase == UNKNOWN:
            phase = begun  # without another reference, the group is in step with its first gait
        s[slot + col.CLIP], s[slot + col.PHASE], s[slot + col.FRAME] = clip, begun, frame_of(bank, clip, begun)
        weight = s[c + col.NEXT_WEIGHTS + number]
        s[slot + col.WEIGHT], s[slot + col.LAGGING], s[slot + col.GOAL] = weight, weight, weight
        s[slot + col.ELAPSED], s[slot + col.LASTING] = 0.0, s[c + col.NEXT_LASTING]
        s[slot + col.CURVE], s[slot + col.LOOP] = s[c + col.NEXT_CURVE], s[c + col.NEXT_LOOP]
        s[slot + col.HEAD] = count if number == 0 else 0.0
        keep_path(bank, ground, s, slot)
    is_new = s[c + col.LOCOMOTIONS] == 0.0
    s[c + col.LOCOMOTIONS], s[c + col.NEXT_COUNT] = first + count, 0.0
    share_locomotions(s, c)
    if is_new:  # feet that stand from the beginning do not touch down
        s[c + col.STANDING] = feet_of(bank, ground, s, leading(s, c))


@inlined
def leading(s: Array, c: int) -> int:
    """Returns the slot of the locomotion with the largest share."""
    most = locomotion_slot(c, 0)
    for number in range(1, int(s[c + col.LOCOMOTIONS])):
        if s[locomotion_slot(c, number) + col.SHARE] > s[most + col.SHARE]:
            most = locomotion_slot(c, number)
    return most


@inlined
def feet_of(bank: BankArrays, ground: Ground, s: Array, slot: int) -> int:
    """Returns the bits of the feet that stand at a slot's frame."""
    clip = int(s[slot + col.CLIP])
    row, _ = row_of(bank, clip, s[slot + col.FRAME])
    feet = int(ground.contacts[row])
    if is_mirrored(bank, clip):
        left, right = feet & LEFT_FOOT > 0, feet & RIGHT_FOOT > 0
        return (RIGHT_FOOT if left else 0) | (LEFT_FOOT if right else 0)
    return feet


@kernel
def is_time(bank: BankArrays, s: Array, c: int, passed: float, downs: int) -> bool:
    """Whether the moment of the waiting action has come."""
    when, phase = s[c + col.WHEN], reference(bank, s, c)
    if when == col.NOW or phase == UNKNOWN:
        return True
    if when == col.IN_PHASE:
        start = s[c + col.NEXT_ACTION + col.PHASE]
        return np.floor(phase - start + IN_STEP) > np.floor(phase - passed - start + IN_STEP)
    left, right = downs & LEFT_FOOT > 0, downs & RIGHT_FOOT > 0
    return left if when == col.ON_LEFT else right if when == col.ON_RIGHT else left or right


@kernel
def begin_action(bank: BankArrays, s: Array, c: int) -> None:
    """Begins the waiting action, in a slot above all others."""
    slot, waiting = action_slot(c, int(s[c + col.ACTIONS])), c + col.NEXT_ACTION
    for column in range(col.ACTION_COLUMNS):
        s[slot + column] = s[waiting + column]
    clip, start, phase = int(s[slot + col.CLIP]), s[slot + col.PHASE], reference(bank, s, c)
    if s[slot + col.KIND] == SPLICE and not is_own_clock(s, slot, s[slot + col.FRAME]):
        s[slot + col.PHASE] = in_step(bank, clip, start, phase)
        if s[c + col.WHEN] == col.IN_PHASE and phase != UNKNOWN:
            nearest = phase + np.round(start - phase)
            s[slot + col.PHASE] = max(nearest, bank.clips[clip, arrays.FIRST_PHASE])
        s[slot + col.FRAME] = frame_of(bank, clip, s[slot + col.PHASE])
    s[slot + col.ELAPSED] = 0.0
    if s[slot + col.KIND] != col.OWN:
        s[c + col.EVENTS], s[c + col.BEGAN] = int(s[c + col.EVENTS]) | col.ACTION_BEGAN, clip
    s[c + col.ACTIONS] += 1.0
    s[c + col.WHEN] = col.NEVER
    drop_actions(s, c)


@kernel
def hand_over(bank: BankArrays, s: Array, c: int, slot: int) -> None:
    """Begins the next stretch of a hybrid action above the one in `slot`, the newest action."""
    over, before = slot + col.ACTION_COLUMNS, int(s[slot + col.CLIP])
    clip, phase = int(bank.clips[before, arrays.NEXT_STRETCH]), reference(bank, s, c)
    for column in range(col.ACTION_COLUMNS):
        s[over + column] = s[slot + column]
    stands = bank.clips[clip, arrays.STANCE] >= 0.0
    late = s[slot + col.FRAME] - bank.clips[before, arrays.LEAVES]
    frame = bank.clips[clip, arrays.ENTERS] + late
    start = phase_of(bank, clip, frame)
    if not stands and phase != UNKNOWN:
        start = phase + shift_of(bank, clip, start, phase, True)
        frame = frame_of(bank, clip, start)
    s[over + col.CLIP], s[over + col.PHASE], s[over + col.FRAME] = clip, start, frame
    s[over + col.OWN_FROM], s[over + col.OWN_TO] = 0.0 if stands else np.inf, np.inf
    s[over + col.ELAPSED], s[over + col.LASTING], s[over + col.CURVE] = 0.0, HANDOVER, col.SMOOTH
    s[c + col.ACTIONS] += 1.0


@inlined
def is_own_clock(s: Array, slot: int, frame: float) -> bool:
    """Whether an action plays by its own clock at a frame."""
    return s[slot + col.OWN_FROM] <= frame < s[slot + col.OWN_TO]


@kernel
def share_locomotions(s: Array, c: int) -> None:
    """Computes the share of each locomotion, and drops locomotions that groups above them cover."""
    count, rest = int(s[c + col.LOCOMOTIONS]), 1.0
    first = count
    while first > 0 and rest > 0.0:
        first -= 1
        head = locomotion_slot(c, first)
        if s[head + col.HEAD] > 0.0:
            fade = fade_of(s, head) if first > 0 else 1.0
            for number in range(first, first + int(s[head + col.HEAD])):
                slot = locomotion_slot(c, number)
                s[slot + col.SHARE] = rest * fade * s[slot + col.WEIGHT]
            rest *= 1.0 - fade
    if first > 0:
        size = (count - first) * col.LOCOMOTION_COLUMNS
        for column in range(size):
            s[c + col.FIRST_LOCOMOTION + column] = s[locomotion_slot(c, first) + column]
        s[c + col.LOCOMOTIONS] = count - first


@kernel
def drop_actions(s: Array, c: int) -> None:
    """Drops actions that are covered by actions above them, and sets ACTION_ENDED for those that were ending."""
    count, covered = int(s[c + col.ACTIONS]), 0
    for number in range(count - 1, -1, -1):
        slot = action_slot(c, number)
        mask, whole = int(s[slot + col.MASK]), s[slot + col.ELAPSED] >= s[slot + col.LASTING]
        hidden = mask & ~covered == 0
        if whole:
            covered |= mask
        if hidden or (whole and number == 0 and s[slot + col.KIND] == col.OWN):
            if s[slot + col.LEAVING] > 0.0:
                s[c + col.EVENTS], s[c + col.ENDED] = int(s[c + col.EVENTS]) | col.ACTION_ENDED, s[slot + col.CLIP]
            for column in range(slot, action_slot(c, count - 1)):
                s[column] = s[column + col.ACTION_COLUMNS]
            count -= 1
    s[c + col.ACTIONS] = count


@kernel
def leave_action(s: Array, c: int, slot: int, lasting: float) -> None:
    """Begins to fade out the newest action: the locomotion's own upper body fades in above it."""
    s[slot + col.LEAVING] = 1.0
    own = slot + col.ACTION_COLUMNS
    for column in range(col.ACTION_COLUMNS):
        s[own + column] = 0.0
    s[own + col.KIND], s[own + col.MASK] = col.OWN, s[slot + col.MASK]
    s[own + col.LASTING], s[own + col.CURVE] = lasting, s[slot + col.CURVE]
    s[c + col.ACTIONS] += 1.0
