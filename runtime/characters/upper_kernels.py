"""Mixes the upper bodies of locomotions and actions, part by part.

A single action without a fade takes a path without mixing.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs, Mixing
from motionsplice.runtime.characters.mixing_kernels import add_lanes, normalise_lanes, set_lane_weights
from motionsplice.runtime.characters.slots import action_slot, fade_of, locomotion_slot
from motionsplice.runtime.characters.turning_kernels import LIMBS, MIXED, ONE_SPLICE, UNTURNED, is_apart, keep_limbs
from motionsplice.runtime.characters.worn_kernels import wear_hands
from motionsplice.runtime.format.rows import PELVIS
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, ROW_L, ROW_U, SHARE_L, SHARE_U, SPLICED, BankArrays
from motionsplice.runtime.kernels.evaluate import copy_upper
from motionsplice.runtime.kernels.lookup import NAIVE, NONE, SPLICE, is_mirrored, locate, repeated
from motionsplice.runtime.kernels.mirror import mirror_upper
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.posture import ABSOLUTE, GIVEN, RELATIVE, RUNNING, correlate
from motionsplice.runtime.kernels.rotations import sample
from motionsplice.runtime.kernels.standing import lay_on
from motionsplice.runtime.simd.compiled import Array, Index, inlined, kernel
from motionsplice.runtime.simd.lanes import load, spread, store
from motionsplice.runtime.simd.width import LANES


@inlined
def mix_upper(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    c: int,
    k: int,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    character: int,
    rotations: Array,
) -> None:
    """Mixes the upper halves of locomotions and actions into lanes, and writes their joints into the pose.

    Prepares the splice of each action in a lane of the block.
    """
    rig, count = bank.rig, int(s[c + col.ACTIONS])
    above = np.uint64(4) * rig[arrays.LOWER_WIDTH]
    mixing.requests[k]["method"], mixing.finish[k] = NONE, UNTURNED
    if count == 0:
        sample_own(bank, s, c, lanes, mixing)
    elif is_plain(s, c):
        if is_added(bank, s, action_slot(c, 0)):
            keep_own(bank, s, c, lanes, mixing)
        sample_action(bank, s, c, 0, k, lanes, block, mixing)
        mixing.finish[k] = ONE_SPLICE
        if mixing.requests[k]["method"] != SPLICE:
            mixing.finish[k] = MIXED
            for part in range(col.PARTS):
                mixing.shares[k, part] = 1.0
    else:
        mixing.finish[k] = MIXED
        mix_actions(bank, limbs, s, c, count, k, lanes, block, mixing)
        for number in range(count):
            for part in range(col.PARTS):
                mixing.shares[k + number, part] = mixing.weights[col.PARTS * (number + 1) + part]
    copy_upper(rig, lanes, above, rotations, character)


@inlined
def is_plain(s: Array, c: int) -> bool:
    """Whether one action alone gives the whole upper body."""
    slot = c + col.FIRST_ACTION
    return (
        s[c + col.ACTIONS] == 1.0
        and s[slot + col.KIND] != col.OWN
        and s[slot + col.MASK] == col.UPPER_BODY
        and s[slot + col.ELAPSED] >= s[slot + col.LASTING]
        and s[slot + col.WEIGHT] == 1.0
    )


@inlined
def shows_own(bank: BankArrays, s: Array, c: int) -> bool:
    """Whether the locomotions' own upper halves are likely to be sampled: no action covers all of them."""
    covered = False
    for number in range(int(s[c + col.ACTIONS])):
        slot = action_slot(c, number)
        if s[slot + col.KIND] == col.OWN or is_added(bank, s, slot):
            return True
        covered |= (
            s[slot + col.MASK] == col.UPPER_BODY
            and s[slot + col.ELAPSED] >= s[slot + col.LASTING]
            and s[slot + col.WEIGHT] == 1.0
        )
    return not covered


@inlined
def is_added(bank: BankArrays, s: Array, slot: int) -> bool:
    """Whether an action is added to the locomotion's own upper half: a standing action with posture `relative`."""
    return (
        s[slot + col.KIND] == SPLICE
        and s[slot + col.POSTURE] == RELATIVE
        and bank.clips[int(s[slot + col.CLIP]), arrays.STANCE] >= 0.0
    )


@inlined
def keep_own(bank: BankArrays, s: Array, c: int, lanes: Array, mixing: Mixing) -> None:
    """Mixes the locomotions' own upper halves, and keeps them where standing actions are laid on them."""
    sample_own(bank, s, c, lanes, mixing)
    above, own = np.uint64(4) * bank.rig[arrays.LOWER_WIDTH], np.uint64(4) * bank.rig[arrays.OWN_UPPER]
    for number in range(np.uint64(4) * bank.rig[arrays.UPPER_WIDTH]):
        lanes[own + number] = lanes[above + number]


