"""Sets the pelvis of a pose by its actions, and turns limbs that an action owns without the trunk."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Limbs, Mixing
from motionsplice.runtime.characters.slots import LANE, action_slot
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, SPLICED, BankArrays
from motionsplice.runtime.kernels.lookup import SPLICE
from motionsplice.runtime.kernels.posture import RUNNING
from motionsplice.runtime.kernels.rotations import FOUR, TINY, product, quaternion_in
from motionsplice.runtime.simd.compiled import Array, Index, inlined

# of Mixing.finish: the pelvis is the locomotion's; it is that of the only splice; it is mixed; it is mixed, and limbs
# are turned; it is the locomotion's, and limbs are turned
UNTURNED, ONE_SPLICE, MIXED, LIMBS, ONLY_LIMBS = range(5)


@inlined
def set_pelvis(
    bank: BankArrays, s: Array, c: int, k: int, block: Array, mixing: Mixing, character: int, rotations: Array
) -> None:
    """Sets the pelvis of a pose to that of its only splice, and stores the splice's memory."""
    column, k = bank.rig[arrays.PELVIS_COLUMN], k & LANE
    for i in range(4):
        rotations[character, column + np.uint64(i)] = block[(SPLICED + i) * BLOCK + k]
    keep_memory(s, action_slot(c, 0), k, mixing)


@inlined
def turn_pelvis(
    bank: BankArrays, s: Array, c: int, k: int, block: Array, mixing: Mixing, character: int, rotations: Array
) -> None:
    """Mixes the pelvis of a pose, so far the locomotion's, by the shares of actions; stores their memories."""
    column, count, own = bank.rig[arrays.PELVIS_COLUMN], int(s[c + col.ACTIONS]), 1.0
    for number in range(count):
        own -= mixing.shares[k + number, 0]
    ax, ay = rotations[character, column], rotations[character, column + np.uint64(1)]
    az, aw = rotations[character, column + np.uint64(2)], rotations[character, column + np.uint64(3)]
    own = max(own, 0.0) if own > 1e-9 else 0.0
    x, y, z, w = own * ax, own * ay, own * az, own * aw
    for number in range(count):
        lane, slot = (k + number) & LANE, action_slot(c, number)
        share = mixing.shares[lane, 0]
        kind = s[slot + col.KIND]
        if mixing.requests[lane]["method"] == SPLICE:
            keep_memory(s, slot, lane, mixing)
            bx, by = block[SPLICED * BLOCK + lane], block[(SPLICED + 1) * BLOCK + lane]
            bz, bw = block[(SPLICED + 2) * BLOCK + lane], block[(SPLICED + 3) * BLOCK + lane]
        else:
            bx, by, bz, bw = mixing.turns[lane, 0], mixing.turns[lane, 1], mixing.turns[lane, 2], mixing.turns[lane, 3]
        if kind != col.OWN and share > 0.0:
            signed = share if x * bx + y * by + z * bz + w * bw >= 0.0 else -share
            x, y, z, w = x + signed * bx, y + signed * by, z + signed * bz, w + signed * bw
    scale = 1.0 / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
    rotations[character, column], rotations[character, column + np.uint64(1)] = x * scale, y * scale
    rotations[character, column + np.uint64(2)], rotations[character, column + np.uint64(3)] = z * scale, w * scale


@inlined
def keep_memory(s: Array, slot: int, lane: int, mixing: Mixing) -> None:
    """Stores the evaluator's memory of a splice in its slot."""
    for column in range(arrays.MEAN_POSTURE):
        s[slot + col.REMEMBERED + column] = mixing.memory[lane, column]
    if mixing.requests[lane]["posture"] == RUNNING:
        for column in range(arrays.MEAN_POSTURE, arrays.MEMORY_COLUMNS):
            s[slot + col.REMEMBERED + column] = mixing.memory[lane, column]


@inlined
def keep_limbs(limbs: Limbs, mask: int, lanes: Array, above: Index, k: int, mixing: Mixing) -> None:
    """Stores the rotation of the attachment of each limb in a mask, relative to the pelvis, from an action's own upper
    half at `above`."""
    for part in range(1, col.PARTS):
        if not mask >> part & 1:
            continue
        x, y, z, w = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(1.0)
        for number in range(limbs.lengths[part]):
            qx, qy, qz, qw = quaternion_in(lanes, above + FOUR * np.uint64(limbs.chains[part, number]))
            x, y, z, w = product(x, y, z, w, qx, qy, qz, qw)
        to = 4 * part
        mixing.turns[k, to], mixing.turns[k, to + 1], mixing.turns[k, to + 2], mixing.turns[k, to + 3] = x, y, z, w


