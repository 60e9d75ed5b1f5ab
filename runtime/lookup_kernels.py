"""Where in the bank a character is: which rows of which tables, and how far between them.

Nothing here checks, allocates or holds the GIL. Whatever a table holds, the rows found lie in the clip.
"""

from __future__ import annotations

import math

import numpy as np

from runtime import arrays
from runtime.arrays import Array, BankArrays, Index, Real, Scratch
from runtime.compiled import inlined
from runtime.prefetch import prefetch
from runtime.rotation_kernels import ONE
from runtime.rows import LINE

NONE, NAIVE, SPLICE = 0, 1, 2  # methods
IN_STEP = 1e-3  # cycles by which an action may begin before its start and still count as in step


@inlined
def look_up(bank: BankArrays, requests: Array, first: int, count: int, scratch: Scratch, thread: int) -> None:
    """Finds the rows of `count` characters from the first, and has them fetched from memory while it goes on."""
    rows, shares, clips = scratch.rows[thread], scratch.shares[thread], bank.clips
    for k in range(count):
        request = requests[first + k]
        clip_l, clip_u = request["locomotion"], request["action"]
        first_u, rate_u = clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.RATE]
        frame_l = request["time"] * clips[clip_l, arrays.RATE]
        row_l, t_l = locate(frame_l, clips[clip_l, arrays.FIRST_ROW], clips[clip_l, arrays.FRAME_COUNT])
        fetch_ahead(bank.lower, row_l)
        if request["method"] == SPLICE:
            frame_u = action_frame(bank, clip_l, row_l, t_l, clip_u, request["start"])
            row_u, t_u = locate(frame_u, first_u, clips[clip_u, arrays.ROW_COUNT])
        elif request["method"] == NAIVE:
            count_u = clips[clip_u, arrays.FRAME_COUNT]
            frame_u = repeated((request["start"] + request["time"]) * rate_u, count_u - 1.0)
            row_u, t_u = locate(frame_u, first_u, count_u)
        else:
            row_u, t_u = row_l, t_l
        fetch_ahead(bank.upper, row_u)
        rows[0, k], rows[1, k] = row_l, row_u
        shares[0, k], shares[1, k] = t_l, t_u


@inlined
def action_frame(bank: BankArrays, clip_l: int, row_l: Index, t_l: float, clip_u: int, start: float) -> float:
    """The action's frame in step with the locomotion's: frame_of_phase_U(phase_of_frame_L + shift) (docs/bank.md)."""
    phases, clips = bank.phases, bank.clips
    first_u = clips[clip_u, arrays.FIRST_ROW]
    phase = between(phases, row_l, t_l)
    row, t = locate(start * clips[clip_u, arrays.RATE], first_u, clips[clip_u, arrays.FRAME_COUNT])
    phase += math.ceil(between(phases, row, t) - clips[clip_l, arrays.FIRST_PHASE] - IN_STEP)
    last, loop = clips[clip_u, arrays.LAST_PHASE], clips[clip_u, arrays.LOOP]
    if loop > 0.0 and phase > last:
        phase -= loop * math.ceil((phase - last) / loop)
    at = (phase - clips[clip_u, arrays.FIRST_PHASE]) * clips[clip_u, arrays.CELLS_PER_CYCLE]
    cell, t = locate(at, clips[clip_u, arrays.FIRST_CELL], clips[clip_u, arrays.CELL_COUNT])
    frame = between(bank.frames, cell, t)
    for _ in range(2):  # the table is as fine as its cells; from so near, the curve itself leads to the very frame
        row, t = locate(frame, first_u, clips[clip_u, arrays.ROW_COUNT])
        here = phases[row]
        frame = row - first_u + (phase - here) / (phases[row + ONE] - here)
    return frame


@inlined
def locate(at: float, first: float, count: float) -> tuple[np.uint64, float]:
    """The table row before a real-valued position in a clip's `count` rows, and how far past it; held at the ends."""
    at = at if at > 0.0 else 0.0  # of NaN too
    at = at if at < count - 1.0 else count - 1.0
    before = min(math.floor(at), count - 2.0)
    return np.uint64(first + before), at - before


@inlined
def between(table: Array, row: Index, t: float) -> float:
    """A curve's value `t` of the way from a row to the next."""
    here = table[row]
    return here + t * (table[row + ONE] - here)


@inlined
def between_rows(table: Array, row: Index, column: Index, t: Real) -> Real:
    """A column's value `t` of the way from a row to the next."""
    here = table[row, column]
    return here + t * (table[row + ONE, column] - here)


@inlined
def repeated(frame: float, last: float) -> float:
    """A frame counted on past the end, brought back into a clip whose last frame repeats its first moment."""
    return frame if frame <= last else frame - last * math.floor(frame / last)


@inlined
def fetch_ahead(table: Array, row: Index) -> None:
    """Has the processor fetch a row of a table and the next one, for memory is far."""
    for column in range(0, 2 * table.shape[1], LINE):
        prefetch(table, row, column)
