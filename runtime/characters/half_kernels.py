"""Samples the upper halves of locomotions and actions, and prepares the splice of an action."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Mixing
from motionsplice.runtime.characters.mixing_kernels import (
    mix_lanes,
    set_lane_weights,
    split_lanes,
)
from motionsplice.runtime.characters.slots import LANE, action_slot, locomotion_slot
from motionsplice.runtime.characters.worn_kernels import wear_hands
from motionsplice.runtime.format.rows import PELVIS
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, ROW_L, ROW_U, SHARE_L, SHARE_U, SPLICED, BankArrays
from motionsplice.runtime.kernels.fetching import fetch_cloud
from motionsplice.runtime.kernels.lookup import NAIVE, SPLICE, is_mirrored, locate, repeated
from motionsplice.runtime.kernels.mirror import mirror_upper
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.posture import ABSOLUTE, GIVEN, RELATIVE, RUNNING, correlate
from motionsplice.runtime.kernels.rotations import sample_and_fetch
from motionsplice.runtime.kernels.standing import lay_on
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel


@inlined
def is_added(bank: BankArrays, s: Array, slot: int) -> bool:
    """Whether an action is added to the locomotion's own upper half: a standing action with posture `relative`."""
    return (
        s[slot + col.KIND] == SPLICE
        and s[slot + col.POSTURE] == RELATIVE
        and bank.clips[int(s[slot + col.CLIP]), arrays.STANCE] >= 0.0
    )


@inlined
def sample_own(bank: BankArrays, s: Array, c: int, ahead: Index, lanes: Array, at: Index, mixing: Mixing) -> None:
    """Mixes the locomotions' own upper halves into lanes from `at` on."""
    count, width = int(s[c + col.LOCOMOTIONS]), bank.rig[arrays.UPPER_WIDTH]
    for number in range(count):
        slot = locomotion_slot(c, number)
        row, t = row_of(bank, int(s[slot + col.CLIP]), s[slot + col.FRAME])
        sample_half(bank, s, c, int(s[slot + col.CLIP]), row, ahead, np.float32(t), lanes, at)
        if count > 1:
            split_lanes(lanes, at, width, mixing, number)
            set_lane_weights(mixing, number, width, np.float32(s[slot + col.SHARE]))
    if count > 1:
        mix_lanes(mixing, count, width, lanes, at)


@inlined
def sample_half(
    bank: BankArrays, s: Array, c: int, clip: int, row: Index, ahead: Index, t: Real, lanes: Array, above: Index
) -> None:
    """Samples the upper half of a clip into lanes, with the hands that the character wears on it."""
    rig = bank.rig
    sample_and_fetch(bank.upper, row, ahead, rig[arrays.FIRST_PLANE], rig[arrays.UPPER_WIDTH], t, lanes, above)
    if s[c + col.HANDS] > 0.0:
        wear_hands(bank, s, c, clip, row, t, lanes, above)
    if is_mirrored(bank, clip):
        mirror_upper(bank, lanes, above)


@inlined
def is_bare(bank: BankArrays, s: Array, c: int, clip: int) -> bool:
    """Whether the upper half of a clip is shown as it is stored: not mirrored, and without a hands layer."""
    return s[c + col.HANDS] == 0.0 and not is_mirrored(bank, clip)


@inlined
def row_of_action(bank: BankArrays, s: Array, slot: int) -> tuple[np.uint64, float]:
    """Returns the row before an action's frame, and the share of the next row."""
    clip, frame = int(s[slot + col.CLIP]), s[slot + col.FRAME]
    first, count = bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT]
    if s[slot + col.KIND] == NAIVE:
        count = bank.clips[clip, arrays.FRAME_COUNT]
        frame = repeated(frame, count - 1.0)
    return locate(frame, first, count)


