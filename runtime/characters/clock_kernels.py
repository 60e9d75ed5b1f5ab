"""Advances characters from one frame to the next: phases, fades, root motion and events."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action_kernels import advance_actions, end_actions, set_frames
from motionsplice.runtime.characters.aim_kernels import advance_aims
from motionsplice.runtime.characters.arrays import (
    BEFORE,
    DRIVES,
    FIRST_IN_STEP,
    LEFT_X,
    LEFT_Z,
    PASSED,
    REACHED,
    RIGHT_X,
    RIGHT_Z,
    ROUNDS,
    SLOT,
    STANDS,
    Ground,
)
from motionsplice.runtime.characters.feet_kernels import (
    LONGEST,
    NOTHING,
    NOWHERE,
    Sums,
    add_step,
    drive_root,
    feet_at,
    mixed_places,
    step_of,
)
from motionsplice.runtime.characters.lock_kernels import advance_lock, is_locking
from motionsplice.runtime.characters.slots import AHEAD, FARTHER, action_slot, fetch_state, hands_slot, locomotion_slot
from motionsplice.runtime.characters.transition_kernels import (
    begin_waiting,
    drop_actions,
    drop_hands,
    feet_of,
    in_turned_frame,
    keep_path,
    keep_place,
    keep_turn,
    leading,
    path_at,
    share_locomotions,
)
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, BankArrays
from motionsplice.runtime.kernels.lookup import SPLICE, cell_of, frame_after_last
from motionsplice.runtime.kernels.phase import own_step, phase_of, row_of
from motionsplice.runtime.kernels.rotations import ONE
from motionsplice.runtime.simd.compiled import ZERO, Array, inlined, kernel
from motionsplice.runtime.simd.prefetch import prefetch, prefetch_at

SMOOTHING = 0.05  # seconds: weights follow their goals through two low-pass filters with this time constant
AGAIN = 0.3  # seconds: fade of a clip into its own beginning, if it has no loop


@kernel
def begin(bank: BankArrays, ground: Ground, states: Array, rows: Array) -> None:
    """Begins what is waiting in `rows` [n], if it can begin at once."""
    for row in rows:
        begin_waiting(bank, ground, states, row * col.COLUMNS, 0.0, ZERO)


@kernel
def recompute_from_frames(bank: BankArrays, ground: Ground, s: Array) -> None:
    """Recomputes phases and paths from frames, for characters that were moved to another bank."""
    for c in range(0, len(s), col.COLUMNS):
        for number in range(int(s[c + col.LOCOMOTIONS])):
            recompute_slot(bank, s, locomotion_slot(c, number))
            keep_path(bank, ground, s, locomotion_slot(c, number))
        for number in range(int(s[c + col.ACTIONS])):
            recompute_slot(bank, s, action_slot(c, number))
        if s[c + col.WHEN] > col.NEVER:  # else the slot is stale, and its clip a number of the old bank
            recompute_slot(bank, s, c + col.NEXT_ACTION)


@kernel
def recompute_slot(bank: BankArrays, s: Array, slot: int) -> None:
    """Clamps a slot's frame to its clip, and recomputes its phase."""
    clip = int(s[slot + col.CLIP])
    s[slot + col.FRAME] = min(s[slot + col.FRAME], bank.clips[clip, arrays.ROW_COUNT] - 1.0)
    s[slot + col.PHASE] = phase_of(bank, clip, s[slot + col.FRAME])


@kernel
def advance(bank: BankArrays, ground: Ground, reach: float, clock: Array, s: Array, seconds: float) -> int:
    """Advances all characters; returns the bits of all events that happened to any of them.

    Goes step by step through a block of characters, so that their waits for frames overlap. reach: the farthest that
    the foot lock holds a foot from its pose, metres. clock: scratch memory.
    """
    happened, follow = 0, 1.0 - math.exp(-seconds / SMOOTHING)
    count = len(s) // col.COLUMNS
    for character in range(min(FARTHER, count)):
        fetch_state(s, character * col.COLUMNS)
    for character in range(min(AHEAD, count)):
        fetch_tables(bank, ground, s, character * col.COLUMNS)
    for first in range(0, count, BLOCK):
        stop, slots = min(first + BLOCK, count), 0
        for character in range(first, stop):
            c = character * col.COLUMNS
            if character + FARTHER < count:
                fetch_state(s, c + FARTHER * col.COLUMNS)
            if character + AHEAD < count:
                fetch_tables(bank, ground, s, c + AHEAD * col.COLUMNS)
            s[c + col.EVENTS] = 0.0
            slots = begin_step(bank, ground, s, c, character - first, seconds, follow, clock, slots)
        set_frames(bank, s, clock, 0, slots)
        slots, actions = 0, FIRST_IN_STEP
        for character in range(first, stop):
            c, k = character * col.COLUMNS, character - first
            slots = move(bank, ground, reach, s, c, k, seconds, clock, slots)
            actions = advance_actions(bank, s, c, seconds, clock[PASSED + k], clock, actions)
        set_frames(bank, s, clock, FIRST_IN_STEP, actions)
        for character in range(first, stop):
            c, passed = character * col.COLUMNS, clock[PASSED + character - first]
            if s[c + col.ACTIONS] > 0.0:
                end_actions(bank, s, c, int(s[c + col.ACTIONS]), seconds)
            downs = step(bank, ground, s, c, passed)
            if s[c + col.NEXT_COUNT] > 0.0 or s[c + col.WHEN] > col.NEVER or s[c + col.HANDS_WAIT] > 0.0:
                begin_waiting(bank, ground, s, c, passed, downs)
            happened |= int(s[c + col.EVENTS])
    return happened


