"""Mixes the upper bodies of locomotions and actions, part by part.

A single action without a fade takes a path without mixing.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs, Mixing
from motionsplice.runtime.characters.half_kernels import (
    is_added,
    is_bare,
    prepare_splice,
    row_of_action,
    sample_action,
    sample_half,
    sample_own,
)
from motionsplice.runtime.characters.mixing_kernels import (
    copy_to_lanes,
    mix_lanes,
    plane_of,
    set_lane_weights,
    split_lanes,
)
from motionsplice.runtime.characters.slots import LANE, action_slot, fade_of, locomotion_slot
from motionsplice.runtime.characters.turning_kernels import (
    LIMBS,
    MIXED,
    ONE_SPLICE,
    ONLY_LIMBS,
    UNTURNED,
    is_apart,
    keep_limbs,
)
from motionsplice.runtime.format.rows import FIRST_JOINT, PELVIS, TORSO_OFFSET
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.evaluate import copy_rotation, copy_upper
from motionsplice.runtime.kernels.fetching import fetch_cloud
from motionsplice.runtime.kernels.lookup import NONE, SPLICE
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.rotations import sample_planes
from motionsplice.runtime.simd.compiled import Array, Index, inlined
from motionsplice.runtime.simd.lanes import load, spread, store
from motionsplice.runtime.simd.width import LANES


@inlined
def mix_upper(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    c: int,
    k: int,
    ahead: Index,
    ahead_own: Index,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    character: int,
    rotations: Array,
) -> None:
    """Mixes the upper halves of locomotions and actions into lanes, and writes their joints into the pose.

    Prepares the splice of each action in a lane of the block. Meanwhile prefetches the rows `ahead` and the next one
    while actions are sampled, and `ahead_own` and the next one while locomotions are.
    """
    rig, count, k = bank.rig, int(s[c + col.ACTIONS]), k & LANE
    above, own = np.uint64(4) * rig[arrays.LOWER_WIDTH], np.uint64(4) * rig[arrays.OWN_UPPER]
    mixing.requests[k]["method"], mixing.finish[k] = NONE, UNTURNED
    if count == 0:
        sample_own(bank, s, c, ahead_own, lanes, above, mixing)
    elif is_plain(s, c):
        if is_added(bank, s, action_slot(c, 0)):
            sample_own(bank, s, c, ahead_own, lanes, own, mixing)
        sample_action(bank, s, c, 0, k, ahead, lanes, block, mixing)
        mixing.finish[k] = ONE_SPLICE
        if mixing.requests[k]["method"] != SPLICE:
            mixing.finish[k] = MIXED
            for part in range(col.PARTS):
                mixing.shares[k, part] = 1.0
    elif is_masked(bank, s, c):
        mask_action(bank, limbs, s, c, k, ahead, ahead_own, lanes, block, mixing, character, rotations)
        return
    else:
        mixing.finish[k] = MIXED
        mix_actions(bank, limbs, s, c, count, k, ahead, ahead_own, lanes, block, mixing)
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
def is_masked(bank: BankArrays, s: Array, c: int) -> bool:
    """Whether one action alone gives limbs, and the locomotions all else."""
    slot = c + col.FIRST_ACTION
    return (
        s[c + col.ACTIONS] == 1.0
        and s[slot + col.KIND] == SPLICE
        and int(s[slot + col.MASK]) & col.TRUNK == 0
        and s[slot + col.ELAPSED] >= s[slot + col.LASTING]
        and s[slot + col.WEIGHT] == 1.0
        and not is_added(bank, s, slot)
    )


@inlined
def mask_action(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    c: int,
    k: int,
    ahead: Index,
    ahead_own: Index,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    character: int,
    rotations: Array,
) -> None:
    """Writes the joints of the locomotions' own upper half into the pose, and those of an action where its mask is.

    Prepares the action's splice in lane k of the block.
    """
    rig, mask = bank.rig, int(s[c + col.FIRST_ACTION + col.MASK])
    above, own = np.uint64(4) * rig[arrays.LOWER_WIDTH], np.uint64(4) * rig[arrays.OWN_UPPER]
    sample_own(bank, s, c, ahead_own, lanes, own, mixing)
    sample_action(bank, s, c, 0, k, ahead, lanes, block, mixing)
    keep_limbs(limbs, mask, lanes, above, k, mixing)
    for part in range(col.PARTS):
        mixing.shares[k, part] = mask >> part & 1
    mixing.finish[k] = ONLY_LIMBS
    first = np.uint64(arrays.COLUMNS) + rig[arrays.LOWER_COUNT]
    above, own = above + np.uint64(4 * FIRST_JOINT), own + np.uint64(4 * FIRST_JOINT)
    for joint in range(np.uint64(len(limbs.bits))):
        at = above if mask & limbs.bits[joint] else own
        copy_rotation(lanes, at + np.uint64(4) * joint, rotations, character, rig[first + joint])


@inlined
def sample_summand(
    bank: BankArrays,
    s: Array,
    c: int,
    number: int,
    k: int,
    ahead: Index,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    source: int,
) -> None:
    """Makes an action's upper half a source, and prepares its splice in lane k of the block."""
    rig, slot = bank.rig, action_slot(c, number)
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    row, t = row_of_action(bank, s, slot)
    in_planes = is_bare(bank, s, c, int(s[slot + col.CLIP])) and not is_added(bank, s, slot)
    in_planes &= int(s[slot + col.MASK]) & col.TRUNK != 0
    if in_planes:
        sample_planes(
            bank.upper, row, ahead, rig[arrays.FIRST_PLANE], width, np.float32(t), mixing.planes, plane_of(source)
        )
        copy_to_lanes(mixing, source, np.uint64(PELVIS), lanes, above)
        copy_to_lanes(mixing, source, np.uint64(TORSO_OFFSET), lanes, above)
    else:
        sample_half(bank, s, c, int(s[slot + col.CLIP]), row, ahead, np.float32(t), lanes, above)
    prepare_splice(bank, s, c, number, k, row, t, lanes, block, mixing)
    if not in_planes:
        split_lanes(lanes, above, width, mixing, source)
    fetch_cloud(bank.upper, ahead, rig[arrays.FIRST_PLANE])