@inlined
def sample_action(
    bank: BankArrays, s: Array, c: int, number: int, k: int, ahead: Index, lanes: Array, block: Array, mixing: Mixing
) -> None:
    """Samples an action's upper half into lanes, and prepares its splice in lane k of the block."""
    slot, above = action_slot(c, number), np.uint64(4) * bank.rig[arrays.LOWER_WIDTH]
    row, t = row_of_action(bank, s, slot)
    sample_half(bank, s, c, int(s[slot + col.CLIP]), row, ahead, np.float32(t), lanes, above)
    prepare_splice(bank, s, c, number, k, row, t, lanes, block, mixing)
    fetch_cloud(bank.upper, ahead, bank.rig[arrays.FIRST_PLANE])


@inlined
def prepare_splice(
    bank: BankArrays,
    s: Array,
    c: int,
    number: int,
    k: int,
    row: Index,
    t: float,
    lanes: Array,
    block: Array,
    mixing: Mixing,
) -> None:
    """Prepares the splice of an action, `t` of the way from a row to the next, in lane k of the block.

    Of its upper half, pelvis and torso offset must be in lanes; all of it, if it is added to the locomotion.
    """
    rig, slot = bank.rig, action_slot(c, number)
    first, k = (k - number) & LANE, k & LANE
    above, mirrored = np.uint64(4) * rig[arrays.LOWER_WIDTH], is_mirrored(bank, int(s[slot + col.CLIP]))
    block[ROW_U * BLOCK + k], block[SHARE_U * BLOCK + k] = np.int64(row), t
    request, kind = mixing.requests[k], int(s[slot + col.KIND])
    if is_added(bank, s, slot):
        own = np.uint64(4) * rig[arrays.OWN_UPPER]
        lay_on(bank, int(s[slot + col.CLIP]), row, np.float32(t), lanes, own, above)
        kind = NAIVE  # its pelvis is known
    request["method"], request["posture"] = kind, int(s[slot + col.POSTURE])
    request["action"], request["locomotion"] = int(s[slot + col.CLIP]), int(s[c + col.FIRST_LOCOMOTION + col.CLIP])
    if kind == SPLICE:
        for column in range(arrays.MEAN_POSTURE):
            mixing.memory[k, column] = s[slot + col.REMEMBERED + column]
        if request["posture"] == RUNNING:
            for column in range(arrays.MEAN_POSTURE, arrays.MEMORY_COLUMNS):
                mixing.memory[k, column] = s[slot + col.REMEMBERED + column]
        if s[c + col.LOCOMOTIONS] > 1.0:
            block[ROW_L * BLOCK + k] = block[SHARE_L * BLOCK + k] = 0.0
            correlate(bank, mixing.row, False, mirrored, block, k, lanes, above)  # the row is mirrored already
            if request["posture"] == ABSOLUTE:
                mix_postures(bank, s, c, k, mixing)
        else:
            block[ROW_L * BLOCK + k] = block[ROW_L * BLOCK + first]
            block[SHARE_L * BLOCK + k] = block[SHARE_L * BLOCK + first]
            correlate(bank, bank.lower, is_mirrored(bank, request["locomotion"]), mirrored, block, k, lanes, above)
    elif kind == NAIVE:
        for i in range(4):
            block[(SPLICED + i) * BLOCK + k] = 0.0
            mixing.turns[k, i] = lanes[above + np.uint64(4 * PELVIS + i)]


@kernel
def mix_postures(bank: BankArrays, s: Array, c: int, k: int, mixing: Mixing) -> None:
    """Mixes the locomotions' stored postures into the memory of an action with posture `absolute`."""
    mixing.requests[k]["posture"] = GIVEN
    for i in range(6):
        mixing.memory[k, arrays.MEAN_POSTURE + i] = 0.0
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion_slot(c, number)
        for i in range(6):
            stored = bank.clips[int(s[slot + col.CLIP]), arrays.POSTURE + i]
            mixing.memory[k, arrays.MEAN_POSTURE + i] += s[slot + col.SHARE] * stored