@inlined
def turn_limbs(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    c: int,
    k: int,
    block: Array,
    mixing: Mixing,
    character: int,
    rotations: Array,
) -> None:
    """Turns the attachments of limbs that an action owns without the trunk.

    Afterwards their orientation relative to the pelvis is the same as if the action owned the whole upper body: the
    three steps of Heck et al. at another joint (their section 5).
    """
    count = int(s[c + col.ACTIONS])
    for number in range(count):
        lane, slot = (k + number) & LANE, action_slot(c, number)
        if is_apart(s, slot, lane, mixing):
            for part in range(1, col.PARTS):
                share = mixing.shares[lane, part]
                if limbs.lengths[part] > 0 and share > 0.0:
                    rest = share_below(s, c, k, number, count, part, mixing)
                    turn_limb(bank, limbs, part, lane, share, rest, block, mixing, character, rotations)


@inlined
def share_below(s: Array, c: int, k: int, number: int, count: int, part: int, mixing: Mixing) -> float:
    """Returns the share of the pose so far when the limb of action `number` is added to it."""
    rest = 1.0
    for other in range(count):
        lane = (k + other) & LANE
        rest -= mixing.shares[lane, part] if is_apart(s, action_slot(c, other), lane, mixing) else 0.0
    rest = max(rest, 0.0)
    for other in range(number):
        lane = (k + other) & LANE
        rest += mixing.shares[lane, part] if is_apart(s, action_slot(c, other), lane, mixing) else 0.0
    return rest


@inlined
def turn_limb(
    bank: BankArrays,
    limbs: Limbs,
    part: int,
    lane: int,
    share: float,
    rest: float,
    block: Array,
    mixing: Mixing,
    character: int,
    rotations: Array,
) -> None:
    """Mixes the attachment of a limb: of the pose so far by `rest`, of the action in a lane by `share`."""
    length, at = limbs.lengths[part], 4 * part
    x, y, z, w = quaternion_at(rotations, character, bank.rig[arrays.PELVIS_COLUMN])
    for joint in range(length - 1):
        qx, qy, qz, qw = quaternion_at(rotations, character, limbs.columns[part, joint])
        x, y, z, w = product(x, y, z, w, qx, qy, qz, qw)
    px, py = block[SPLICED * BLOCK + lane], block[(SPLICED + 1) * BLOCK + lane]
    pz, pw = block[(SPLICED + 2) * BLOCK + lane], block[(SPLICED + 3) * BLOCK + lane]
    qx, qy = mixing.turns[lane, at], mixing.turns[lane, at + 1]
    qz, qw = mixing.turns[lane, at + 2], mixing.turns[lane, at + 3]
    tx, ty, tz, tw = product(px, py, pz, pw, qx, qy, qz, qw)
    x, y, z, w = product(-x, -y, -z, w, tx, ty, tz, tw)
    column = limbs.columns[part, length - 1]
    qx, qy, qz, qw = quaternion_at(rotations, character, column)
    signed = rest if qx * x + qy * y + qz * z + qw * w >= 0.0 else -rest
    x, y, z, w = share * x + signed * qx, share * y + signed * qy, share * z + signed * qz, share * w + signed * qw
    scale = 1.0 / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
    rotations[character, column], rotations[character, column + np.uint64(1)] = x * scale, y * scale
    rotations[character, column + np.uint64(2)], rotations[character, column + np.uint64(3)] = z * scale, w * scale


@inlined
def is_apart(s: Array, slot: int, lane: int, mixing: Mixing) -> bool:
    """Whether an action owns limbs but not the trunk, and is laid on the locomotion by its shoulders."""
    return mixing.requests[lane]["method"] == SPLICE and int(s[slot + col.MASK]) & col.TRUNK == 0


@inlined
def quaternion_at(rotations: Array, character: int, column: Index) -> tuple[float, float, float, float]:
    """Returns a rotation of a pose."""
    return (
        rotations[character, column],
        rotations[character, column + np.uint64(1)],
        rotations[character, column + np.uint64(2)],
        rotations[character, column + np.uint64(3)],
    )
