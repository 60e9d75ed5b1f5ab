"""The flat arrays of characters' kernels, in addition to those of a bank."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.rows import Layout
from motionsplice.runtime.kernels.arrays import BLOCK, MEMORY_COLUMNS, constant
from motionsplice.runtime.requests import REQUEST
from motionsplice.runtime.simd.compiled import Array

# rows of the clock, scratch memory for advancing a block of characters. Of each character: the cycles that its gaits
# advance; whether its feet are looked up, and whether they drive the root; the places of both feet, x and z
PASSED, STANDS, DRIVES, LEFT_X, LEFT_Z, RIGHT_X, RIGHT_Z = (row * BLOCK for row in range(7))
# of each slot whose frame follows from its phase, locomotions before actions: the slot, its new phase; of a locomotion
# the frame before, and the loops that it goes back
FIRST_IN_STEP = BLOCK * col.MOST_LOCOMOTIONS  # number of the first action
SLOT, REACHED, BEFORE, ROUNDS, CLOCK_SIZE = (
    7 * BLOCK + row * (FIRST_IN_STEP + BLOCK * col.MOST_ACTIONS) for row in range(5)
)


class Ground(NamedTuple):
    """The tables `paths` [rows, 4], `contacts` [rows] and `feet` [rows, 6] of a bank."""

    paths: Array
    contacts: Array
    feet: Array


def ground(bank: Bank) -> Ground:
    """Returns the root paths, foot contacts and feet of a bank, without copying them."""
    return Ground(*(constant(bank.tables[name]) for name in Ground._fields))


class Limbs(NamedTuple):
    """The parts of an upper body: trunk, arms, head. Each limb hangs on the trunk by its attachment joint.

    Attributes:
        part_lanes: [parts, width] float32, 1 in the lanes of the upper half whose joints belong to a part, else 0.
        attachments: [parts], the lane of each limb's attachment; -1 if the rig has no such limb.
        lengths: [parts], number of joints in each limb's chain: from the pelvis's child to the attachment.
        chains: [parts, longest], the lanes of these joints.
        columns: [parts, longest], the first columns of these joints in a pose.
    """

    part_lanes: Array
    attachments: Array
    lengths: Array
    chains: Array
    columns: Array


class Legs(NamedTuple):
    """The left and the right leg, each as the chain of joints from a child of the root to the ankle.

    Attributes:
        columns: [2, longest], the first columns of the joints in a pose.
        offsets: [2, longest, 3], from their parents, metres.
        counts: [2], number of joints; 0 on a rig whose roles are no legs.
        hips: [2], the hip's index in the chain.
        knees: [2], the knee's index.
        reach: The farthest that the foot lock holds a foot from its pose, metres.
    """

    columns: Array
    offsets: Array
    counts: Array
    hips: Array
    knees: Array
    reach: float


class Mixing(NamedTuple):
    """Scratch memory for mixing the characters of a block."""

    requests: Array  # [BLOCK] REQUEST: the splice of each lane
    memory: Array  # [BLOCK, MEMORY_COLUMNS]: the memory of each splice
    sum: Array  # [4, lanes of a half] float32: weighted sum of rotations
    lane_weights: Array  # [1, lanes of a half] float32: weights of the next summand
    row: Array  # [2, columns] float32: a mixed row of `lower`, and zeros as its next row
    weights: Array  # [1 + actions + 1, parts]: of the locomotions, of each action, and what is left
    shares: Array  # [BLOCK, parts]: of each action in its pose
    turns: Array  # [BLOCK, 4 parts]: the action's pelvis, then its attachments relative to the pelvis
    finish: Array  # [BLOCK]: how a character's pelvis and limbs are set, as `turning_kernels` numbers it


def mixing(layout: Layout) -> Mixing:
    """Returns scratch memory for mixing."""
    width = max(layout.lower.width, layout.upper.width)
    return Mixing(
        requests=np.zeros(BLOCK, REQUEST),
        memory=np.zeros((BLOCK, MEMORY_COLUMNS)),
        sum=np.zeros((4, width), np.float32),
        lane_weights=np.zeros((1, width), np.float32),
        row=np.zeros((2, layout.lower.columns), np.float32),
        weights=np.zeros(col.PARTS * (col.MOST_ACTIONS + 2)),
        shares=np.zeros((BLOCK, col.PARTS)),
        turns=np.zeros((BLOCK, 4 * col.PARTS)),
        finish=np.zeros(BLOCK, np.int64),
    )
