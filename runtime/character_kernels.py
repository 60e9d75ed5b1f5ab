"""The poses of characters: what their slots give, mixed.

As `runtime.kernels`: nothing here checks, allocates or holds the GIL. Lower bodies are mixed first, so that each action
is laid on the lower body that is shown; then upper bodies, part by part. Of one locomotion and one action, neither of
them fading, nothing is mixed.
"""

from __future__ import annotations

import math

import numpy as np

from runtime import arrays
from runtime import character_state as col
from runtime.arrays import BLOCK, ROW_L, ROW_U, SHARE_L, SHARE_U, SPLICED, BankArrays, Limbs, Mixing, Scratch
from runtime.compiled import LANES, ZERO, Array, Index, Real, inlined, kernel
from runtime.hand_kernels import wear_hands
from runtime.kernels import copy_lower, copy_rotation, copy_upper
from runtime.lanes import interleave, load, root, separate, signed, spread, store
from runtime.lookup_kernels import NAIVE, SPLICE, fetch_ahead, fetch_hands, locate, repeated
from runtime.posture_kernels import ABSOLUTE, GIVEN, RUNNING, between_rows, correlate, mixed, turn_pelves
from runtime.rotation_kernels import ONE, TINY, product, sample
from runtime.rows import CLOUD, FIRST_JOINT, PELVIS, ROOT, SIZE
from runtime.transition_kernels import action, faded, hands, locomotion, row_of, seen

FOUR = np.uint64(4)  # numbers of a rotation


@kernel
def evaluate_characters(
    bank: BankArrays,
    limbs: Limbs,
    s: Array,
    share: float,
    scratch: Scratch,
    mixing: Mixing,
    roots: Array,
    rotations: Array,
) -> None:
    """Writes each character's root position [n, 3] and local rotations [n, 4 J]."""
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
        first = stop


@inlined
def lanes_of(s: Array, c: int) -> int:
    """Lanes of a block that a character takes: one for each action, and one without."""
    return max(int(s[c + col.ACTIONS]), 1)


@inlined
def fetch_slots(bank: BankArrays, s: Array, c: int) -> None:
    """Has the processor fetch the rows of all slots."""
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion(c, number)
        clip = int(s[slot + col.CLIP])
        row, _ = row_of(bank, clip, s[slot + col.FRAME])
        fetch_ahead(bank.lower, row)
        if s[c + col.ACTIONS] == 0.0:
            fetch_ahead(bank.upper, row)
            fetch_worn(bank, s, c, clip, row)
    for number in range(int(s[c + col.ACTIONS])):
        slot = action(c, number)
        if s[slot + col.KIND] != col.OWN:
            row, _ = row_of_action(bank, s, slot)
            fetch_ahead(bank.upper, row)
            fetch_worn(bank, s, c, int(s[slot + col.CLIP]), row)


@inlined
def fetch_worn(bank: BankArrays, s: Array, c: int, clip: int, row: Index) -> None:
    """The same of all hands that are worn, on a clip."""
    for number in range(int(s[c + col.HANDS])):
        fetch_hands(bank, int(s[hands(c, number) + col.CLIP]), clip, row)


