"""A bank, and what is asked of it, as the flat arrays that kernels work on: few, for each costs a call 0.1 us."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.skeleton import Skeleton
from runtime.bank import Bank
from runtime.rows import FIRST_JOINT, Half

Array = NDArray[Any]
Index = int | np.uint64
Real = float | np.float32

BLOCK = 32  # characters that are worked on together, and lanes of what is computed across them
LATE = 1e-6  # seconds after a clip's end that count as its end

# columns of BankArrays.clips
FIRST_ROW, FRAME_COUNT, ROW_COUNT, RATE, FIRST_CELL, CELL_COUNT = 0, 1, 2, 3, 4, 5
FIRST_PHASE, LAST_PHASE, LOOP, CELLS_PER_CYCLE, LATEST, POSTURE, CLIP_COLUMNS = 6, 7, 8, 9, 10, 11, 17
# entries of BankArrays.rig
FIRST_PLANE, LOWER_WIDTH, UPPER_WIDTH, POINTS, PELVIS_COLUMN, LOWER_RUNS, RIG_ENTRIES = 0, 1, 2, 3, 4, 5, 6
# rows of Scratch.block, each BLOCK lanes: nine of a correlation, one of its bound and its gap, and quaternions
CORRELATION, BOUND, GAP, ALIGNED, SPLICED, FRAME, OWN, THEIRS, TURN, BLOCK_ROWS = 0, 9, 10, 11, 15, 19, 23, 27, 31, 35


class BankArrays(NamedTuple):
    """A bank as the kernels see it.

    lower, upper: [rows, columns] its tables; phases [rows] and frames [cells]: its phase_of_frame and frame_of_phase.
    clips: [C, CLIP_COLUMNS] float64; POSTURE begins the six numbers of a posture.
    rig:   [RIG_ENTRIES] uint64, of which LOWER_RUNS says how many of the runs are lower ones.
    runs:  [n, 3] uint64: joints side by side in a row and in a pose: from where, to where, how many, in floats.
    """

    lower: Array
    upper: Array
    phases: Array
    frames: Array
    clips: Array
    rig: Array
    runs: Array


class MemoryArrays(NamedTuple):
    """`Memory` as the kernels see it: of as many characters as are evaluated, of one for all, or of none."""

    means: Array  # [n, 2, 3]
    turns: Array  # [n, 4]
    share: float


class Scratch(NamedTuple):
    """Room for what each of several threads computes of a block of characters."""

    rows: Array  # [threads, 2, BLOCK] uint64
    shares: Array  # [threads, 2, BLOCK] float32, how far past the rows
    lanes: Array  # [threads, 2, 4 lanes] float32
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
                clip.duration + LATE,
                *posture.ravel(),
            )
            for clip, posture in zip(bank.clips, bank.tables["postures"], strict=True)
        ]
    )
    lower, upper = _runs(layout.lower), _runs(layout.upper)
    widths = (layout.lower.first_plane, layout.lower.width, layout.upper.width)
    rig = np.array([*widths, layout.points, 4 * layout.pelvis, len(lower)], np.uint64)
    return BankArrays(
        lower=bank.tables["lower"],
        upper=bank.tables["upper"],
        phases=bank.tables["phase_of_frame"],
        frames=bank.tables["frame_of_phase"],
        clips=clips,
        rig=rig,
        runs=np.array(lower + upper, np.uint64),
    )


def _runs(half: Half) -> list[tuple[int, int, int]]:
    """Neighbouring joints that are copied together."""
    runs: list[tuple[int, int, int]] = []
    for lane, joint in enumerate(half.joints, FIRST_JOINT):
        if runs and joint == (runs[-1][1] + runs[-1][2]) // 4:
            first_lane, first_joint, count = runs.pop()
            runs.append((first_lane, first_joint, count + 4))
        else:
            runs.append((4 * lane, 4 * joint, 4))
    return runs


def scratch(bank: BankArrays, threads: int) -> Scratch:
    """Room for `threads` threads on a bank."""
    widest = int(max(bank.rig[LOWER_WIDTH], bank.rig[UPPER_WIDTH]))
    return Scratch(
        np.zeros((threads, 2, BLOCK), np.uint64),
        np.zeros((threads, 2, BLOCK), np.float32),
        np.zeros((threads, 2, 4 * widest), np.float32),
        np.zeros((threads, BLOCK_ROWS * BLOCK)),
    )


def rig_arrays(skeleton: Skeleton) -> RigArrays:
    return RigArrays(skeleton.parents, skeleton.offsets.astype(np.float32))
