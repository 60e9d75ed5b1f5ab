"""Advances characters from one frame to the next: phases, fades, root motion and events."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action_kernels import advance_actions, end_actions, set_frames
from motionsplice.runtime.characters.aim_kernels import advance_aims
from motionsplice.runtime.characters.arrays import (
    DRIVES,
    FIRST_IN_STEP,
    LEFT_X,
    LEFT_Z,
    PASSED,
    RIGHT_X,
    RIGHT_Z,
    STANDS,
    Ground,
    StageArrays,
)
from motionsplice.runtime.characters.bounds_kernels import keep_in_bounds
from motionsplice.runtime.characters.feet_kernels import (
    LONGEST,
    NOWHERE,
    drive_root,
    mixed_places,
)
from motionsplice.runtime.characters.lock_kernels import advance_lock, is_locking
from motionsplice.runtime.characters.locomotion_kernels import advance_locomotions, begin_in_step
from motionsplice.runtime.characters.slots import (
    AHEAD,
    FARTHER,
    action_slot,
    fetch_state,
    hands_slot,
    locomotion_slot,
    row_at,
)
from motionsplice.runtime.characters.transition_kernels import (
    begin_waiting,
    drop_actions,
    drop_hands,
    feet_of,
    in_turned_frame,
    keep_path,
    leading,
    share_locomotions,
)
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, BankArrays
from motionsplice.runtime.kernels.lookup import SPLICE, cell_of
from motionsplice.runtime.kernels.phase import phase_of, row_of
from motionsplice.runtime.kernels.rotations import ONE
from motionsplice.runtime.simd.compiled import ZERO, Array, inlined, kernel
from motionsplice.runtime.simd.handle import Handle, record_at
from motionsplice.runtime.simd.prefetch import prefetch, prefetch_at

TWO_TURNS = 4.0 * math.pi
SMOOTHING = 0.05  # seconds: weights follow their goals through two low-pass filters with this time constant


@kernel
def begin(handle: Handle, states: Array, rows: Array) -> None:
    """Begins what is waiting in `rows` [n], if it can begin at once."""
    stage = record_at(handle, StageArrays)
    for row in rows:
        keep_in_bounds(stage.bank, states, row_at(row))
        begin_waiting(stage.bank, stage.ground, states, row_at(row), 0.0, ZERO)


@kernel
def recompute_from_frames(handle: Handle, s: Array) -> None:
    """Recomputes phases and paths from frames, for characters that were moved to another bank."""
    stage = record_at(handle, StageArrays)
    bank, ground = stage.bank, stage.ground
    for c in range(0, len(s), col.COLUMNS):
        keep_in_bounds(bank, s, c)
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
def advance(handle: Handle, s: Array, seconds: float) -> int:
    """Advances all characters; returns the bits of all events that happened to any of them.

    Goes step by step through a block of characters, so that their waits for frames overlap. handle is that of
    StageArrays.
    """
    stage = record_at(handle, StageArrays)
    bank, ground, reach, clock = stage.bank, stage.ground, stage.legs.reach, stage.clock
    happened, follow = 0, 1.0 - math.exp(-seconds / SMOOTHING)
    count = len(s) // col.COLUMNS
    for character in range(min(FARTHER, count)):
        fetch_state(s, row_at(character))
    for character in range(min(AHEAD, count)):
        fetch_tables(bank, ground, s, row_at(character))
    for first in range(0, count, BLOCK):
        stop, slots = min(first + BLOCK, count), 0
        for character in range(first, stop):
            c = row_at(character)
            if character + FARTHER < count:
                fetch_state(s, row_at(character + FARTHER))
            if character + AHEAD < count:
                fetch_tables(bank, ground, s, row_at(character + AHEAD))
            s[c + col.EVENTS] = 0.0
            slots = begin_step(bank, ground, s, c, character - first, seconds, follow, clock, slots)
        set_frames(bank, s, clock, 0, slots)
        slots, actions = 0, FIRST_IN_STEP
        for character in range(first, stop):
            c, k = row_at(character), character - first
            slots = move(bank, ground, reach, s, c, k, seconds, clock, slots)
            actions = advance_actions(bank, s, c, seconds, clock[PASSED + k], clock, actions)
        set_frames(bank, s, clock, FIRST_IN_STEP, actions)
        for character in range(first, stop):
            c, passed = row_at(character), clock[PASSED + character - first]
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
    return begin_in_step(bank, s, c, k, seconds * s[c + col.SPEED], clock, slots)


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
    """Prefetches what a character is going to read of the bank's tables of phases, frames, paths and feet.

    Keeps its row in bounds first.
    """
    keep_in_bounds(bank, s, c)
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
def step_forward(s: Array, c: int) -> None:
    """Moves a character by its root motion."""
    x, z = in_turned_frame(-s[c + col.SIN], s[c + col.COS], s[c + col.DELTA], s[c + col.DELTA + 2])
    s[c + col.PLACE] += x
    s[c + col.PLACE + 1] += s[c + col.DELTA + 1]
    s[c + col.PLACE + 2] += z
    if s[c + col.DELTA + 3] != 0.0:
        heading = s[c + col.HEADING] + s[c + col.DELTA + 3]
        if abs(heading) > TWO_TURNS:  # after one turn the root's quaternion would change its sign
            heading -= TWO_TURNS * np.round(heading / TWO_TURNS)
        s[c + col.HEADING] = heading
        s[c + col.SIN], s[c + col.COS] = math.sin(0.5 * heading), math.cos(0.5 * heading)


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