@inlined
def row_of_action(bank: BankArrays, s: Array, slot: int) -> tuple[np.uint64, float]:
    clip, frame = int(s[slot + col.CLIP]), s[slot + col.FRAME]
    first, count = bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT]
    if s[slot + col.KIND] == NAIVE:
        count = bank.clips[clip, arrays.FRAME_COUNT]
        frame = repeated(frame, count - 1.0)
    return locate(frame, first, count)


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
    """Samples the lower half of all locomotions into lanes, mixed, and writes root and joints into the pose."""
    rig = bank.rig
    count, width, planes = int(s[c + col.LOCOMOTIONS]), rig[arrays.LOWER_WIDTH], rig[arrays.FIRST_PLANE]
    first_joint = np.uint64(4 * FIRST_JOINT)
    x = y = z = 0.0
    for number in range(count):
        slot = locomotion(c, number)
        clip, frame = int(s[slot + col.CLIP]), s[slot + col.FRAME]
        row, t = row_of(bank, clip, frame)
        px, py, pz = s[slot + col.WAY], s[slot + col.WAY + 1], s[slot + col.WAY + 2]
        t32 = np.float32(t)
        sample(bank.lower, row, planes, width, t32, lanes, np.uint64(0))
        dx = between_rows(bank.lower, row, np.uint64(ROOT), t32) - px
        dz = between_rows(bank.lower, row, np.uint64(ROOT + 2), t32) - pz
        share = s[slot + col.SHARE] if count > 1 else 1.0
        sin, cos = s[slot + col.WAY_SIN], s[slot + col.WAY_COS]
        dx, dz = seen(sin, cos, dx, dz)
        x, z = x + share * dx, z + share * dz
        y += share * (between_rows(bank.lower, row, np.uint64(ROOT + 1), t32) - py)
        turn_about_y(lanes, first_joint, -sin, cos)
        if count == 1:
            block[ROW_L * BLOCK + k], block[SHARE_L * BLOCK + k] = row, t
        else:
            weigh_lanes(mixing.lane_weights, width, np.float32(share))
            add_lanes(lanes, np.uint64(0), width, mixing, number == 0)
            add_cloud(bank, row, t32, np.float32(share), mixing.row, number == 0)
    if count > 1:
        normalise_lanes(mixing.sum, np.uint64(0), width, lanes)
        block[ROW_L * BLOCK + k] = block[SHARE_L * BLOCK + k] = 0.0
    if s[c + col.IN_PLACE] == 0.0:
        sin, cos = s[c + col.SIN], s[c + col.COS]
        turn_about_y(lanes, first_joint, sin, cos)
        x, z = seen(-sin, cos, x, z)
        x, y, z = x + s[c + col.PLACE], y + s[c + col.PLACE + 1], z + s[c + col.PLACE + 2]
    roots[character, 0], roots[character, 1], roots[character, 2] = x, y, z
    copy_lower(rig, lanes, rotations, character)
    copy_rotation(lanes, np.uint64(4 * PELVIS), rotations, character, rig[arrays.PELVIS_COLUMN])


@inlined
def turn_about_y(lanes: Array, at: Index, sin: float, cos: float) -> None:
    """A rotation in lanes, turned about Y by twice the angle of sin and cos."""
    x, y, z, w = lanes[at], lanes[at + ONE], lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE]
    lanes[at], lanes[at + ONE] = cos * x + sin * z, cos * y + sin * w
    lanes[at + ONE + ONE], lanes[at + ONE + ONE + ONE] = cos * z - sin * x, cos * w - sin * y


@inlined
def add_lanes(lanes: Array, first: Index, width: Index, mixing: Mixing, new: bool) -> None:
    """Adds rotations, each with a weight of its own, to the sum, by the shorter way round."""
    weights, total = mixing.lane_weights, mixing.sum
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = separate(lanes, first + FOUR * lane)
        weight = load(weights, 0, lane)
        if new:
            x, y, z, w = weight * x, weight * y, weight * z, weight * w
        else:
            sx, sy, sz, sw = load(total, 0, lane), load(total, 1, lane), load(total, 2, lane), load(total, 3, lane)
            weight = signed(weight, (sx * x + sy * y) + (sz * z + sw * w))
            x, y, z, w = sx + weight * x, sy + weight * y, sz + weight * z, sw + weight * w
        store(total, 0, lane, x)
        store(total, 1, lane, y)
        store(total, 2, lane, z)
        store(total, 3, lane, w)


@inlined
def normalise_lanes(total: Array, first: Index, width: Index, out: Array) -> None:
    """The rotations of a sum into lanes."""
    one, least = spread(np.float32(1.0)), spread(np.float32(1e-30))
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        x, y, z, w = load(total, 0, lane), load(total, 1, lane), load(total, 2, lane), load(total, 3, lane)
        scale = one / root(least + ((x * x + y * y) + (z * z + w * w)))
        interleave(out, first + FOUR * lane, x * scale, y * scale, z * scale, w * scale)


@inlined
def add_cloud(bank: BankArrays, row: Index, t: Real, weight: Real, total: Array, new: bool) -> None:
    """Adds the cloud of a row of `lower`, and its size, to a row of the same form."""
    size = weight * between_rows(bank.lower, row, np.uint64(SIZE), t)
    total[0, SIZE] = size if new else total[0, SIZE] + size
    for column in range(
        np.uint64(CLOUD), np.uint64(CLOUD) + np.uint64(3) * bank.rig[arrays.CLOUD_WIDTH], np.uint64(LANES)
    ):
        value = spread(weight) * mixed(bank.lower, row, column, t)
        store(total, 0, column, value if new else value + load(total, 0, column))


