"""The foot lock: the last step of a pose holds standing feet where they are.

A lock is an offset from where the pose has a foot to where it is held. While the foot stands, the offset grows against
the foot's way over the ground; afterwards it fades out. Then each leg is bent to its offset foot, as two bones whose
knee keeps its plane, and the foot keeps its orientation.
"""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Legs
from motionsplice.runtime.characters.feet_kernels import Place, Step, Sums, firmness, last_step, moved
from motionsplice.runtime.characters.transition_kernels import in_turned_frame
from motionsplice.runtime.kernels.curves import smooth
from motionsplice.runtime.kernels.rotations import TINY
from motionsplice.runtime.kernels.turns import (
    Turn,
    Vector,
    between,
    inverse,
    length,
    minus,
    plus,
    times,
    turn_at,
    turn_joint,
    turned,
    unit_vector,
)
from motionsplice.runtime.simd.compiled import Array, inlined, kernel

FADING = 0.2  # seconds in which the lock is turned on or off
RELEASE = 0.12  # seconds: the offset of a free foot fades out with this time constant
SLOW, FAST = 0.75, 1.5  # metres per second: a foot that slides faster gives way, and one so fast is not held
NEAR = 0.5  # of the reach: a farther offset makes the foot give way, and it never gets beyond the reach
LONG, TIRED = 1.0, 2.0  # seconds: an offset begins to fade out when a foot has stood so long, and does so fully
SETTLING = 0.5  # seconds: time constant of that
STIFF = 0.5  # sine of a knee's bend at which it takes up half of a change of the leg's length
STRAIGHT = 0.998  # of a leg's length: the farthest that it is stretched


@inlined
def is_locking(s: Array, c: int) -> bool:
    """Whether a character's lock is on, or still fades out."""
    return s[c + col.LOCK] > 0.0 or s[c + col.LOCKED] > 0.0


@kernel
def advance_lock(
    s: Array, c: int, left: Place, right: Place, lefts: Sums, rights: Sums, seconds: float, reach: float
) -> None:
    """Advances the lock of a character whose feet were at the places `left` and `right`.

    reach: the longest offset, metres. The offsets of a lock that is off are forgotten.
    """
    change, step = seconds / FADING, last_step(s, c)
    hold_foot(s, c + col.HOLDS, left, lefts, step, seconds, reach)
    hold_foot(s, c + col.HOLDS + col.HOLD_COLUMNS, right, rights, step, seconds, reach)
    s[c + col.LOCKED] += min(max(s[c + col.LOCK] - s[c + col.LOCKED], -change), change)
    if s[c + col.LOCKED] == 0.0:
        for column in range(2 * col.HOLD_COLUMNS):
            s[c + col.HOLDS + column] = 0.0


@inlined
def hold_foot(s: Array, hold: int, before: Place, sums: Sums, step: Step, seconds: float, reach: float) -> None:
    """Advances the offset of a foot that was at the place `before`, after the root motion `step`."""
    x, z = moved(sums[2], sums[3], step)
    x, z = x - before[0], z - before[1]
    firm = firmness(sums[4])
    fast = smooth((math.hypot(x, z) / seconds - SLOW) / (FAST - SLOW)) if seconds > 0.0 else 0.0
    far = smooth((math.hypot(s[hold], s[hold + 1]) / reach - NEAR) / (1.0 - NEAR))
    held = firm * (1.0 - far) * (1.0 - fast)
    stood = s[hold + 2] + seconds if firm > 0.0 else 0.0
    fading = (1.0 - held) / RELEASE + smooth((stood - LONG) / (TIRED - LONG)) / SETTLING
    left = math.exp(-fading * seconds)
    x, z = left * (s[hold] - held * x), left * (s[hold + 1] - held * z)
    s[hold], s[hold + 1] = in_turned_frame(step[2], step[3], x, z)
    s[hold + 2] = stood


