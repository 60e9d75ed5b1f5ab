"""Evaluates splices on flat arrays.

Characters are computed in blocks. The rows of a block are looked up before those of the block before are sampled, which
prefetches them. Each character is sampled on its own; alignment and posture are computed across the block.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from motionsplice.runtime.format.rows import FIRST_JOINT, PELVIS, ROOT
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import (
    BLOCK,
    NEXT,
    ROW_L,
    ROW_U,
    SHARE_L,
    SHARE_U,
    SPLICED,
    BankArrays,
    Scratch,
    SpliceArrays,
)
from motionsplice.runtime.kernels.fetching import fetch_cloud, fetch_rows
from motionsplice.runtime.kernels.hands import lay_hands
from motionsplice.runtime.kernels.lookup import (
    NAIVE,
    NONE,
    SPLICE,
    as_index,
    frame_at,
    frame_near,
    is_mirrored,
    locate,
    look_up,
    own_frame,
    phase_in_step,
    seconds_played,
)
from motionsplice.runtime.kernels.mirror import mirror_lower, mirror_upper
from motionsplice.runtime.kernels.posture import RUNNING, correlate, is_aligned, turn_pelves
from motionsplice.runtime.kernels.rotations import ONE, quaternion_in, sample, sample_and_fetch
from motionsplice.runtime.kernels.standing import lay_on
from motionsplice.runtime.simd.compiled import Array, Index, inlined, kernel, parallel_kernel
from motionsplice.runtime.simd.handle import Handle, record_at

AHEAD = 2  # characters by which rows are prefetched


@kernel
def evaluate(handle: Handle, requests: Array, memory: Array, share: float, roots: Array, rotations: Array) -> int:
    """Writes each character's root position [n, 3] and local rotations [n, 4 J]; returns `first_at_fault`.

    If a request is invalid, nothing is written. memory [m, MEMORY_COLUMNS] has m = n, 1 (all requests are about one
    character) or 0. handle is that of a SpliceArrays; share is the weight of a new frame in a running posture.
    """
    bank, scratch = record_at(handle, SpliceArrays)
    fault = first_at_fault(bank, requests, len(memory) > 0)
    if fault < 0:
        evaluate_part(bank, requests, memory, share, scratch, 0, 0, len(requests), roots, rotations)
    return fault


@kernel
def evaluate_in_parallel(
    handle: Handle, requests: Array, memory: Array, share: float, roots: Array, rotations: Array
) -> int:
    """As `evaluate`, with as many threads as `scratch` has; memory must have n or 0 rows."""
    bank, scratch = record_at(handle, SpliceArrays)
    fault = first_at_fault(bank, requests, len(memory) > 0)
    if fault < 0:
        evaluate_parts(bank, requests, memory, share, scratch, roots, rotations)
    return fault


@parallel_kernel
def evaluate_parts(
    bank: BankArrays, requests: Array, memory: Array, share: float, scratch: Scratch, roots: Array, rotations: Array
) -> None:
    """Evaluates a part of the requests in each thread. Numba passes to threads only records that are arguments."""
    threads, blocks = len(scratch.lanes), (len(requests) + BLOCK - 1) // BLOCK
    for thread in prange(threads):
        first, stop = blocks * thread // threads * BLOCK, blocks * (thread + 1) // threads * BLOCK
        stop = min(stop, len(requests))
        evaluate_part(bank, requests, memory, share, scratch, thread, first, stop, roots, rotations)


@kernel
def first_at_fault(bank: BankArrays, requests: Array, remembers: bool) -> int:
    """Returns the index of the first invalid request, -1 if all are valid."""
    clips = bank.clips
    for character in range(len(requests)):
        request = requests[character]
        locomotion, action = request["locomotion"], request["action"]
        if not (0 <= locomotion < len(clips) and 0 <= action < len(clips)):
            return character
        if request["method"] > SPLICE or request["posture"] > RUNNING:
            return character
        if request["method"] == SPLICE and request["posture"] == RUNNING and not remembers:
            return character
        hands = int(request["hands"]) - 1
        if hands >= len(bank.hand_rows):
            return character
        if hands >= 0 and bank.hand_rows[hands, upper_clip(request)] < 0:
            return character
        waits = request["start"] < 0.0 and clips[action, arrays.LEAVES] > 0.0  # a stretch that takes over later
        if not (within(clips, locomotion, request["time"]) and (waits or within(clips, action, request["start"]))):
            return character
    return -1


@inlined
def upper_clip(request: Array) -> int:
    """Returns the clip that gives the upper body."""
    return int(request["locomotion"]) if request["method"] == NONE else int(request["action"])


@inlined
def within(clips: Array, clip: int, seconds: float) -> bool:
    """Whether a time lies within a clip; false for NaN."""
    return (
        seconds >= 0.0 and (seconds - arrays.LATE) * clips[clip, arrays.RATE] <= clips[clip, arrays.FRAME_COUNT] - 1.0
    )


@kernel
def evaluate_part(
    bank: BankArrays,
    requests: Array,
    memory: Array,
    share: float,
    scratch: Scratch,
    thread: int,
    begin: int,
    end: int,
    roots: Array,
    rotations: Array,
) -> None:
    """Evaluates the requests from `begin` to `end` with the scratch memory of one thread."""
    lanes, block, pelvis = scratch.lanes[thread], scratch.block[thread], bank.rig[arrays.PELVIS_COLUMN]
    above = np.uint64(4) * bank.rig[arrays.LOWER_WIDTH]  # offset of the upper half in lanes
    look_up(bank, requests, begin, min(BLOCK, end - begin), block)
    for k in range(NEXT, NEXT + min(AHEAD, end - begin)):
        fetch_rows(bank.lower, as_index(block[ROW_L * BLOCK + k]))
        fetch_rows(bank.upper, as_index(block[ROW_U * BLOCK + k]))
    for first in range(begin, end, BLOCK):
        count = min(BLOCK, end - first)
        take_next(block)
        look_up(bank, requests, first + count, min(BLOCK, end - first - count), block)
        splices = added = 0
        for k in range(count):
            method = requests[first + k]["method"]
            adds = method == SPLICE and not is_aligned(bank, requests[first + k])
            sample_halves(bank, requests, block, k, adds, lanes, above, first + k, roots, rotations)
            if adds:
                added += 1
            elif method == SPLICE:
                mirrored_l = is_mirrored(bank, requests[first + k]["locomotion"])
                mirrored_u = is_mirrored(bank, requests[first + k]["action"])
                correlate(bank, bank.lower, mirrored_l, mirrored_u, block, k, lanes, above)
                splices += 1
            half = np.uint64(4 * PELVIS) + (above if adds or method == NAIVE else np.uint64(0))
            copy_rotation(lanes, half, rotations, first + k, pelvis)
        if splices > 0:
            turn_pelves(bank, requests, memory, share, block, first, count)
            for k in range(count):
                request = requests[first + k]
                if request["method"] == SPLICE and (added == 0 or is_aligned(bank, request)):
                    for i in range(4):
                        rotations[first + k, pelvis + np.uint64(i)] = block[(SPLICED + i) * BLOCK + k]


@inlined
def take_next(block: Array) -> None:
    """Makes the rows and shares that were looked up those of this block."""
    for row in (ROW_L, SHARE_L, ROW_U, SHARE_U):
        for k in range(BLOCK):
            block[row * BLOCK + k] = block[row * BLOCK + NEXT + k]


@inlined
def sample_halves(
    bank: BankArrays,
    requests: Array,
    block: Array,
    k: int,
    adds: bool,
    lanes: Array,
    above: Index,
    character: int,
    roots: Array,
    rotations: Array,
) -> None:
    """Samples both halves of a character: root and joints into its pose, all rotations into `lanes`.

    Meanwhile prefetches the rows of the character AHEAD; after the last character, any rows. If the request `adds` its
    action to the locomotion, the upper half is that of the splice.
    """
    lower, rig = bank.lower, bank.rig
    row, t, first = as_index(block[ROW_L * BLOCK + k]), np.float32(block[SHARE_L * BLOCK + k]), rig[arrays.FIRST_PLANE]
    ahead_l, ahead_u = as_index(block[ROW_L * BLOCK + k + AHEAD]), as_index(block[ROW_U * BLOCK + k + AHEAD])
    for axis in range(np.uint64(ROOT), np.uint64(ROOT + 3)):
        here = lower[row, axis]
        roots[character, axis] = here + t * (lower[row + ONE, axis] - here)
    sample_and_fetch(lower, row, ahead_l, first, rig[arrays.LOWER_WIDTH], t, lanes, np.uint64(0))
    if is_mirrored(bank, requests[character]["locomotion"]):
        roots[character, ROOT] = -roots[character, ROOT]
        mirror_lower(bank, lanes)
    row, t = as_index(block[ROW_U * BLOCK + k]), np.float32(block[SHARE_U * BLOCK + k])
    sample_and_fetch(bank.upper, row, ahead_u, first, rig[arrays.UPPER_WIDTH], t, lanes, above)
    request = requests[character]
    if request["hands"] > 0:
        hands = int(request["hands"]) - 1
        lay_hands(bank, hands, upper_clip(request), row, t, np.float32(1.0), lanes, above)
    if is_mirrored(bank, upper_clip(request)):
        mirror_upper(bank, lanes, above)
    if adds:
        own = np.uint64(4) * rig[arrays.OWN_UPPER]
        row_l, t_l = as_index(block[ROW_L * BLOCK + k]), np.float32(block[SHARE_L * BLOCK + k])
        sample(bank.upper, row_l, first, rig[arrays.UPPER_WIDTH], t_l, lanes, own)
        if is_mirrored(bank, request["locomotion"]):
            mirror_upper(bank, lanes, own)
        lay_on(bank, request["action"], row, t, lanes, own, above)
    copy_lower(rig, lanes, rotations, character)
    fetch_cloud(lower, ahead_l, first)
    copy_upper(rig, lanes, above, rotations, character)
    fetch_cloud(bank.upper, ahead_u, first)


@inlined
def copy_lower(rig: Array, lanes: Array, rotations: Array, character: int) -> None:
    """Copies the joints of the lower half from lanes into a pose."""
    at = np.uint64(4 * FIRST_JOINT)
    for joint in range(np.uint64(arrays.COLUMNS), np.uint64(arrays.COLUMNS) + rig[arrays.LOWER_COUNT]):
        copy_rotation(lanes, at, rotations, character, rig[joint])
        at += np.uint64(4)


@inlined
def copy_upper(rig: Array, lanes: Array, above: Index, rotations: Array, character: int) -> None:
    """Copies the joints of the upper half, which begins at `above`, from lanes into a pose."""
    at = above + np.uint64(4 * FIRST_JOINT)
    count = np.uint64(len(rig)) - rig[arrays.HANDS_COUNT]
    for joint in range(np.uint64(arrays.COLUMNS) + rig[arrays.LOWER_COUNT], count):
        copy_rotation(lanes, at, rotations, character, rig[joint])
        at += np.uint64(4)


@inlined
def copy_rotation(lanes: Array, at: Index, rotations: Array, character: int, column: Index) -> None:
    """Copies one rotation from lanes into a pose."""
    x, y, z, w = quaternion_in(lanes, at)
    rotations[character, column], rotations[character, column + ONE] = x, y
    rotations[character, column + ONE + ONE], rotations[character, column + ONE + ONE + ONE] = z, w


@kernel
def action_frames(handle: Handle, requests: Array, frames: Array) -> None:
    """Writes each character's real-valued action frame [n]."""
    bank = record_at(handle, SpliceArrays).bank
    clips = bank.clips
    for character in range(len(requests)):
        request = requests[character]
        locomotion, action = request["locomotion"], request["action"]
        at = request["time"] * clips[locomotion, arrays.RATE]
        row, t = locate(at, clips[locomotion, arrays.FIRST_ROW], clips[locomotion, arrays.FRAME_COUNT])
        if bank.clips[action, arrays.STANCE] >= 0.0:
            frames[character] = own_frame(bank, action, seconds_played(bank, request))
        else:
            phase = phase_in_step(bank, locomotion, row, t, action, request["start"], request["cycles"])
            frames[character] = frame_at(bank, action, phase, frame_near(bank, action, phase))
