"""Evaluates the poses of characters by mixing their slots.

Lower bodies are mixed first, so that each action is spliced onto the mixed lower body. Upper bodies are mixed next,
part by part. One locomotion and one action without a fade take a path without mixing. Poses are then turned to targets.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aimed_pose_kernels import turn_to_targets
from motionsplice.runtime.characters.arrays import Mixing, StageArrays
from motionsplice.runtime.characters.lock_kernels import lock_feet
from motionsplice.runtime.characters.mixing_kernels import add_cloud, add_lanes, normalise_lanes, set_lane_weights
from motionsplice.runtime.characters.slots import action_slot, hands_slot, locomotion_slot
from motionsplice.runtime.characters.transition_kernels import in_turned_frame
from motionsplice.runtime.characters.turning_kernels import turn_limbs, turn_pelvis
from motionsplice.runtime.characters.upper_kernels import mix_upper, row_of_action
from motionsplice.runtime.format.rows import FIRST_JOINT, PELVIS, ROOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, ROW_L, SHARE_L, BankArrays
from motionsplice.runtime.kernels.evaluate import copy_lower, copy_rotation
from motionsplice.runtime.kernels.lookup import between_rows, fetch_ahead, fetch_hands, is_mirrored
from motionsplice.runtime.kernels.mirror import mirror_lower
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.posture import turn_pelves
from motionsplice.runtime.kernels.rotations import ONE, sample
from motionsplice.runtime.simd.compiled import ZERO, Array, Index, inlined, kernel
from motionsplice.runtime.simd.handle import Handle, record_at


@kernel
def evaluate_characters(handle: Handle, s: Array, share: float, roots: Array, rotations: Array) -> None:
    """Writes each character's root position [n, 3] and local rotations [n, 4 J]. handle is that of StageArrays."""
    bank, _, limbs, chains, legs, scratch, mixing = record_at(handle, StageArrays)
    lanes, block = scratch.lanes[0], scratch.block[0]
    first = 0
    while first < len(roots):
        stop, taken = first, 0
        while stop < len(roots) and taken + lanes_of(s, stop * col.COLUMNS) <= BLOCK:
            taken += lanes_of(s, stop * col.COLUMNS)
            fetch_slots(bank, s, stop * col.COLUMNS)
            stop += 1
        k = splices = ZERO
        for character in range(first, stop):
            c = character * col.COLUMNS
            mix_lower(bank, s, c, k, lanes, block, mixing, character, roots, rotations)
            mix_upper(bank, limbs, s, c, k, lanes, block, mixing, character, rotations)
            splices += int(s[c + col.ACTIONS])
            k += lanes_of(s, c)
        if splices > 0:
            turn_pelves(bank, mixing.requests, mixing.memory, share, block, ZERO, k)
            k = ZERO
            for character in range(first, stop):
                c = character * col.COLUMNS
                if s[c + col.ACTIONS] > 0.0:
                    turn_pelvis(bank, s, c, k, block, mixing, character, rotations)
                    if mixing.limbs_turn[k] > 0:
                        turn_limbs(bank, limbs, s, c, k, block, mixing, character, rotations)
                k += lanes_of(s, c)
        for character in range(first, stop):
            c = character * col.COLUMNS
            if s[c + col.AIMED] > 0.0:
                turn_to_targets(chains, s, c, character, roots, rotations)
            if s[c + col.LOCKED] > 0.0:
                lock_feet(legs, s, c, character, roots, rotations)
        first = stop


@inlined
def lanes_of(s: Array, c: int) -> int:
    """Returns the number of lanes of a block that a character needs: one for each action, at least one."""
    return max(int(s[c + col.ACTIONS]), 1)


@inlined
def fetch_slots(bank: BankArrays, s: Array, c: int) -> None:
    """Prefetches the rows of all slots of a character."""
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion_slot(c, number)
        clip = int(s[slot + col.CLIP])
        row, _ = row_of(bank, clip, s[slot + col.FRAME])
        fetch_ahead(bank.lower, row)
        if s[c + col.ACTIONS] == 0.0:
            fetch_ahead(bank.upper, row)
            fetch_worn(bank, s, c, clip, row)
    for number in range(int(s[c + col.ACTIONS])):
        slot = action_slot(c, number)
        if s[slot + col.KIND] != col.OWN:
            row, _ = row_of_action(bank, s, slot)
            fetch_ahead(bank.upper, row)
            fetch_worn(bank, s, c, int(s[slot + col.CLIP]), row)


