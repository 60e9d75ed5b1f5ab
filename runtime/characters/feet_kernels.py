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
from motionsplice.runtime.simd.compiled import Array, inlined, kernel

LONGEST = 0.1  # seconds of a clip in one frame: a foot that stands at both ends of a longer step may have swung between
LOOSE, FIRM = 0.4, 0.6  # support below which a foot is free, and from which on it holds the root
FASTEST = 2.4  # metres per second by which the root is corrected at most
BLENDED = 0.25  # share of all locomotions but the largest from which on a firm foot stands still

Place = tuple[float, float]  # x and z of a foot, metres, from the root path in its heading
Sums = tuple[float, float, float, float, float]  # of a foot: its own step, by support; its place, by share; its support
Step = tuple[float, float, float, float]  # root motion: x and z from the place before; sine and cosine of half its turn
NOWHERE: Place = (0.0, 0.0)
NOTHING: Sums = (0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def foot_at(bank: BankArrays, ground: Ground, clip: int, frame: float, foot: int) -> tuple[float, float, float]:
    """Returns the place of a foot, 0 or 1, at a frame of a clip, and its support."""
    row, t = row_of(bank, clip, frame)
    side, first = 1.0, 3 * foot
    if is_mirrored(bank, clip):
        side, first = -1.0, 3 - 3 * foot
    x, z, support = ground.feet[row, first], ground.feet[row, first + 1], ground.feet[row, first + 2]
    after = row + ONE
    return (
        side * (x + t * (ground.feet[after, first] - x)),
        z + t * (ground.feet[after, first + 1] - z),
        support + t * (ground.feet[after, first + 2] - support),
    )


@inlined
def mixed_place(bank: BankArrays, ground: Ground, s: Array, c: int, foot: int) -> Place:
    """Returns the place of a foot, mixed by the locomotions' shares."""
    x = z = 0.0
    for number in range(int(s[c + col.LOCOMOTIONS])):
        slot = locomotion_slot(c, number)
        foot_x, foot_z, _ = foot_at(bank, ground, int(s[slot + col.CLIP]), s[slot + col.FRAME], foot)
        x, z = x + s[slot + col.SHARE] * foot_x, z + s[slot + col.SHARE] * foot_z
    return x, z


@inlined
def moved(x: float, z: float, step: Step) -> Place:
    """Returns a place after a root motion, seen from before it."""
    x, z = in_turned_frame(-step[2], step[3], x, z)
    return step[0] + x, step[1] + z


@inlined
def step_of(x: float, z: float, turn: float) -> Step:
    return x, z, math.sin(0.5 * turn), math.cos(0.5 * turn)


@inlined
def add_step(
    bank: BankArrays,
    ground: Ground,
    s: Array,
    slot: int,
    before: float,
    step: Step,
    foot: int,
    sums: Sums,
) -> Sums:
    """Adds a slot's foot to the sums; the slot has gone from frame `before` to its frame by the root motion `step`."""
    clip, share = int(s[slot + col.CLIP]), s[slot + col.SHARE]
    x0, z0, support_before = foot_at(bank, ground, clip, before, foot)
    x1, z1, support = foot_at(bank, ground, clip, s[slot + col.FRAME], foot)
    x, z = moved(x1, z1, step)
    weight = 0.5 * share * (support_before + support)
    return (
        sums[0] + weight * (x - x0),
        sums[1] + weight * (z - z0),
        sums[2] + share * x1,
        sums[3] + share * z1,
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


@kernel
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
