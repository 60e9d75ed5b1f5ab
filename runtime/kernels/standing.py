"""Lays the sampled upper half of a standing action on that of a locomotion (docs/method.md)."""

from __future__ import annotations

import math

import numpy as np

from motionsplice.motion.parts import TRUNK
from motionsplice.runtime.format.rows import PELVIS, POSTURE_FRAME, TORSO_OFFSET, USAGE
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.lookup import between_rows, is_mirrored
from motionsplice.runtime.kernels.rotations import FOUR, ONE, TINY, product, quaternion_in
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel
from motionsplice.runtime.simd.lanes import interleave, load, root, separate, signed, spread
from motionsplice.runtime.simd.width import LANES


@kernel
def lay_on(bank: BankArrays, clip: int, row: Index, t: Real, lanes: Array, own: Index, above: Index) -> None:
    """Replaces an action's upper half at `above`, sampled `t` of the way from a row to the next, by the splice's.

    The locomotion's upper half is at `own`, its lower half at 0. Each joint adds its departure from the stance to the
    locomotion's rotation, and is turned from there to the action's own by the usage weight of its part.
    """
    stances, width = bank.stances, bank.rig[arrays.UPPER_WIDTH]
    stance, parts = np.uint64(bank.clips[clip, arrays.STANCE]), np.uint64(len(stances) - 1)
    trunk, left, right, head = usage_of(bank, clip, row, t)
    drives, first = int(bank.clips[clip, arrays.DRIVES]), bank.rig[arrays.FIRST_PLANE]
    px, py, pz, pw = torso_turned(lanes, above, drives & TRUNK > 0)
    y, z, w = first + width, first + width + width, first + width + width + width
    one, least = spread(np.float32(1.0)), spread(np.float32(1e-30))
    for lane in range(np.uint64(0), width, np.uint64(LANES)):
        in_trunk, in_left = load(stances, parts, first + lane), load(stances, parts, y + lane)
        in_right, in_head = load(stances, parts, z + lane), load(stances, parts, w + lane)
        used = in_trunk * spread(trunk) + in_left * spread(left) + in_right * spread(right) + in_head * spread(head)
        driven = in_trunk * spread(bit(drives, 0)) + in_left * spread(bit(drives, 1))
        driven = driven + in_right * spread(bit(drives, 2)) + in_head * spread(bit(drives, 3))
        at = FOUR * lane
        ox, oy, oz, ow = separate(lanes, own + at)
        ux, uy, uz, uw = separate(lanes, above + at)
        sx, sy, sz, sw = (
            load(stances, stance, first + lane),
            load(stances, stance, y + lane),
            load(stances, stance, z + lane),
            load(stances, stance, w + lane),
        )
        zero = one - one
        dx, dy, dz, dw = product(zero - sx, zero - sy, zero - sz, sw, ux, uy, uz, uw)
        ax, ay, az, aw = product(ox, oy, oz, ow, dx, dy, dz, dw)
        rest, near = one - used, signed(used, (ax * ux + ay * uy) + (az * uz + aw * uw))
        ax, ay, az, aw = rest * ax + near * ux, rest * ay + near * uy, rest * az + near * uz, rest * aw + near * uw
        scale = driven / root(least + ((ax * ax + ay * ay) + (az * az + aw * aw)))
        kept = one - driven
        ax, ay, az, aw = scale * ax + kept * ox, scale * ay + kept * oy, scale * az + kept * oz, scale * aw + kept * ow
        interleave(lanes, above + at, ax, ay, az, aw)
    pelvis = above + FOUR * np.uint64(PELVIS)
    lanes[pelvis], lanes[pelvis + ONE] = px, py
    lanes[pelvis + ONE + ONE], lanes[pelvis + ONE + ONE + ONE] = pz, pw


@inlined
def torso_turned(lanes: Array, above: Index, driven: bool) -> tuple[Real, Real, Real, Real]:
    """Returns the locomotion's pelvis, turned in its posture frame as the action's is from its stance if `driven`."""
    px, py, pz, pw = quaternion_in(lanes, FOUR * np.uint64(PELVIS))
    if driven:
        fx, fy, fz, fw = quaternion_in(lanes, FOUR * np.uint64(POSTURE_FRAME))
        tx, ty, tz, tw = quaternion_in(lanes, above + FOUR * np.uint64(TORSO_OFFSET))
        tx, ty, tz, tw = product(fx, fy, fz, fw, tx, ty, tz, tw)
        tx, ty, tz, tw = product(tx, ty, tz, tw, -fx, -fy, -fz, fw)
        px, py, pz, pw = product(tx, ty, tz, tw, px, py, pz, pw)
        scale = np.float32(1.0) / np.float32(math.sqrt(max(px * px + py * py + pz * pz + pw * pw, TINY)))
        px, py, pz, pw = px * scale, py * scale, pz * scale, pw * scale
    return px, py, pz, pw


@inlined
def usage_of(bank: BankArrays, clip: int, row: Index, t: Real) -> tuple[Real, Real, Real, Real]:
    """Returns the usage weights of trunk, left arm, right arm and head."""
    first = bank.rig[arrays.FIRST_PLANE] - np.uint64(USAGE)
    trunk, head = between_rows(bank.upper, row, first, t), between_rows(bank.upper, row, first + ONE + ONE + ONE, t)
    left, right = between_rows(bank.upper, row, first + ONE, t), between_rows(bank.upper, row, first + ONE + ONE, t)
    if is_mirrored(bank, clip):
        return trunk, right, left, head
    return trunk, left, right, head


@inlined
def bit(bits: int, number: int) -> Real:
    """Returns a bit as a number."""
    return np.float32(bits >> number & 1)
