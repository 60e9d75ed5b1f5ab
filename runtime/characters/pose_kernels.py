"""Evaluates the poses of characters by mixing their slots.

Lower bodies are mixed first, so that each action is spliced onto the mixed lower body. Upper bodies are mixed next,
part by part. One locomotion and one action without a fade take a path without mixing. Poses are then turned to targets.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.ahead_kernels import fetch_slots, fetch_unlike
from motionsplice.runtime.characters.aimed_pose_kernels import turn_to_targets
from motionsplice.runtime.characters.arrays import Mixing, StageArrays
from motionsplice.runtime.characters.lock_kernels import lock_feet
from motionsplice.runtime.characters.mixing_kernels import (
    add_cloud,
    mix_lanes,
    plane_of,
    rotation_of,
    set_lane_weights,
    set_rotation,
    split_lanes,
)
from motionsplice.runtime.characters.slots import (
    AHEAD,
    FARTHER,
    action_slot,
    fetch_action,
    fetch_head,
    fetch_state,
    locomotion_slot,
    origin_of,
    row_at,
)
from motionsplice.runtime.characters.transition_kernels import in_turned_frame
from motionsplice.runtime.characters.turning_kernels import (
    LIMBS,
    MIXED,
    ONE_SPLICE,
    ONLY_LIMBS,
    keep_memory,
    set_pelvis,
    turn_limbs,
    turn_pelvis,
)
from motionsplice.runtime.characters.upper_kernels import mix_upper
from motionsplice.runtime.format.rows import FIRST_JOINT, PELVIS, ROOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, ROW_L, SHARE_L, BankArrays
from motionsplice.runtime.kernels.evaluate import copy_lower, copy_rotation
from motionsplice.runtime.kernels.fetching import fetch_cloud, fetch_rows
from motionsplice.runtime.kernels.lookup import between_rows, is_mirrored
from motionsplice.runtime.kernels.mirror import mirror_lower
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.posture import turn_pelves
from motionsplice.runtime.kernels.rotations import ONE, quaternion_in, sample_and_fetch, sample_planes
from motionsplice.runtime.simd.compiled import ZERO, Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.handle import Handle, record_at

Rotation = tuple[Real, Real, Real, Real]


@kernel
def evaluate_characters(handle: Handle, s: Array, share: float, roots: Array, rotations: Array) -> None:
    """Writes each character's root position [n, 3] and local rotations [n, 4 J]. handle is that of StageArrays."""
    bank, _, limbs, chains, legs, scratch, mixing, _ = record_at(handle, StageArrays)
    lanes, block = scratch.lanes[0], scratch.block[0]
    first = 0
    for character in range(min(FARTHER, len(roots))):
        fetch_state(s, row_at(character))
    for character in range(min(AHEAD, len(roots))):
        lower, upper, own = fetch_slots(bank, s, row_at(character))
        fetch_rows(bank.lower, lower)
        fetch_rows(bank.upper, upper)
        fetch_rows(bank.upper, own)
    while first < len(roots):
        stop, taken = first, 0
        while stop < len(roots) and taken + lanes_of(s, row_at(stop)) <= BLOCK:
            taken += lanes_of(s, row_at(stop))
            stop += 1
        k = splices = ZERO
        for character in range(first, stop):
            c = row_at(character)
            if character + FARTHER < len(roots):
                fetch_head(s, row_at(character + FARTHER))
            lower = upper = own = np.uint64(0)
            if character + AHEAD < len(roots):
                lower, upper, own = fetch_slots(bank, s, row_at(character + AHEAD))
                fetch_unlike(bank, s, c, upper, own)
            if s[c + col.LOCOMOTIONS] == 1.0:
                pose_lower(bank, s, c, k, lower, lanes, block, character, roots, rotations)
            else:
                mix_lower(bank, s, c, k, lower, lanes, block, mixing, character, roots, rotations)
            mix_upper(bank, limbs, s, c, k, upper, own, lanes, block, mixing, character, rotations)
            if character + FARTHER < len(roots):
                fetch_action(s, row_at(character + FARTHER))
            splices += int(s[c + col.ACTIONS])
            k += lanes_of(s, c)
        if splices > 0:
            turn_pelves(bank, mixing.requests, mixing.memory, share, block, ZERO, k)
            k = ZERO
            for character in range(first, stop):
                c = row_at(character)
                if mixing.finish[k] == ONE_SPLICE:
                    set_pelvis(bank, s, c, k, block, mixing, character, rotations)
                elif mixing.finish[k] == ONLY_LIMBS:
                    keep_memory(s, action_slot(c, 0), k, mixing)
                elif mixing.finish[k] >= MIXED:
                    turn_pelvis(bank, s, c, k, block, mixing, character, rotations)
                k += lanes_of(s, c)
            k = ZERO
            for character in range(first, stop):
                if mixing.finish[k] >= LIMBS:
                    turn_limbs(bank, limbs, s, row_at(character), k, block, mixing, character, rotations)
                k += lanes_of(s, row_at(character))
        for character in range(first, stop):
            c = row_at(character)
            if s[c + col.AIMED] > 0.0:
                turn_to_targets(chains, s, c, character, roots, rotations)
            if s[c + col.LOCKED] > 0.0:
                lock_feet(legs, s, c, character, roots, rotations)
        first = stop


