"""The standing foot drives the root while locomotions are mixed.

Clips have a standing foot at different places relative to the root. So while their shares change, the mixed foot goes
from one place to the other; and where one clip swings a foot on which another stands, the mixed foot swings a little.
The root moves against this slip of the foot that stands. Places of feet are mixed here, not rotations, so that no
forward kinematics is needed; a standing foot of the mixed pose is a few millimetres off.
"""

from __future__ import annotations

import math

from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.arrays import Ground
from motionsplice.runtime.characters.slots import locomotion_slot
from motionsplice.runtime.characters.transition_kernels import in_turned_frame, leading
from motionsplice.runtime.kernels.arrays import BankArrays
from motionsplice.runtime.kernels.curves import smooth
from motionsplice.runtime.kernels.lookup import is_mirrored
from motionsplice.runtime.kernels.phase import row_of
from motionsplice.runtime.kernels.rotations import ONE, TINY
from motionsplice.runtime.simd.compiled import Array, Index, inlined

LONGEST = 0.1  # seconds of a clip in one frame: a foot that stands at both ends of a longer step may have swung between
LOOSE, FIRM = 0.4, 0.6  # support below which a foot is free, and from which on it holds the root
FASTEST = 2.4  # metres per second by which the root is corrected at most
BLENDED = 0.25  # share of all locomotions but the largest from which on a firm foot stands still

Foot = tuple[float, float, float]  # its place as below, and its support
Place = tuple[float, float]  # x and z of a foot, metres, from the root path in its heading
Sums = tuple[float, float, float, float, float]  # of a foot: its own step, by support; its place, by share; its support
Step = tuple[float, float, float, float]  # root motion: x and z from the place before; sine and cosine of half its turn
NOWHERE: Place = (0.0, 0.0)
NOTHING: Sums = (0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def feet_at(bank: BankArrays, ground: Ground, clip: int, frame: float) -> tuple[Foot, Foot]:
    """Returns the left and the right foot at a frame of a clip."""
    row, t = row_of(bank, clip, frame)
    left, right = foot_between(ground, row, t, 0), foot_between(ground, row, t, 3)
    if is_mirrored(bank, clip):
        return (-right[0], right[1], right[2]), (-left[0], left[1], left[2])
    return left, right


@inlined
def foot_between(ground: Ground, row: Index, t: float, first: int) -> Foot:
    """Returns the foot in three columns from `first` on, `t` of the way from a row to the next."""
    x, z, support = ground.feet[row, first], ground.feet[row, first + 1], ground.feet[row, first + 2]
    after = row + ONE
    return (
        x + t * (ground.feet[after, first] - x),
        z + t * (ground.feet[after, first + 1] - z),
        support + t * (ground.feet[after, first + 2] - support),
    )


@inlined
def mixed_places(bank: BankArrays, ground: Ground, s: Array, c: int) -> tuple[Place, Place]:
    """Returns the places of both feet, mixed by the locomotions' shares."""
    left_x = left_z = right_x = right_z = 0.0
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion_slot(c, number)
        left, right = feet_at(bank, ground, int(s[slot + col.CLIP]), s[slot + col.FRAME])
        share = s[slot + col.SHARE]
        left_x, left_z = left_x + share * left[0], left_z + share * left[1]
        right_x, right_z = right_x + share * right[0], right_z + share * right[1]
    return (left_x, left_z), (right_x, right_z)


@inlined
def moved(x: float, z: float, step: Step) -> Place:
    """Returns a place after a root motion, seen from before it."""
    x, z = in_turned_frame(-step[2], step[3], x, z)
    return step[0] + x, step[1] + z


@inlined
def step_of(x: float, z: float, turn: float) -> Step:
    if turn == 0.0:
        return x, z, 0.0, 1.0
    return x, z, math.sin(0.5 * turn), math.cos(0.5 * turn)


@inlined
def add_step(share: float, before: Foot, after: Foot, step: Step, sums: Sums) -> Sums:
    """Adds a foot of a locomotion to the sums: it has gone from `before` to `after` by the root motion `step`."""
    x, z = moved(after[0], after[1], step)
    weight = 0.5 * share * (before[2] + after[2])
    return (
        sums[0] + weight * (x - before[0]),
        sums[1] + weight * (z - before[1]),
        sums[2] + share * after[0],
        sums[3] + share * after[1],
        sums[4] + weight,
    )


@inlined
def firmness(support: float) -> float:
    """Returns how firmly a foot of this support holds the root, 0 to 1."""
    return smooth((support - LOOSE) / (FIRM - LOOSE))


@inlined
def slip_of(before: Place, sums: Sums, step: Step, blended: float) -> tuple[float, float, float]:
    """Returns the slip x and z of a foot, and how firmly it stands.

    The slip is what it goes over the ground, less what it goes in the clips in which it stands. A captured foot rolls
    and slides a little. But where clips are `blended`, the firmer it stands, the less of this is left to it.
    """
    x, z = moved(sums[2], sums[3], step)
    firm = firmness(sums[4])
    left = (1.0 - blended * firm * firm * firm) / max(sums[4], TINY)
    return x - before[0] - left * sums[0], z - before[1] - left * sums[1], firm


@inlined
def blended(s: Array, c: int) -> float:
    """Returns how much more than one locomotion is visible, 0 to 1."""
    return min(max(1.0 - s[leading(s, c) + col.SHARE], 0.0) / BLENDED, 1.0)


@inlined
def drive_root(s: Array, c: int, left: Place, right: Place, lefts: Sums, rights: Sums, seconds: float) -> None:
    """Corrects the root motion of a frame by the slips of both feet, which were at the places `left` and `right`.

    No correction is faster than FASTEST. Slower ones are hardly changed.
    """
    step, visible = last_step(s, c), blended(s, c)
    x, z = step_against(slip_of(left, lefts, step, visible), slip_of(right, rights, step, visible))
    square = (x * x + z * z) / max(FASTEST * FASTEST * seconds * seconds, TINY)
    scale = 1.0 / math.sqrt(math.sqrt(math.sqrt(1.0 + square * square * square * square)))
    s[c + col.DELTA] += scale * x
    s[c + col.DELTA + 2] += scale * z


@inlined
def last_step(s: Array, c: int) -> Step:
    """Returns the root motion of a character's last frame."""
    return step_of(s[c + col.DELTA], s[c + col.DELTA + 2], s[c + col.DELTA + 3])


@inlined
def step_against(left: tuple[float, float, float], right: tuple[float, float, float]) -> Place:
    """Returns the step of the root against the slips of both feet. Of two that stand, the firmer counts more."""
    left_weight, right_weight = left[2] * left[2], right[2] * right[2]
    scale = -max(left[2], right[2]) / max(left_weight + right_weight, TINY)
    return (
        scale * (left_weight * left[0] + right_weight * right[0]),
        scale * (left_weight * left[1] + right_weight * right[1]),
    )