@inlined
def fetch_worn(bank: BankArrays, s: Array, c: int, clip: int, row: Index) -> None:
    """Prefetches the rows of all hands that a character wears on a clip."""
    for number in range(int(s[c + col.HANDS])):
        fetch_hands(bank, int(s[hands_slot(c, number) + col.CLIP]), clip, row)


@inlined
def mix_lower(
    bank: BankArrays,
    s: Array,
    c: int,
    k: int,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    character: int,
    roots: Array,
    rotations: Array,
) -> None:
    """Mixes the lower halves of all locomotions into lanes, and writes root and joints into the pose."""
    rig = bank.rig
    count, width, planes = int(s[c + col.LOCOMOTIONS]), rig[arrays.LOWER_WIDTH], rig[arrays.FIRST_PLANE]
    first_joint = np.uint64(4 * FIRST_JOINT)
    x = y = z = 0.0
    for number in range(count):
        slot = locomotion_slot(c, number)
        clip, frame = int(s[slot + col.CLIP]), s[slot + col.FRAME]
        row, t = row_of(bank, clip, frame)
        px, py, pz = s[slot + col.PATH], s[slot + col.PATH + 1], s[slot + col.PATH + 2]
        t32 = np.float32(t)
        sample(bank.lower, row, planes, width, t32, lanes, np.uint64(0))
        dx = between_rows(bank.lower, row, np.uint64(ROOT), t32)
        if is_mirrored(bank, clip):
            dx = -dx
            mirror_lower(bank, lanes)
        dx -= px
        dz = between_rows(bank.lower, row, np.uint64(ROOT + 2), t32) - pz
        share = s[slot + col.SHARE] if count > 1 else 1.0
        sin, cos = s[slot + col.PATH_SIN], s[slot + col.PATH_COS]
        dx, dz = in_turned_frame(sin, cos, dx, dz)
        x, z = x + share * dx, z + share * dz
        y += share * (between_rows(bank.lower, row, np.uint64(ROOT + 1), t32) - py)
        turn_about_y(lanes, first_joint, -sin, cos)
        if count == 1:
            block[ROW_L * BLOCK + k], block[SHARE_L * BLOCK + k] = row, t
        else:
            set_lane_weights(mixing.lane_weights, width, np.float32(share))
            add_lanes(lanes, np.uint64(0), width, mixing, number == 0)
            mirrored = is_mirrored(bank, clip)
            add_cloud(bank, row, t32, np.float32(share), mirrored, mixing.row, number == 0)
    if count > 1:
        normalise_lanes(mixing.sum, np.uint64(0), width, lanes)
        block[ROW_L * BLOCK + k] = block[SHARE_L * BLOCK + k] = 0.0
    if s[c + col.IN_PLACE] == 0.0:
        sin, cos = s[c + col.SIN], s[c + col.COS]
        turn_about_y(lanes, first_joint, sin, cos)
        x, z = in_turned_frame(-sin, cos, x, z)
        x, y, z = x + s[c + col.PLACE], y + s[c + col.PLACE + 1], z + s[c + col.PLACE + 2]
    roots[character, 0], roots[character, 1], roots[character, 2] = x, y, z
    copy_lower(rig, lanes, rotations, character)
    copy_rotation(lanes, np.uint64(4 * PELVIS), rotations, character, rig[arrays.PELVIS_COLUMN])


@inlined
def turn_about_y(lanes: Array, at: Index, sin: float, cos: float) -> None:
    """Turns a rotation in lanes about Y by twice the angle of sin and cos."""
    x, y, z, w = lanes[at], lanes[at + ONE], lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE]
    lanes[at], lanes[at + ONE] = cos * x + sin * z, cos * y + sin * w
    lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE] = cos * z - sin * x, cos * w - sin * y