@inlined
def lanes_of(s: Array, c: int) -> int:
    """Returns the number of lanes of a block that a character needs: one for each action, at least one."""
    count = s[c + col.ACTIONS]  # of a row that may not be in bounds yet
    return int(count) if 1.0 <= count <= col.MOST_ACTIONS else 1


@inlined
def pose_lower(
    bank: BankArrays,
    s: Array,
    c: int,
    k: int,
    ahead: Index,
    lanes: Array,
    block: Array,
    character: int,
    roots: Array,
    rotations: Array,
) -> None:
    """Samples the lower half of the only locomotion into lanes, and writes root and joints into the pose.

    Meanwhile prefetches the row `ahead` and the next one.
    """
    rig, slot = bank.rig, locomotion_slot(c, 0)
    clip = int(s[slot + col.CLIP])
    row, t = row_of(bank, clip, s[slot + col.FRAME])
    t32 = np.float32(t)
    block[ROW_L * BLOCK + k], block[SHARE_L * BLOCK + k] = np.int64(row), t
    sample_and_fetch(bank.lower, row, ahead, rig[arrays.FIRST_PLANE], rig[arrays.LOWER_WIDTH], t32, lanes, np.uint64(0))
    mirrored = is_mirrored(bank, clip)
    if mirrored:
        mirror_lower(bank, lanes)
    x, y, z = root_from_path(bank, s, slot, row, t32, mirrored)
    copy_lower(rig, lanes, rotations, character)
    fetch_cloud(bank.lower, ahead, rig[arrays.FIRST_PLANE])
    copy_rotation(lanes, np.uint64(4 * PELVIS), rotations, character, rig[arrays.PELVIS_COLUMN])
    root = quaternion_in(lanes, np.uint64(4 * FIRST_JOINT))
    root = turned_about_y(root, -s[slot + col.PATH_SIN], s[slot + col.PATH_COS])
    place_root(s, c, x, y, z, root, character, roots, rotations, rig[arrays.COLUMNS])


