"""The flat arrays that kernels work on, in records that they read from one handle (`runtime.simd.handle`)."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from motionsplice.motion.mirror import FLIP
from motionsplice.motion.parts import part_of_joint
from motionsplice.motion.quaternion import IDENTITY, Floats, conjugate, multiply, to_matrices
from motionsplice.motion.twins import MIRROR
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.packed_rows import packed_stance
from motionsplice.runtime.format.rows import FIRST_JOINT, PELVIS, POSTURE_FRAME, TORSO_OFFSET
from motionsplice.runtime.mirrored import HALF_A_CYCLE
from motionsplice.runtime.simd.compiled import Array

BLOCK = 16  # characters computed together, one lane each
LATE = 1e-6  # seconds: times this much after a clip's end count as its end

# columns of BankArrays.clips
FIRST_ROW, FRAME_COUNT, ROW_COUNT, RATE, FIRST_CELL, CELL_COUNT = 0, 1, 2, 3, 4, 5
FIRST_PHASE, LAST_PHASE, LOOP, CELLS_PER_CYCLE, POSTURE, GAIT = 6, 7, 8, 9, 10, 16
MIRRORED, PHASE_SHIFT = 17, 18  # whether rows are mirrored; what is added to the table of phases
STANCE, DRIVES = 19, 20  # row in BankArrays.stances, -1 if none; bits of the parts that are driven
FIRST_STRETCH, NEXT_STRETCH = 21, 22  # clips: the first stretch of a hybrid, the one after a stretch; -1 if none
# frames of a stretch at which it takes over and hands over, 0 for other clips; and the hybrid's frame at which it does
ENTERS, LEAVES, BEGINS, CLIP_COLUMNS = 23, 24, 25, 26
# entries of BankArrays.rig
FIRST_PLANE, LOWER_WIDTH, UPPER_WIDTH, CLOUD_WIDTH, POINTS, PELVIS_COLUMN, LOWER_COUNT = 0, 1, 2, 3, 4, 5, 6
HANDS_WIDTH, SPARE, HANDS_COUNT, OWN_UPPER, COLUMNS = 7, 8, 9, 10, 11
# columns of BankArrays.mirror: the lane of the twin, and a matrix of four rows, or of three for the upper cloud
TWIN, MATRIX, MIRROR_COLUMNS = 0, 1, 17
# columns of a memory
LAST_TURN, MEAN_POSTURE, MEMORY_COLUMNS = 0, 4, 10
# rows of Scratch.block, BLOCK lanes each: rows and shares between them, each followed by those of the NEXT block;
# phase, a correlation, its bound and its gap; from ALIGNED on quaternions, four rows each
ROW_L, SHARE_L, ROW_U, SHARE_U, PHASE, CORRELATION, BOUND, GAP = 0, 2, 4, 6, 8, 9, 18, 19
ALIGNED, SPLICED, FRAME, OWN, THEIRS, TURN, BLOCK_ROWS = 20, 24, 28, 32, 36, 40, 44
NEXT = BLOCK  # lane of the next block's first character


class BankArrays(NamedTuple):
    """A bank as flat arrays.

    Attributes:
        lower: [rows, columns] float32, the table `lower`.
        upper: [rows, columns] float32, the table `upper`.
        phases: [rows] float64, the table `phase_of_frame`.
        frames: [cells] float32, the table `frame_of_phase`.
        clips: [C, CLIP_COLUMNS] float64, by number of clip or mirror image; a posture is six numbers from POSTURE on.
        rig: uint64, counts and widths; from COLUMNS on, the first column in a pose of each joint of the lower half,
            then of the upper half; then the offset in the sampled upper half of each joint of the hands.
        mirror: [lower lanes + upper lanes + 1, MIRROR_COLUMNS] float32, how a lane is mirrored, and how the upper cloud
            is; without rows if the rig has no mirror image.
        stances: [stances + 1, columns] float32, the stances of standing actions and of their mirror images, as rows of
            `upper`; in the last row the four planes are 1 in the lanes of trunk, left arm, right arm and head, else 0.
        hands: [rows of hands, columns] float32, the table `hands`.
        hand_rows: [H, C] int64, the first row in `hands` of each hands clip on each clip; -1 if not aligned to it.
    """

    lower: Annotated[Array, np.float32, 2]
    upper: Annotated[Array, np.float32, 2]
    phases: Annotated[Array, np.float64, 1]
    frames: Annotated[Array, np.float32, 1]
    clips: Annotated[Array, np.float64, 2]
    rig: Annotated[Array, np.uint64, 1]
    mirror: Annotated[Array, np.float32, 2]
    stances: Annotated[Array, np.float32, 2]
    hands: Annotated[Array, np.float32, 2]
    hand_rows: Annotated[Array, np.int64, 2]


class Scratch(NamedTuple):
    """Scratch memory of each thread, for one block of characters."""

    # [threads, 4 lower lanes + 4 upper lanes + 4 lanes of hands + 4 spare lanes + 4 upper lanes + 4 lanes of hands]
    lanes: Annotated[Array, np.float32, 2]
    block: Annotated[Array, np.float64, 2]  # [threads, BLOCK_ROWS * BLOCK]


class SpliceArrays(NamedTuple):
    """The arrays that kernels of the evaluator use, besides requests, memory and poses."""

    bank: BankArrays
    scratch: Scratch


def bank_arrays(bank: Bank) -> BankArrays:
    """Returns a bank as flat arrays, without copying its large tables."""
    layout, standing = bank.layout, {clip.name: row for row, clip in enumerate(c for c in bank.numbered if c.stands)}
    following, begins = dict[str, int](), dict[str, float]()
    for clip in bank.numbered:
        following |= {one: bank.number(then) for one, then in pairwise(clip.stretches)}
        begins |= {one: bank.begin_of(one) * clip.rate for one in clip.stretches}
    clips = np.array(
        [
            (
                *(clip.first_row, clip.frame_count, clip.row_count, clip.rate, clip.first_cell, clip.cell_count),
                *(clip.first_phase, clip.last_phase, clip.loop),
                (clip.cell_count - 1) / (clip.last_phase - clip.first_phase),
                *bank.posture(clip.name).ravel(),
                clip.gait,
                number >= len(bank.clips),
                HALF_A_CYCLE * (number >= len(bank.clips)),
                standing.get(clip.name, -1),
                clip.parts,
                *(bank.number(clip.stretches[0]) if clip.stretches else -1, following.get(clip.name, -1)),
                *(clip.enters, clip.leaves, begins.get(clip.name, 0.0)),
            )
            for number, clip in enumerate(bank.numbered)
        ]
    )
    widths = (layout.lower.first_plane, layout.lower.width, layout.upper.width, layout.cloud_width)
    columns = [4 * joint for half in layout.halves.values() for joint in half.joints]
    hand_rows = np.full((len(bank.hand_clips), len(bank.numbered)), -1, np.int64)
    for one in bank.hands:
        hand_rows[bank.hand_number(one.name), bank.number(one.body) :: len(bank.clips)] = one.first_row
    for number, clip in enumerate(bank.numbered):
        if clip.stretches:  # hands fit a hybrid if they fit all that it plays
            hand_rows[(hand_rows[:, [bank.number(one) for one in clip.stretches]] < 0).any(axis=1), number] = -1
    spare = layout.lower.width + layout.upper.width + layout.hands.width
    own = spare + max(layout.lower.width, layout.upper.width)
    counts = (len(layout.lower.joints), layout.hands.width, spare, len(layout.hands.joints), own)
    lanes = [4 * (FIRST_JOINT + layout.upper.joints.index(joint)) for joint in layout.hands.joints]
    return BankArrays(
        lower=bank.tables["lower"],
        upper=bank.tables["upper"],
        phases=bank.tables["phase_of_frame"],
        frames=bank.tables["frame_of_phase"],
        clips=clips,
        rig=np.array([*widths, layout.points, 4 * layout.pelvis, *counts, *columns, *lanes], np.uint64),
        mirror=lane_mirror(bank),
        stances=stance_rows(bank, standing),
        hands=bank.tables["hands"],
        hand_rows=hand_rows,
    )


def stance_rows(bank: Bank, standing: Iterable[str]) -> Array:
    """Returns the array `stances` of BankArrays, for the standing actions of these names."""
    layout, parts = bank.layout, np.zeros((1, bank.layout.upper.columns), np.float32)
    numbers = part_of_joint(bank.skeleton, bank.roles)[list(layout.upper.joints)]
    layout.upper.lanes(parts)[0, np.arange(FIRST_JOINT, FIRST_JOINT + len(numbers)), numbers] = 1.0
    stances = (bank.stance(name) for name in standing)
    return np.concatenate([*(packed_stance(layout, one) for one in stances if one is not None), parts])


def lane_mirror(bank: Bank) -> Array:
    """Returns the array `mirror` of BankArrays: each lane's twin, and what turns the twin's rotation into its own."""
    mirror, layout = bank.mirror, bank.layout
    if mirror is None:
        return np.zeros((0, MIRROR_COLUMNS), np.float32)
    above, pelvis = mirror.above(bank.skeleton.parents), layout.pelvis
    bare = np.tile(IDENTITY, (2, 1))  # of a torso's frame, which hangs on the pelvis's parent, and of its offset
    images = _images(np.concatenate([above, above[[pelvis]], bare[:1]]), np.concatenate([mirror.turns, bare]))
    parts = []
    for half in layout.halves.values():
        part = np.zeros((half.width, MIRROR_COLUMNS))
        part[:, TWIN], part[:, MATRIX:] = np.arange(half.width), np.eye(4).ravel()
        part[[PELVIS, POSTURE_FRAME, TORSO_OFFSET], MATRIX:] = images[[pelvis, -2, -1]]
        joints = [joint for joint in half.joints if mirror.twins[joint] >= 0]
        lanes = {joint: lane for lane, joint in enumerate(half.joints, half.first_joint)}
        own = [lanes[joint] for joint in joints]
        part[own, TWIN] = [lanes[int(mirror.twins[joint])] for joint in joints]
        part[own, MATRIX:] = images[joints]
        parts.append(part)
    cloud = np.zeros((1, MIRROR_COLUMNS))
    cloud[0, MATRIX : MATRIX + 9] = (to_matrices(conjugate(mirror.turns[pelvis])) * MIRROR).ravel()
    return np.concatenate([*parts, cloud]).astype(np.float32)


def _images(above: Floats, turns: Floats) -> Floats:
    """Returns matrices [n, 16] that take a rotation to `above^-1 f(q) turn`, its mirror image (`Mirror`)."""
    columns = multiply(multiply(conjugate(above)[:, None], np.diag(FLIP)), turns[:, None])
    return columns.transpose(0, 2, 1).reshape(len(above), 16)


def scratch(bank: BankArrays, threads: int) -> Scratch:
    """Returns scratch memory for `threads` threads."""
    lanes = 4 * int(bank.rig[OWN_UPPER] + bank.rig[UPPER_WIDTH] + bank.rig[HANDS_WIDTH])
    return Scratch(np.zeros((threads, lanes), np.float32), np.zeros((threads, BLOCK_ROWS * BLOCK)))
