"""The flat arrays of characters' kernels, in addition to those of a bank."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.chains import Chains
from motionsplice.runtime.format.rows import Layout
from motionsplice.runtime.kernels.arrays import BLOCK, MEMORY_COLUMNS, BankArrays, Scratch
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

MOST_SOURCES = max(col.MOST_LOCOMOTIONS, 1 + col.MOST_ACTIONS)  # halves that are mixed


class Ground(NamedTuple):
    """The tables `paths` [rows, 4], `contacts` [rows] and `feet` [rows, 6] of a bank."""

    paths: Annotated[Array, np.float64, 2]
    contacts: Annotated[Array, np.uint8, 1]
    feet: Annotated[Array, np.float32, 2]


def ground(bank: Bank) -> Ground:
    """Returns the root paths, foot contacts and feet of a bank, without copying them."""
    return Ground(*(bank.tables[name] for name in Ground._fields))


class Limbs(NamedTuple):
    """The parts of an upper body: trunk, arms, head. Each limb hangs on the trunk by its attachment joint.

    Attributes:
        bits: [upper joints], the bit in a mask of each joint of the upper half.
        part_lanes: [parts, width] float32, 1 in the lanes of the upper half whose joints belong to a part, else 0.
        attachments: [parts], the lane of each limb's attachment; -1 if the rig has no such limb.
        lengths: [parts], number of joints in each limb's chain: from the pelvis's child to the attachment.
        chains: [parts, longest], the lanes of these joints.
        columns: [parts, longest], the first columns of these joints in a pose.
    """

    bits: Annotated[Array, np.int64, 1]
    part_lanes: Annotated[Array, np.float32, 2]
    attachments: Annotated[Array, np.int64, 1]
    lengths: Annotated[Array, np.int64, 1]
    chains: Annotated[Array, np.int64, 2]
    columns: Annotated[Array, np.uint64, 2]


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

    columns: Annotated[Array, np.uint64, 2]
    offsets: Annotated[Array, np.float64, 3]
    counts: Annotated[Array, np.int64, 1]
    hips: Annotated[Array, np.int64, 1]
    knees: Annotated[Array, np.int64, 1]
    reach: float


class Mixing(NamedTuple):
    """Scratch memory for mixing the characters of a block."""

    requests: Annotated[Array, REQUEST, 1]  # [BLOCK]: the splice of each lane
    memory: Annotated[Array, np.float64, 2]  # [BLOCK, MEMORY_COLUMNS]: the memory of each splice
    planes: Annotated[Array, np.float32, 2]  # [4 MOST_SOURCES, lanes of a half]: all x of a source, then all y ...
    lane_weights: Annotated[Array, np.float32, 2]  # [MOST_SOURCES, lanes of a half]: weights of each source
    row: Annotated[Array, np.float32, 2]  # [2, columns]: a mixed row of `lower`, and zeros as its next row
    # [(1 + actions + 1) parts]: of the locomotions, of each action, and what is left
    weights: Annotated[Array, np.float64, 1]
    shares: Annotated[Array, np.float64, 2]  # [BLOCK, parts]: of each action in its pose
    # [BLOCK, 4 parts]: the action's pelvis, then its attachments relative to the pelvis
    turns: Annotated[Array, np.float64, 2]
    # [BLOCK]: how a character's pelvis and limbs are set, as `turning_kernels` numbers it
    finish: Annotated[Array, np.int64, 1]


class StageArrays(NamedTuple):
    """The arrays that kernels of characters use, besides states and poses.

    Attributes:
        bank: The bank.
        ground: Root paths, foot contacts and feet of all rows of the bank.
        limbs: Joints of the parts of the upper body, for masks.
        chains: Chains of joints that turn toward targets, with scratch memory.
        legs: Joints of the legs, for the foot lock.
        scratch: Scratch memory of the evaluator.
        mixing: Scratch memory for mixing.
        clock: Scratch memory for advancing.
    """

    bank: BankArrays
    ground: Ground
    limbs: Limbs
    chains: Chains
    legs: Legs
    scratch: Scratch
    mixing: Mixing
    clock: Annotated[Array, np.float64, 1]


def mixing(layout: Layout) -> Mixing:
    """Returns scratch memory for mixing."""
    width = max(layout.lower.width, layout.upper.width)
    return Mixing(
        requests=np.zeros(BLOCK, REQUEST),
        memory=np.zeros((BLOCK, MEMORY_COLUMNS)),
        planes=np.zeros((4 * MOST_SOURCES, width), np.float32),
        lane_weights=np.zeros((MOST_SOURCES, width), np.float32),
        row=np.zeros((2, layout.lower.columns), np.float32),
        weights=np.zeros(col.PARTS * (col.MOST_ACTIONS + 2)),
        shares=np.zeros((BLOCK, col.PARTS)),
        turns=np.zeros((BLOCK, 4 * col.PARTS)),
        finish=np.zeros(BLOCK, np.int64),
    )