@inlined
def begin_step(
    bank: BankArrays,
    ground: Ground,
    s: Array,
    c: int,
    k: int,
    seconds: float,
    follow: float,
    clock: Array,
    slots: int,
) -> int:
    """Advances a character's fades, and finds the places of its feet and the cycles that its gaits advance together.

    Puts all gaits of a mix into the clock, and returns how many slots it then has.
    """
    drives = s[c + col.LOCOMOTIONS] > 1.0
    stand = (drives or is_locking(s, c)) and seconds * s[c + col.SPEED] <= LONGEST
    left, right = mixed_places(bank, ground, s, c) if stand else (NOWHERE, NOWHERE)
    clock[STANDS + k], clock[DRIVES + k] = stand, stand and drives
    clock[LEFT_X + k], clock[LEFT_Z + k], clock[RIGHT_X + k], clock[RIGHT_Z + k] = left[0], left[1], right[0], right[1]
    advance_fades(s, c, seconds, follow)
    count, passed = int(s[c + col.LOCOMOTIONS]), 0.0
    if count > 1:
        passed = common_step(bank, s, c, count, seconds * s[c + col.SPEED])
        for number in range(count):
            slot = locomotion_slot(c, number)
            clip = int(s[slot + col.CLIP])
            if bank.clips[clip, arrays.GAIT] > 0.0:
                loop, _ = end_of(bank, s, slot)
                reached, end = s[slot + col.PHASE] + passed, bank.clips[clip, arrays.LAST_PHASE]
                rounds = np.ceil((reached - end) / loop) if loop > 0.0 and reached > end else 0.0
                reached -= rounds * loop
                clock[SLOT + slots], clock[REACHED + slots] = slot, reached
                clock[BEFORE + slots], clock[ROUNDS + slots] = s[slot + col.FRAME], rounds
                slots += 1
    clock[PASSED + k] = passed
    return slots


@inlined
def move(
    bank: BankArrays,
    ground: Ground,
    reach: float,
    s: Array,
    c: int,
    k: int,
    seconds: float,
    clock: Array,
    slots: int,
) -> int:
    """Advances a character's locomotions, place and foot lock; returns the number of the next slot in the clock."""
    left, right = (clock[LEFT_X + k], clock[LEFT_Z + k]), (clock[RIGHT_X + k], clock[RIGHT_Z + k])
    slots, lefts, rights = advance_locomotions(bank, ground, s, c, k, seconds, clock, slots)
    if clock[DRIVES + k] > 0.0:
        drive_root(s, c, left, right, lefts, rights, seconds)
    step_forward(s, c)
    if is_locking(s, c):
        advance_lock(s, c, left, right, lefts, rights, seconds, reach)
    return slots


@inlined
def fetch_tables(bank: BankArrays, ground: Ground, s: Array, c: int) -> None:
    """Prefetches what a character is going to read of the bank's tables of phases, frames, paths and feet."""
    count = int(s[c + col.LOCOMOTIONS])
    for number in range(count):
        slot = locomotion_slot(c, number)
        row, _ = row_of(bank, int(s[slot + col.CLIP]), s[slot + col.FRAME])
        prefetch_at(bank.phases, row + ONE)
        prefetch(ground.paths, row, 0)
        prefetch(ground.paths, row + ONE + ONE, 0)
        prefetch_at(ground.contacts, row)
        if count > 1:
            prefetch(ground.feet, row, 0)
            fetch_frames(bank, s, slot)
    for number in range(int(s[c + col.ACTIONS])):
        slot = action_slot(c, number)
        if s[slot + col.KIND] == SPLICE:
            row, _ = row_of(bank, int(s[slot + col.CLIP]), s[slot + col.FRAME])
            prefetch_at(bank.phases, row + ONE)
            fetch_frames(bank, s, slot)


