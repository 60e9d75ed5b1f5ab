"""The flat arrays that kernels work on. They are few, because each array argument makes a call slower."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.rows import FIRST_JOINT
from motionsplice.runtime.simd.compiled import Array

BLOCK = 16  # characters computed together, one lane each
LATE = 1e-6  # seconds: times this much after a clip's end count as its end

# columns of BankArrays.clips
FIRST_ROW, FRAME_COUNT, ROW_COUNT, RATE, FIRST_CELL, CELL_COUNT = 0, 1, 2, 3, 4, 5
FIRST_PHASE, LAST_PHASE, LOOP, CELLS_PER_CYCLE, POSTURE, GAIT, CLIP_COLUMNS = 6, 7, 8, 9, 10, 16, 17
# entries of BankArrays.rig
FIRST_PLANE, LOWER_WIDTH, UPPER_WIDTH, CLOUD_WIDTH, POINTS, PELVIS_COLUMN, LOWER_COUNT = 0, 1, 2, 3, 4, 5, 6
HANDS_WIDTH, COLUMNS = 7, 8
# columns of a memory
LAST_TURN, MEAN_POSTURE, MEMORY_COLUMNS = 0, 4, 10
# rows of Scratch.block, BLOCK lanes each: rows and shares between them, phase, a correlation, its bound and its gap;
# from ALIGNED on quaternions, four rows each
ROW_L, SHARE_L, ROW_U, SHARE_U, PHASE, CORRELATION, BOUND, GAP = 0, 1, 2, 3, 4, 5, 14, 15
ALIGNED, SPLICED, FRAME, OWN, THEIRS, TURN, BLOCK_ROWS = 16, 20, 24, 28, 32, 36, 40


class BankArrays(NamedTuple):
    """A bank as flat arrays.

    Attributes:
        lower: [rows, columns] float32, the table `lower`.
        upper: [rows, columns] float32, the table `upper`.
        phases: [rows] float64, the table `phase_of_frame`.
        frames: [cells] float32, the table `frame_of_phase`.
        clips: [C, CLIP_COLUMNS] float64; a posture is six numbers from POSTURE on.
        rig: uint64, counts and widths; from COLUMNS on, the first column in a pose of each joint of the lower half,
            then of the upper half.
        hands: [rows of hands, columns] float32, the table `hands`.
        hand_rows: [H, C] int64, the first row in `hands` of each hands clip on each clip; -1 if not aligned to it.
        hand_lanes: uint64, the offset in the sampled upper half of each joint of the hands.
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
    """Scratch memory of each thread, for one block of characters."""

    lanes: Array  # [threads, 4 lower lanes + 4 upper lanes + 4 lanes of hands] float32
    block: Array  # [threads, BLOCK_ROWS * BLOCK] float64


class RigArrays(NamedTuple):
    """A skeleton as flat arrays, for forward kinematics."""

    parents: Array  # [J]
    offsets: Array  # [J, 3] float32


def bank_arrays(bank: Bank) -> BankArrays:
    """Returns a bank as flat arrays, without copying its large tables."""
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
    """Returns a read-only view. Writable arrays have another Numba type, for which kernels would be compiled again."""
    view = table.view()
    view.flags.writeable = False
    return view


def scratch(bank: BankArrays, threads: int) -> Scratch:
    """Returns scratch memory for `threads` threads."""
    lanes = 4 * int(bank.rig[LOWER_WIDTH] + bank.rig[UPPER_WIDTH] + bank.rig[HANDS_WIDTH])
    return Scratch(np.zeros((threads, lanes), np.float32), np.zeros((threads, BLOCK_ROWS * BLOCK)))


def rig_arrays(skeleton: Skeleton) -> RigArrays:
    """Returns a skeleton as flat arrays."""
    return RigArrays(skeleton.parents, skeleton.offsets.astype(np.float32))