@kernel
def lock_feet(legs: Legs, s: Array, c: int, character: int, roots: Array, rotations: Array) -> None:
    """Bends the legs of a pose to its feet with their offsets."""
    share = smooth(s[c + col.LOCKED])
    for leg in range(2):
        hold = c + col.HOLDS + leg * col.HOLD_COLUMNS
        x, z = share * s[hold], share * s[hold + 1]
        if s[c + col.IN_PLACE] == 0.0:
            x, z = in_turned_frame(-s[c + col.SIN], s[c + col.COS], x, z)
        if legs.counts[leg] > 0 and (x != 0.0 or z != 0.0):  # a row may come from a bank of another rig
            bend_leg(legs, leg, x, z, character, roots, rotations)


@inlined
def bend_leg(legs: Legs, leg: int, x: float, z: float, character: int, roots: Array, rotations: Array) -> None:
    """Moves an ankle over the ground by x and z, metres, by turning hip and knee; the foot keeps its orientation."""
    place = (float(roots[character, 0]), float(roots[character, 1]), float(roots[character, 2]))
    turn = turn_at(rotations, character, np.uint64(0))
    hip = knee = place
    above_hip = above_knee = above = turn
    for number in range(legs.counts[leg]):
        above = turn
        offset = (legs.offsets[leg, number, 0], legs.offsets[leg, number, 1], legs.offsets[leg, number, 2])
        place = plus(place, turned(above, offset))
        turn = times(above, turn_at(rotations, character, legs.columns[leg, number]))
        if number == legs.hips[leg]:
            hip, above_hip = place, above
        elif number == legs.knees[leg]:
            knee, above_knee = place, above
    thigh, shin = minus(hip, knee), minus(place, knee)
    bend = bending(thigh, shin, minus(place, hip), x, z)
    was, wanted = minus(turned(bend, shin), thigh), plus(minus(place, hip), (x, 0.0, z))
    swing = between(unit_vector(was), unit_vector(wanted))
    turn_joint(rotations, character, legs.columns[leg, legs.hips[leg]], swing, above_hip)
    turn_joint(rotations, character, legs.columns[leg, legs.knees[leg]], bend, above_knee)
    turn_joint(rotations, character, legs.columns[leg, legs.counts[leg] - 1], inverse(times(swing, bend)), above)


@inlined
def bending(thigh: Vector, shin: Vector, leg: Vector, x: float, z: float) -> Turn:
    """Returns the turn of a shin about its knee that makes a leg as long as it is to its ankle moved by x and z.

    thigh, shin: from the knee to hip and ankle, metres. leg: from hip to ankle. Near full reach a knee turns ever
    faster for the same change of length, without bound. So the straighter it is, the less of the change is taken up;
    and no leg becomes straight.
    """
    a, b, reach = length(thigh), length(shin), length(leg)
    axis = (
        thigh[1] * shin[2] - thigh[2] * shin[1],
        thigh[2] * shin[0] - thigh[0] * shin[2],
        thigh[0] * shin[1] - thigh[1] * shin[0],
    )
    size, product_of_bones = length(axis), max(a * b, TINY)
    sine = size / product_of_bones
    change = length((leg[0] + x, leg[1], leg[2] + z)) - reach
    change *= sine * sine / (sine * sine + STIFF * STIFF)
    room = STRAIGHT * (a + b) - reach
    if change > 0.0:
        change = room * (1.0 - math.exp(-change / room)) if room > 0.0 else 0.0
    half = 0.5 * (angle_at(a, b, reach + change, product_of_bones) - angle_at(a, b, reach, product_of_bones))
    scale = math.sin(half) / max(size, TINY)
    return scale * axis[0], scale * axis[1], scale * axis[2], math.cos(half)


@inlined
def angle_at(a: float, b: float, reach: float, product_of_bones: float) -> float:
    """Returns the angle at the knee of a leg that reaches so far, by the law of cosines."""
    cosine = (a * a + b * b - reach * reach) / (2.0 * product_of_bones)
    return math.acos(min(max(cosine, -1.0), 1.0))
