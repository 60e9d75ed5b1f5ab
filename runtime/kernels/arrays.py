"""A bank, and what is asked of it, as the flat arrays that kernels work on: few, for each costs a call 0.1 us."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.rows import FIRST_JOINT
from motionsplice.runtime.simd.compiled import Array

BLOCK = 16  # characters that are worked on together, and lanes of what is computed across them
LATE = 1e-6  # seconds after a clip's end that count as its end

# columns of BankArrays.clips
FIRST_ROW, FRAME_COUNT, ROW_COUNT, RATE, FIRST_CELL, CELL_COUNT = 0, 1, 2, 3, 4, 5
FIRST_PHASE, LAST_PHASE, LOOP, CELLS_PER_CYCLE, POSTURE, GAIT, CLIP_COLUMNS = 6, 7, 8, 9, 10, 16, 17
# entries of BankArrays.rig
FIRST_PLANE, LOWER_WIDTH, UPPER_WIDTH, CLOUD_WIDTH, POINTS, PELVIS_COLUMN, LOWER_COUNT = 0, 1, 2, 3, 4, 5, 6
HANDS_WIDTH, COLUMNS = 7, 8
# columns of what is remembered of a character
LAST_TURN, MEAN_POSTURE, MEMORY_COLUMNS = 0, 4, 10
# rows of Scratch.block, each BLOCK lanes: where a character is, a correlation, its bound and its gap, and quaternions
ROW_L, SHARE_L, ROW_U, SHARE_U, PHASE, CORRELATION, BOUND, GAP = 0, 1, 2, 3, 4, 5, 14, 15
ALIGNED, SPLICED, FRAME, OWN, THEIRS, TURN, BLOCK_ROWS = 16, 20, 24, 28, 32, 36, 40


class BankArrays(NamedTuple):
    """A bank as the kernels see it.

    lower, upper: [rows, columns] its tables; phases [rows] and frames [cells]: its phase_of_frame and frame_of_phase.
    clips: [C, CLIP_COLUMNS] float64; POSTURE begins the six numbers of a posture.
    rig:   uint64; from COLUMNS on, where in a pose each joint of the lower half goes, then each of the upper half.
    hands: [rows of hands, columns] its table; hand_rows: [H, C] int64, the row of it with which hands begin on a clip,
    -1 if they do not lie on it; hand_lanes: uint64, where in the lanes of the upper half each joint of theirs goes.
    """

    lower: Array
    upper: Array
    phases: Array
    frames: Array
    clips: Array
    rig: Array
    hands: Array
    hand_rows: Array
    hand_lanes: Array


class Scratch(NamedTuple):
    """Room for what each of several threads computes of a block of characters."""

    lanes: Array  # [threads, 4 lower lanes + 4 upper lanes + 4 lanes of hands] float32
    block: Array  # [threads, BLOCK_ROWS * BLOCK] float64


class RigArrays(NamedTuple):
    """What forward kinematics needs of a skeleton."""

    parents: Array  # [J]
    offsets: Array  # [J, 3] float32


def bank_arrays(bank: Bank) -> BankArrays:
    layout = bank.layout
    clips = np.array(
        [
            (
                *(clip.first_row, clip.frame_count, clip.row_count, clip.rate, clip.first_cell, clip.cell_count),
                *(clip.first_phase, clip.last_phase, clip.loop),
                (clip.cell_count - 1) / (clip.last_phase - clip.first_phase),
                *posture.ravel(),
                clip.gait,
            )
            for clip, posture in zip(bank.clips, bank.tables["postures"], strict=True)
        ]
    )
    widths = (layout.lower.first_plane, layout.lower.width, layout.upper.width, layout.cloud_width)
    columns = [4 * joint for half in layout.halves.values() for joint in half.joints]
    hand_rows = np.full((len(bank.hand_clips), len(bank.clips)), -1, np.int64)
    for one in bank.hands:
        hand_rows[bank.hand_number(one.name), bank.number(one.body)] = one.first_row
    lanes = [4 * (FIRST_JOINT + layout.upper.joints.index(joint)) for joint in layout.hands.joints]
    return BankArrays(
        lower=constant(bank.tables["lower"]),
        upper=constant(bank.tables["upper"]),
        phases=constant(bank.tables["phase_of_frame"]),
        frames=constant(bank.tables["frame_of_phase"]),
        clips=clips,
        rig=np.array(
            [*widths, layout.points, 4 * layout.pelvis, len(layout.lower.joints), layout.hands.width, *columns],
            np.uint64,
        ),
        hands=constant(bank.tables["hands"]),
        hand_rows=hand_rows,
        hand_lanes=np.array(lanes, np.uint64),
    )


def constant(table: Array) -> Array:
    """A view that cannot be written: a kernel is compiled anew for arrays that can."""
    view = table.view()
    view.flags.writeable = False
    return view


def scratch(bank: BankArrays, threads: int) -> Scratch:
    """Room for `threads` threads on a bank."""
    lanes = 4 * int(bank.rig[LOWER_WIDTH] + bank.rig[UPPER_WIDTH] + bank.rig[HANDS_WIDTH])
    return Scratch(np.zeros((threads, lanes), np.float32), np.zeros((threads, BLOCK_ROWS * BLOCK)))


def rig_arrays(skeleton: Skeleton) -> RigArrays:
    return RigArrays(skeleton.parents, skeleton.offsets.astype(np.float32))
