"""What the kernels of characters need beside a bank's arrays, as flat arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.rows import Layout
from motionsplice.runtime.kernels.arrays import BLOCK, MEMORY_COLUMNS, constant
from motionsplice.runtime.requests import REQUEST
from motionsplice.runtime.simd.compiled import Array


class Ground(NamedTuple):
    """Of each row of a bank, what the motion of characters over the ground takes: paths [rows, 4], contacts [rows]."""

    paths: Array
    contacts: Array


def ground(bank: Bank) -> Ground:
    return Ground(constant(bank.tables["paths"]), constant(bank.tables["contacts"]))


class Limbs(NamedTuple):
    """Which joints of an upper half belong to which of its parts, and by which each limb hangs on the trunk.

    part_of_lane [width]; of each part: attachments, the lane of that joint (-1: none), and the way to it from the
    pelvis's child: lengths, chains [parts, longest] in lanes and columns [parts, longest] in a pose.
    """

    part_of_lane: Array
    attachments: Array
    lengths: Array
    chains: Array
    columns: Array


class Mixing(NamedTuple):
    """Room for what is mixed of the characters of a block."""

    requests: Array  # [BLOCK] REQUEST: what each lane splices
    memory: Array  # [BLOCK, MEMORY_COLUMNS]: what is remembered of it
    sum: Array  # [4, lanes of a half] float32: rotations
    lane_weights: Array  # [1, lanes of a half] float32: of what is added to that
    row: Array  # [2, columns] float32: a row of `lower`, and one of zeros, which no one is on the way to
    weights: Array  # [1 + actions + 1, parts]
    shares: Array  # [BLOCK, parts]
    turns: Array  # [BLOCK, 4 parts]: rotations
    limbs_turn: Array  # [BLOCK]


def mixing(layout: Layout) -> Mixing:
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
        limbs_turn=np.zeros(BLOCK, np.int64),
    )