@inlined
def fetch_frames(bank: BankArrays, s: Array, slot: int) -> None:
    """Prefetches the cells of frame_of_phase at a slot's phase."""
    cell, _ = cell_of(bank, int(s[slot + col.CLIP]), s[slot + col.PHASE])
    prefetch_at(bank.frames, cell + ONE)


@inlined
def advance_fades(s: Array, c: int, seconds: float, follow: float) -> None:
    """Advances all fades of a character, and its weights by the share `follow` towards their goals."""
    count = int(s[c + col.LOCOMOTIONS])
    if count > 1:
        for number in range(count):
            advance_fade(s, locomotion_slot(c, number), seconds, follow)
        share_locomotions(s, c)
    for number in range(int(s[c + col.ACTIONS])):
        advance_fade(s, action_slot(c, number), seconds, follow)
    if s[c + col.ACTIONS] > 1.0 or (s[c + col.ACTIONS] > 0.0 and s[c + col.FIRST_ACTION + col.KIND] == col.OWN):
        drop_actions(s, c)
    if s[c + col.HANDS] > 0.0:
        advance_hands(s, c, seconds, follow)
    if s[c + col.AIMED] > 0.0:
        advance_aims(s, c, seconds)


@kernel
def advance_hands(s: Array, c: int, seconds: float, follow: float) -> None:
    for number in range(int(s[c + col.HANDS])):
        advance_fade(s, hands_slot(c, number), seconds, follow)
    drop_hands(s, c)


@inlined
def advance_fade(s: Array, slot: int, seconds: float, follow: float) -> None:
    s[slot + col.ELAPSED] += seconds
    s[slot + col.LAGGING] += follow * (s[slot + col.GOAL] - s[slot + col.LAGGING])
    s[slot + col.WEIGHT] += follow * (s[slot + col.LAGGING] - s[slot + col.WEIGHT])


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
            after = min(after, last)
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
def step_forward(s: Array, c: int) -> None:
    """Moves a character by its root motion."""
    x, z = in_turned_frame(-s[c + col.SIN], s[c + col.COS], s[c + col.DELTA], s[c + col.DELTA + 2])
    s[c + col.PLACE] += x
    s[c + col.PLACE + 1] += s[c + col.DELTA + 1]
    s[c + col.PLACE + 2] += z
    if s[c + col.DELTA + 3] != 0.0:
        s[c + col.HEADING] += s[c + col.DELTA + 3]
        s[c + col.SIN], s[c + col.COS] = math.sin(0.5 * s[c + col.HEADING]), math.cos(0.5 * s[c + col.HEADING])


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
            times += s[slot + col.SHARE] / own_step(bank, clip, frame, s[slot + col.PHASE], ahead)
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
        for _ in range(int(rounds) - 1):
            dx, dz = in_turned_frame(math.sin(0.5 * (h0 - turn)), math.cos(0.5 * (h0 - turn)), x1 - x0, z1 - z0)
            x, y, z, turn = x + dx, y + y1 - y0, z + dz, turn + h1 - h0
        sin, cos = math.sin(0.5 * (h0 - turn)), math.cos(0.5 * (h0 - turn))
    heading = s[slot + col.PATH + 3]
    keep_place(bank, ground, s, slot)
    if s[slot + col.PATH + 3] != heading:
        keep_turn(s, slot)
    dx, dz = in_turned_frame(sin, cos, s[slot + col.PATH] - x0, s[slot + col.PATH + 2] - z0)
    return x + dx, y + s[slot + col.PATH + 1] - y0, z + dz, turn + s[slot + col.PATH + 3] - h0


@inlined
def step(bank: BankArrays, ground: Ground, s: Array, c: int, passed: float) -> int:
    """Sets the events of strides and feet, by the locomotion with the largest share; returns bits of feet set down."""
    slot = leading(s, c)
    phase, now = s[slot + col.PHASE], feet_of(bank, ground, s, slot)
    before, events = int(s[c + col.STANDING]), int(s[c + col.EVENTS])
    downs, ups = now & ~before, before & ~now
    events |= col.LEFT_DOWN if downs & LEFT_FOOT else 0
    events |= col.RIGHT_DOWN if downs & RIGHT_FOOT else 0
    events |= col.LEFT_UP if ups & LEFT_FOOT else 0
    events |= col.RIGHT_UP if ups & RIGHT_FOOT else 0
    events |= col.STRIDE if np.floor(phase) > np.floor(phase - passed) else 0
    s[c + col.STANDING], s[c + col.EVENTS] = now, events
    return downs
