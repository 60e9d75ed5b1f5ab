"""The per-frame arithmetic on flat arrays. Nothing here allocates or holds the GIL; requests are checked at the door.

Characters are worked on in blocks: rows are looked up and fetched, each is sampled on its own, and what follows from
both samples is computed across the block. Each kernel has a slow, readable twin in `tests/naive.py`.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from runtime import arrays
from runtime.arrays import ALIGNED, BLOCK, FRAME, OWN, SPLICED, THEIRS, TURN, Array, BankArrays, MemoryArrays, Scratch
from runtime.compiled import inlined, kernel, parallel_kernel
from runtime.lookup_kernels import NAIVE, SPLICE, action_frame, between_rows, locate, look_up
from runtime.posture_kernels import RUNNING, correlate, other_postures, settle
from runtime.rotation_kernels import FOUR, horn, multiply, multiply_by_inverse, normalise, sample
from runtime.rows import ROOT


@kernel
def evaluate(
    bank: BankArrays, requests: Array, memory: MemoryArrays, scratch: Scratch, roots: Array, rotations: Array
) -> int:
    """Writes each character's root position [n, 3] and local rotations [n, 4 J]; returns `first_at_fault`.

    If there is one at fault, nothing is written.
    """
    fault = first_at_fault(bank, requests, len(memory.means) > 0)
    if fault < 0:
        evaluate_part(bank, requests, memory, scratch, 0, 0, len(requests), roots, rotations)
    return fault


@parallel_kernel
def evaluate_in_parallel(
    bank: BankArrays, requests: Array, memory: MemoryArrays, scratch: Scratch, roots: Array, rotations: Array
) -> None:
    """As `evaluate`, for sound requests, with as many threads as the scratch has room for."""
    threads = len(scratch.rows)
    blocks = (len(requests) + BLOCK - 1) // BLOCK
    for thread in prange(threads):
        first, stop = blocks * thread // threads * BLOCK, blocks * (thread + 1) // threads * BLOCK
        evaluate_part(bank, requests, memory, scratch, thread, first, min(stop, len(requests)), roots, rotations)


@kernel
def first_at_fault(bank: BankArrays, requests: Array, remembers: bool) -> int:
    """The first character that asks for what there is not; -1 if all are sound."""
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
        if not (0.0 <= request["time"] <= clips[locomotion, arrays.LATEST]):  # false for NaN
            return character
        if not (0.0 <= request["start"] <= clips[action, arrays.LATEST]):
            return character
    return -1


@kernel
def evaluate_part(
    bank: BankArrays,
    requests: Array,
    memory: MemoryArrays,
    scratch: Scratch,
    thread: int,
    begin: int,
    end: int,
    roots: Array,
    rotations: Array,
) -> None:
    pelvis = bank.rig[arrays.PELVIS_COLUMN]
    block = scratch.block[thread]
    for first in range(begin, end, BLOCK):
        count = min(BLOCK, end - first)
        look_up(bank, requests, first, count, scratch, thread)
        splices = 0
        for k in range(count):
            method = requests[first + k]["method"]
            sample_halves(bank, scratch, thread, k, first + k, roots, rotations)
            if method == SPLICE:
                correlate(bank, scratch, thread, k)
                splices += 1
            half = scratch.lanes[thread, 1 if method == NAIVE else 0]
            for i in range(FOUR):
                rotations[first + k, pelvis + i] = half[i]
        if splices > 0:
            horn(block)
            settle(requests, memory, block, first, count)
            multiply(block, SPLICED, ALIGNED, SPLICED)
            multiply_by_inverse(block, THEIRS, OWN, TURN)
            other_postures(bank, requests, memory, scratch, thread, first, count)
            multiply(block, FRAME, TURN, TURN)
            multiply_by_inverse(block, TURN, FRAME, TURN)
            multiply(block, TURN, SPLICED, SPLICED)
            normalise(block, SPLICED)
            for k in range(count):
                if requests[first + k]["method"] == SPLICE:
                    for i in range(FOUR):
                        rotations[first + k, pelvis + i] = block[(SPLICED + i) * BLOCK + k]


@inlined
def sample_halves(
    bank: BankArrays, scratch: Scratch, thread: int, k: int, character: int, roots: Array, rotations: Array
) -> None:
    """Both halves of a character between their rows: root and joints into its pose, all lanes into the scratch."""
    lower, rig, rows, shares = bank.lower, bank.rig, scratch.rows[thread], scratch.shares[thread]
    below, above = scratch.lanes[thread, 0], scratch.lanes[thread, 1]
    row, t, first = rows[0, k], shares[0, k], rig[arrays.FIRST_PLANE]
    for axis in range(3):
        roots[character, axis] = between_rows(lower, row, np.uint64(ROOT + axis), t)
    sample(lower, row, first, rig[arrays.LOWER_WIDTH], t, below)
    sample(bank.upper, rows[1, k], first, rig[arrays.UPPER_WIDTH], shares[1, k], above)
    place(bank.runs, 0, rig[arrays.LOWER_RUNS], below, rotations, character)
    place(bank.runs, rig[arrays.LOWER_RUNS], len(bank.runs), above, rotations, character)


@inlined
def place(runs: Array, first: int, stop: int, lanes: Array, rotations: Array, character: int) -> None:
    """Copies runs of joints into a pose."""
    for run in range(first, stop):
        source, target = runs[run, 0], runs[run, 1]
        for i in range(runs[run, 2]):
            rotations[character, target + i] = lanes[source + i]


@kernel
def action_frames(bank: BankArrays, requests: Array, frames: Array) -> None:
    """Writes each character's real-valued action frame [n]."""
    for character in range(len(requests)):
        request = requests[character]
        clip = request["locomotion"]
        at = request["time"] * bank.clips[clip, arrays.RATE]
        row, t = locate(at, bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.FRAME_COUNT])
        frames[character] = action_frame(bank, clip, row, t, request["action"], request["start"])