@inlined
def weigh_lanes(weights: Array, width: Index, weight: Real) -> None:
    """The same weight for all lanes."""
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        store(weights, 0, lane, spread(weight))


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
    """Samples the upper half of all that gives some of it into lanes, mixed, and writes its joints into the pose;
    prepares the splices of actions, each in a lane of the block."""
    rig, count = bank.rig, int(s[c + col.ACTIONS])
    above = np.uint64(4) * rig[arrays.LOWER_WIDTH]
    mixing.requests[k]["method"], mixing.limbs_turn[k] = 0, 0
    if count == 0:
        sample_own(bank, s, c, lanes, mixing)
    elif is_plain(s, c):
        sample_action(bank, s, c, 0, k, lanes, block, mixing)
        for part in range(col.PARTS):
            mixing.weights[col.PARTS + part] = 1.0
    else:
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
def sample_own(bank: BankArrays, s: Array, c: int, lanes: Array, mixing: Mixing) -> None:
    """The locomotions' own upper half into lanes."""
    rig, count = bank.rig, int(s[c + col.LOCOMOTIONS])
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    for number in range(count):
        slot = locomotion(c, number)
        clip = int(s[slot + col.CLIP])
        row, t = row_of(bank, clip, s[slot + col.FRAME])
        sample(bank.upper, row, rig[arrays.FIRST_PLANE], width, np.float32(t), lanes, above)
        if s[c + col.HANDS] > 0.0:
            wear_hands(bank, s, c, clip, row, np.float32(t), lanes, above)
        if count > 1:
            weigh_lanes(mixing.lane_weights, width, np.float32(s[slot + col.SHARE]))
            add_lanes(lanes, above, width, mixing, number == 0)
    if count > 1:
        normalise_lanes(mixing.sum, above, width, lanes)


@inlined
def sample_action(
    bank: BankArrays, s: Array, c: int, number: int, k: int, lanes: Array, block: Array, mixing: Mixing
) -> None:
    """An action's upper half into lanes, and what its splice needs into lane k of the block."""
    rig, slot = bank.rig, action(c, number)
    above, first = np.uint64(4) * rig[arrays.LOWER_WIDTH], k - number
    row, t = row_of_action(bank, s, slot)
    sample(bank.upper, row, rig[arrays.FIRST_PLANE], rig[arrays.UPPER_WIDTH], np.float32(t), lanes, above)
    if s[c + col.HANDS] > 0.0:
        wear_hands(bank, s, c, int(s[slot + col.CLIP]), row, np.float32(t), lanes, above)
    block[ROW_U * BLOCK + k], block[SHARE_U * BLOCK + k] = row, t
    request, kind = mixing.requests[k], int(s[slot + col.KIND])
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
            correlate(bank, mixing.row, block, k, lanes, above)
            if request["posture"] == ABSOLUTE:
                mix_postures(bank, s, c, k, mixing)
        else:
            block[ROW_L * BLOCK + k] = block[ROW_L * BLOCK + first]
            block[SHARE_L * BLOCK + k] = block[SHARE_L * BLOCK + first]
            correlate(bank, bank.lower, block, k, lanes, above)
    elif kind == NAIVE:
        for i in range(4):
            block[(SPLICED + i) * BLOCK + k] = 0.0
            mixing.kept[k, i] = lanes[above + np.uint64(4 * PELVIS + i)]


@kernel
def mix_postures(bank: BankArrays, s: Array, c: int, k: int, mixing: Mixing) -> None:
    """The posture that locomotions have stored, mixed, for an action that is turned from there."""
    mixing.requests[k]["posture"] = GIVEN
    for i in range(6):
        mixing.memory[k, arrays.MEAN_POSTURE + i] = 0.0
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion(c, number)
        for i in range(6):
            stored = bank.clips[int(s[slot + col.CLIP]), arrays.POSTURE + i]
            mixing.memory[k, arrays.MEAN_POSTURE + i] += s[slot + col.SHARE] * stored