@inlined
def sample_own(bank: BankArrays, s: Array, c: int, lanes: Array, mixing: Mixing) -> None:
    """Mixes the locomotions' own upper halves into lanes."""
    rig, count = bank.rig, int(s[c + col.LOCOMOTIONS])
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    for number in range(count):
        slot = locomotion_slot(c, number)
        clip = int(s[slot + col.CLIP])
        row, t = row_of(bank, clip, s[slot + col.FRAME])
        sample(bank.upper, row, rig[arrays.FIRST_PLANE], width, np.float32(t), lanes, above)
        if s[c + col.HANDS] > 0.0:
            wear_hands(bank, s, c, clip, row, np.float32(t), lanes, above)
        if is_mirrored(bank, clip):
            mirror_upper(bank, lanes, above)
        if count > 1:
            set_lane_weights(mixing.lane_weights, width, np.float32(s[slot + col.SHARE]))
            add_lanes(lanes, above, width, mixing, number == 0)
    if count > 1:
        normalise_lanes(mixing.sum, above, width, lanes)


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
    bank: BankArrays, s: Array, c: int, number: int, k: int, lanes: Array, block: Array, mixing: Mixing
) -> None:
    """Samples an action's upper half into lanes, and prepares its splice in lane k of the block."""
    rig, slot = bank.rig, action_slot(c, number)
    above, first = np.uint64(4) * rig[arrays.LOWER_WIDTH], k - number
    row, t = row_of_action(bank, s, slot)
    sample(bank.upper, row, rig[arrays.FIRST_PLANE], rig[arrays.UPPER_WIDTH], np.float32(t), lanes, above)
    if s[c + col.HANDS] > 0.0:
        wear_hands(bank, s, c, int(s[slot + col.CLIP]), row, np.float32(t), lanes, above)
    mirrored = is_mirrored(bank, int(s[slot + col.CLIP]))
    if mirrored:
        mirror_upper(bank, lanes, above)
    block[ROW_U * BLOCK + k], block[SHARE_U * BLOCK + k] = row, t
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


@inlined
def mix_actions(
    bank: BankArrays, limbs: Limbs, s: Array, c: int, count: int, k: int, lanes: Array, block: Array, mixing: Mixing
) -> None:
    """Mixes the upper halves of locomotions and actions into lanes, each part by its shares."""
    rig = bank.rig
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    share_parts(s, c, count, mixing.weights)
    new = True
    for part in range(col.PARTS):
        new &= mixing.weights[part] == 0.0
    kept = False
    for number in range(count):
        kept |= is_added(bank, s, action_slot(c, number))
    if kept:
        keep_own(bank, s, c, lanes, mixing)
    elif not new:
        sample_own(bank, s, c, lanes, mixing)
    if not new:
        set_part_weights(limbs, width, mixing, 0, False)
        add_lanes(lanes, above, width, mixing, True)
    for number in range(count):
        slot = action_slot(c, number)
        mixing.requests[k + number]["method"] = 0
        if s[slot + col.KIND] != col.OWN:
            sample_action(bank, s, c, number, k + number, lanes, block, mixing)
            apart = is_apart(s, slot, k + number, mixing)
            if apart:
                keep_limbs(limbs, int(s[slot + col.MASK]), lanes, above, k + number, mixing)
                mixing.finish[k] = LIMBS
            set_part_weights(limbs, width, mixing, number + 1, apart)
            add_lanes(lanes, above, width, mixing, new)
            new = False
    normalise_lanes(mixing.sum, above, width, lanes)


@inlined
def share_parts(s: Array, c: int, count: int, weights: Array) -> None:
    """Computes the shares [PARTS] of the locomotions' own upper body, then of each action.

    Goes from the top slot down; the last row of `weights` holds what is left for the slots below.
    """
    left = col.PARTS * (count + 1)
    for part in range(col.PARTS):
        weights[part], weights[left + part] = 0.0, 1.0
    for number in range(count - 1, -1, -1):
        slot, at = action_slot(c, number), col.PARTS * (number + 1)
        mask, fade = int(s[slot + col.MASK]), fade_of(s, slot)
        given = 0.0 if s[slot + col.KIND] == col.OWN else s[slot + col.WEIGHT]
        for part in range(col.PARTS):
            share = weights[left + part] * (fade if mask >> part & 1 else 0.0)
            weights[left + part] -= share
            weights[part] += share * (1.0 - given)
            weights[at + part] = share * given
    for part in range(col.PARTS):
        weights[part] += weights[left + part]


@inlined
def set_part_weights(limbs: Limbs, width: Index, mixing: Mixing, source: int, apart: bool) -> None:
    """Sets the weight of each lane of an upper half to the share of its part.

    If the source owns limbs `apart` from the trunk, their attachments get weight 0: `turn_limbs` sets them.
    """
    begin, whole = col.PARTS * source, not apart
    for part in range(1, col.PARTS):
        whole &= mixing.weights[begin + part] == mixing.weights[begin]
    if whole:
        set_lane_weights(mixing.lane_weights, width, np.float32(mixing.weights[begin]))
        return
    parts, weights = limbs.part_lanes, mixing.weights[begin : begin + col.PARTS]
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        weight = spread(np.float32(weights[0])) * load(parts, 0, lane)
        for part in range(1, col.PARTS):
            weight = weight + spread(np.float32(weights[part])) * load(parts, part, lane)
        store(mixing.lane_weights, 0, lane, weight)
    if apart:
        for part in range(1, col.PARTS):
            if limbs.lengths[part] > 0:
                mixing.lane_weights[0, limbs.attachments[part]] = np.float32(0.0)