@inlined
def mix_actions(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    c: int,
    count: int,
    k: int,
    ahead: Index,
    ahead_own: Index,
    lanes: Array,
    block: Array,
    mixing: Mixing,
) -> None:
    """Mixes the upper halves of locomotions and actions into lanes, each part by its shares."""
    rig = bank.rig
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    share_parts(s, c, count, mixing.weights)
    sources = sample_own_summand(bank, limbs, s, c, count, ahead_own, lanes, mixing)
    for number in range(count):
        slot = action_slot(c, number)
        mixing.requests[k + number]["method"] = 0
        if s[slot + col.KIND] != col.OWN:
            sample_summand(bank, s, c, number, k + number, ahead, lanes, block, mixing, sources)
            apart = is_apart(s, slot, k + number, mixing)
            if apart:
                keep_limbs(limbs, int(s[slot + col.MASK]), lanes, above, k + number, mixing)
                mixing.finish[k] = LIMBS
            set_part_weights(limbs, width, mixing, sources, number + 1, apart)
            sources += 1
    mix_lanes(mixing, sources, width, lanes, above)


@inlined
def sample_own_summand(
    bank: BankArrays, limbs: Limbs, s: Array, c: int, count: int, ahead: Index, lanes: Array, mixing: Mixing
) -> int:
    """Makes the locomotions' own upper half the first source, if any of it is visible; returns the number of sources.

    If any action is added to it, keeps it in lanes too.
    """
    rig, slot = bank.rig, locomotion_slot(c, 0)
    width, clip, visible, kept = rig[arrays.UPPER_WIDTH], int(s[slot + col.CLIP]), False, False
    for part in range(col.PARTS):
        visible |= mixing.weights[part] != 0.0
    for number in range(count):
        kept |= is_added(bank, s, action_slot(c, number))
    if visible and not kept and s[c + col.LOCOMOTIONS] == 1.0 and is_bare(bank, s, c, clip):
        row, t = row_of(bank, clip, s[slot + col.FRAME])
        sample_planes(bank.upper, row, ahead, rig[arrays.FIRST_PLANE], width, np.float32(t), mixing.planes, plane_of(0))
    elif visible or kept:
        own = np.uint64(4) * rig[arrays.OWN_UPPER]
        sample_own(bank, s, c, ahead, lanes, own, mixing)
        split_lanes(lanes, own, width, mixing, 0)
    if visible:
        set_part_weights(limbs, width, mixing, 0, 0, False)
    return 1 if visible else 0


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
def set_part_weights(limbs: Limbs, width: Index, mixing: Mixing, source: int, layer: int, apart: bool) -> None:
    """Sets the weight of each lane of a source to the share of its part in a layer: 0, the locomotions; then actions.

    If the layer owns limbs `apart` from the trunk, their attachments get weight 0: `turn_limbs` sets them.
    """
    begin, whole = col.PARTS * layer, not apart
    for part in range(1, col.PARTS):
        whole &= mixing.weights[begin + part] == mixing.weights[begin]
    if whole:
        set_lane_weights(mixing, source, width, np.float32(mixing.weights[begin]))
        return
    parts, weights = limbs.part_lanes, mixing.weights[begin : begin + col.PARTS]
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        weight = spread(np.float32(weights[0])) * load(parts, 0, lane)
        for part in range(1, col.PARTS):
            weight = weight + spread(np.float32(weights[part])) * load(parts, part, lane)
        store(mixing.lane_weights, source, lane, weight)
    if apart:
        for part in range(1, col.PARTS):
            if limbs.lengths[part] > 0:
                mixing.lane_weights[source, limbs.attachments[part]] = np.float32(0.0)