@kernel
def mix_actions(
    bank: BankArrays, limbs: Limbs, s: Array, c: int, count: int, k: int, lanes: Array, block: Array, mixing: Mixing
) -> None:
    """The upper halves of locomotions and actions into lanes, each part by the shares of those that own it."""
    rig = bank.rig
    above, width = np.uint64(4) * rig[arrays.LOWER_WIDTH], rig[arrays.UPPER_WIDTH]
    weigh_actions(s, c, count, mixing.weights)
    new = True
    for part in range(col.PARTS):
        new &= mixing.weights[part] == 0.0
    if not new:
        sample_own(bank, s, c, lanes, mixing)
        weigh_parts(limbs, width, mixing, 0, False)
        add_lanes(lanes, above, width, mixing, True)
    for number in range(count):
        slot = action(c, number)
        mixing.requests[k + number]["method"] = 0
        if s[slot + col.KIND] != col.OWN:
            sample_action(bank, s, c, number, k + number, lanes, block, mixing)
            apart = is_apart(s, slot)
            if apart:
                keep_limbs(bank, limbs, lanes, above, k + number, mixing)
                mixing.limbs_turn[k] = 1
            weigh_parts(limbs, width, mixing, number + 1, apart)
            add_lanes(lanes, above, width, mixing, new)
            new = False
    normalise_lanes(mixing.sum, above, width, lanes)


@inlined
def weigh_actions(s: Array, c: int, count: int, weights: Array) -> None:
    """What share of each part [PARTS] the locomotions' own upper body has, then each action; from the top down, so that
    the row after them holds what is left for those below."""
    left = col.PARTS * (count + 1)
    for part in range(col.PARTS):
        weights[part], weights[left + part] = 0.0, 1.0
    for number in range(count - 1, -1, -1):
        slot, at = action(c, number), col.PARTS * (number + 1)
        mask, risen = int(s[slot + col.MASK]), faded(s[slot + col.ELAPSED], s[slot + col.LASTING], s[slot + col.CURVE])
        given = 0.0 if s[slot + col.KIND] == col.OWN else s[slot + col.WEIGHT]
        for part in range(col.PARTS):
            share = weights[left + part] * (risen if mask >> part & 1 else 0.0)
            weights[left + part] -= share
            weights[part] += share * (1.0 - given)
            weights[at + part] = share * given
    for part in range(col.PARTS):
        weights[part] += weights[left + part]


@inlined
def weigh_parts(limbs: Limbs, width: Index, mixing: Mixing, source: int, apart: bool) -> None:
    """The weight of its part for each lane of an upper half; but none, if limbs are turned apart, for the joints by
    which they hang on the trunk."""
    begin, whole = col.PARTS * source, not apart
    for part in range(1, col.PARTS):
        whole &= mixing.weights[begin + part] == mixing.weights[begin]
    if whole:
        weigh_lanes(mixing.lane_weights, width, np.float32(mixing.weights[begin]))
        return
    for lane in range(width):
        mixing.lane_weights[0, lane] = np.float32(mixing.weights[begin + limbs.part_of_lane[lane]])
    if apart:
        for part in range(1, col.PARTS):
            if limbs.lengths[part] > 0:
                mixing.lane_weights[0, limbs.attachments[part]] = np.float32(0.0)


@kernel
def keep_limbs(bank: BankArrays, limbs: Limbs, lanes: Array, above: Index, k: int, mixing: Mixing) -> None:
    """How each limb's attachment is turned against the pelvis in an action's own upper half."""
    for part in range(1, col.PARTS):
        x, y, z, w = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(1.0)
        for number in range(limbs.lengths[part]):
            at = above + np.uint64(4 * limbs.chains[part, number])
            x, y, z, w = product(
                x, y, z, w, lanes[at], lanes[at + np.uint64(1)], lanes[at + np.uint64(2)], lanes[at + np.uint64(3)]
            )
        to = 4 * part
        mixing.kept[k, to], mixing.kept[k, to + 1], mixing.kept[k, to + 2], mixing.kept[k, to + 3] = x, y, z, w


@inlined
def turn_pelvis(
    bank: BankArrays, s: Array, c: int, k: int, block: Array, mixing: Mixing, character: int, rotations: Array
) -> None:
    """The pelvis of a pose, which is the locomotion's, by the shares of the actions; and what they remember."""
    column, count, own = bank.rig[arrays.PELVIS_COLUMN], int(s[c + col.ACTIONS]), 1.0
    for number in range(count):
        own -= mixing.shares[k + number, 0]
    ax, ay = rotations[character, column], rotations[character, column + np.uint64(1)]
    az, aw = rotations[character, column + np.uint64(2)], rotations[character, column + np.uint64(3)]
    own = max(own, 0.0) if own > 1e-9 else 0.0
    x, y, z, w = own * ax, own * ay, own * az, own * aw
    for number in range(count):
        lane, slot, share = k + number, action(c, number), mixing.shares[k + number, 0]
        kind = s[slot + col.KIND]
        if kind == SPLICE:
            keep_memory(s, slot, lane, mixing)
            bx, by = block[SPLICED * BLOCK + lane], block[(SPLICED + 1) * BLOCK + lane]
            bz, bw = block[(SPLICED + 2) * BLOCK + lane], block[(SPLICED + 3) * BLOCK + lane]
        else:
            bx, by, bz, bw = mixing.kept[lane, 0], mixing.kept[lane, 1], mixing.kept[lane, 2], mixing.kept[lane, 3]
        if kind != col.OWN and share > 0.0:
            signed = share if x * bx + y * by + z * bz + w * bw >= 0.0 else -share
            x, y, z, w = x + signed * bx, y + signed * by, z + signed * bz, w + signed * bw
    scale = 1.0 / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
    rotations[character, column], rotations[character, column + np.uint64(1)] = x * scale, y * scale
    rotations[character, column + np.uint64(2)], rotations[character, column + np.uint64(3)] = z * scale, w * scale