@inlined
def mix_lower(
    bank: BankArrays,
    s: Array,
    c: int,
    k: int,
    ahead: Index,
    lanes: Array,
    block: Array,
    mixing: Mixing,
    character: int,
    roots: Array,
    rotations: Array,
) -> None:
    """Mixes the lower halves of all locomotions into lanes, and writes root and joints into the pose."""
    rig, width, joint = bank.rig, bank.rig[arrays.LOWER_WIDTH], np.uint64(4 * FIRST_JOINT)
    x, y, z, count = 0.0, 0.0, 0.0, int(s[c + col.LOCOMOTIONS])
    for number in range(count):
        slot = locomotion_slot(c, number)
        clip, share = int(s[slot + col.CLIP]), s[slot + col.SHARE]
        row, t = row_of(bank, clip, s[slot + col.FRAME])
        t32, mirrored = np.float32(t), is_mirrored(bank, clip)
        if mirrored:
            sample_and_fetch(bank.lower, row, ahead, rig[arrays.FIRST_PLANE], width, t32, lanes, np.uint64(0))
            mirror_lower(bank, lanes)
            split_lanes(lanes, np.uint64(0), width, mixing, number)
        else:
            sample_planes(bank.lower, row, ahead, rig[arrays.FIRST_PLANE], width, t32, mixing.planes, plane_of(number))
        dx, dy, dz = root_from_path(bank, s, slot, row, t32, mirrored)
        x, y, z = x + share * dx, y + share * dy, z + share * dz
        root = rotation_of(mixing, number, np.uint64(FIRST_JOINT))
        root = turned_about_y(root, -s[slot + col.PATH_SIN], s[slot + col.PATH_COS])
        set_rotation(mixing, number, np.uint64(FIRST_JOINT), root)
        set_lane_weights(mixing, number, width, np.float32(share))
        add_cloud(bank, row, t32, np.float32(share), mirrored, mixing.row, number == 0)
    mix_lanes(mixing, count, width, lanes, np.uint64(0))
    block[ROW_L * BLOCK + k] = block[SHARE_L * BLOCK + k] = 0.0
    copy_lower(rig, lanes, rotations, character)
    fetch_cloud(bank.lower, ahead, rig[arrays.FIRST_PLANE])
    copy_rotation(lanes, np.uint64(4 * PELVIS), rotations, character, rig[arrays.PELVIS_COLUMN])
    place_root(s, c, x, y, z, quaternion_in(lanes, joint), character, roots, rotations, rig[arrays.COLUMNS])


@inlined
def root_from_path(
    bank: BankArrays, s: Array, slot: int, row: Index, t: Real, mirrored: bool
) -> tuple[float, float, float]:
    """Returns where a locomotion's root is, relative to the root path kept in its slot."""
    x = between_rows(bank.lower, row, np.uint64(ROOT), t)
    if mirrored:
        x = -x
    dx = x - s[slot + col.PATH]
    dy = between_rows(bank.lower, row, np.uint64(ROOT + 1), t) - s[slot + col.PATH + 1]
    dz = between_rows(bank.lower, row, np.uint64(ROOT + 2), t) - s[slot + col.PATH + 2]
    dx, dz = in_turned_frame(s[slot + col.PATH_SIN], s[slot + col.PATH_COS], dx, dz)
    return dx, dy, dz


@inlined
def place_root(
    s: Array,
    c: int,
    x: float,
    y: float,
    z: float,
    root: Rotation,
    character: int,
    roots: Array,
    rotations: Array,
    column: Index,
) -> None:
    """Writes the root into the pose, moved to the character's place and heading unless it plays in place."""
    if s[c + col.IN_PLACE] == 0.0:
        sin, cos = s[c + col.SIN], s[c + col.COS]
        root = turned_about_y(root, sin, cos)
        x, z = in_turned_frame(-sin, cos, x, z)
        x += s[c + col.PLACE] - origin_of(s, c, 0)
        y += s[c + col.PLACE + 1] - origin_of(s, c, 1)
        z += s[c + col.PLACE + 2] - origin_of(s, c, 2)
    roots[character, 0], roots[character, 1], roots[character, 2] = x, y, z
    rotations[character, column], rotations[character, column + ONE] = root[0], root[1]
    rotations[character, column + ONE + ONE], rotations[character, column + ONE + ONE + ONE] = root[2], root[3]


@inlined
def turned_about_y(rotation: Rotation, sin: float, cos: float) -> Rotation:
    """Returns a rotation turned about Y by twice the angle of sin and cos."""
    x, y, z, w = rotation
    return (
        np.float32(cos * x + sin * z),
        np.float32(cos * y + sin * w),
        np.float32(cos * z - sin * x),
        np.float32(cos * w - sin * y),
    )