@inlined
def keep_memory(s: Array, slot: int, lane: int, mixing: Mixing) -> None:
    """Gives a slot back what the evaluator remembers of its splice."""
    for column in range(arrays.MEAN_POSTURE):
        s[slot + col.REMEMBERED + column] = mixing.memory[lane, column]
    if mixing.requests[lane]["posture"] == RUNNING:
        for column in range(arrays.MEAN_POSTURE, arrays.MEMORY_COLUMNS):
            s[slot + col.REMEMBERED + column] = mixing.memory[lane, column]


@kernel
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
    """Turns the attachments of limbs that an action owns without the trunk, so that they are to the pelvis as they
    would be if it owned all: Heck's three steps at another joint (their section 5)."""
    pelvis = bank.rig[arrays.PELVIS_COLUMN]
    for part in range(1, col.PARTS):
        length, rest = limbs.lengths[part], 1.0  # the share of what is in the pose already
        for number in range(int(s[c + col.ACTIONS])):
            rest -= mixing.shares[k + number, part] if is_apart(s, action(c, number)) else 0.0
        rest = max(rest, 0.0)
        for number in range(int(s[c + col.ACTIONS])):
            lane, slot = k + number, action(c, number)
            share = mixing.shares[lane, part]
            if length > 0 and share > 0.0 and is_apart(s, slot):
                x, y, z, w = quaternion_at(rotations, character, pelvis)
                for joint in range(length - 1):
                    qx, qy, qz, qw = quaternion_at(rotations, character, limbs.columns[part, joint])
                    x, y, z, w = product(x, y, z, w, qx, qy, qz, qw)
                px, py = block[SPLICED * BLOCK + lane], block[(SPLICED + 1) * BLOCK + lane]
                pz, pw = block[(SPLICED + 2) * BLOCK + lane], block[(SPLICED + 3) * BLOCK + lane]
                at = 4 * part
                tx, ty, tz, tw = product(
                    px,
                    py,
                    pz,
                    pw,
                    mixing.kept[lane, at],
                    mixing.kept[lane, at + 1],
                    mixing.kept[lane, at + 2],
                    mixing.kept[lane, at + 3],
                )
                x, y, z, w = product(-x, -y, -z, w, tx, ty, tz, tw)
                column = limbs.columns[part, length - 1]
                qx, qy, qz, qw = quaternion_at(rotations, character, column)
                signed = rest if qx * x + qy * y + qz * z + qw * w >= 0.0 else -rest
                x, y, z, w = (
                    share * x + signed * qx,
                    share * y + signed * qy,
                    share * z + signed * qz,
                    share * w + signed * qw,
                )
                scale = 1.0 / math.sqrt(max(x * x + y * y + z * z + w * w, TINY))
                rotations[character, column], rotations[character, column + np.uint64(1)] = x * scale, y * scale
                rotations[character, column + np.uint64(2)] = z * scale
                rotations[character, column + np.uint64(3)] = w * scale
                rest += share


@inlined
def is_apart(s: Array, slot: int) -> bool:
    """Whether an action owns limbs, but not the trunk that they hang on."""
    return s[slot + col.KIND] == SPLICE and int(s[slot + col.MASK]) & col.TRUNK == 0


@inlined
def quaternion_at(rotations: Array, character: int, column: Index) -> tuple[float, float, float, float]:
    return (
        rotations[character, column],
        rotations[character, column + np.uint64(1)],
        rotations[character, column + np.uint64(2)],
        rotations[character, column + np.uint64(3)],
    )
