"""Where in the bank a character is: which rows of which tables, and how far between them.

Whatever a table holds, the rows found lie in the clip.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.format.rows import LINE
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, PHASE, ROW_L, ROW_U, SHARE_L, SHARE_U, BankArrays
from motionsplice.runtime.kernels.rotations import ONE
from motionsplice.runtime.simd.compiled import Array, Index, inlined, kernel
from motionsplice.runtime.simd.prefetch import prefetch

NONE, NAIVE, SPLICE = 0, 1, 2  # methods
IN_STEP = 1e-3  # cycles by which an action may begin before its start and still count as in step


@kernel
def look_up(bank: BankArrays, requests: Array, first: int, count: int, block: Array) -> None:
    """Finds the rows of `count` characters from the first, and has them fetched from memory while it goes on.

    What must wait for memory waits for all characters at once: one step for all, then the next.
    """
    clips = bank.clips
    for k in range(count):
        request = requests[first + k]
        clip_l, clip_u = request["locomotion"], request["action"]
        first_l, count_l = clips[clip_l, arrays.FIRST_ROW], clips[clip_l, arrays.FRAME_COUNT]
        row, t = locate(request["time"] * clips[clip_l, arrays.RATE], first_l, count_l)
        fetch_ahead(bank.lower, row)
        block[ROW_L * BLOCK + k], block[SHARE_L * BLOCK + k] = row, t
        if request["method"] == SPLICE:
            block[PHASE * BLOCK + k] = phase_in_step(bank, clip_l, row, t, clip_u, request["start"], request["cycles"])
        else:
            if request["method"] == NAIVE:
                count_u = clips[clip_u, arrays.FRAME_COUNT]
                frame = repeated((request["start"] + request["time"]) * clips[clip_u, arrays.RATE], count_u - 1.0)
                row, t = locate(frame, clips[clip_u, arrays.FIRST_ROW], count_u)
            fetch_ahead(bank.upper, row)
            fetch_hands(bank, int(request["hands"]) - 1, clip_u if request["method"] == NAIVE else clip_l, row)
            block[ROW_U * BLOCK + k], block[SHARE_U * BLOCK + k] = row, t
    for k in range(count):
        if requests[first + k]["method"] == SPLICE:
            block[ROW_U * BLOCK + k] = frame_near(bank, requests[first + k]["action"], block[PHASE * BLOCK + k])
    for k in range(count):
        if requests[first + k]["method"] == SPLICE:
            clip_u = requests[first + k]["action"]
            frame = frame_at(bank, clip_u, block[PHASE * BLOCK + k], block[ROW_U * BLOCK + k])
            row, t = locate(frame, clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.ROW_COUNT])
            fetch_ahead(bank.upper, row)
            fetch_hands(bank, int(requests[first + k]["hands"]) - 1, clip_u, row)
            block[ROW_U * BLOCK + k], block[SHARE_U * BLOCK + k] = row, t


@inlined
def phase_in_step(bank: BankArrays, clip_l: int, row: Index, t: float, clip_u: int, start: float, cycles: int) -> float:
    """The action's phase: the locomotion's, as many cycles more as bring it to the start or after it, and `cycles`."""
    clips = bank.clips
    phase, rate_u = between(bank.phases, row, t), clips[clip_u, arrays.RATE]
    row, t = locate(start * rate_u, clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.FRAME_COUNT])
    phase += np.ceil(between(bank.phases, row, t) - clips[clip_l, arrays.FIRST_PHASE] - IN_STEP) + cycles
    last, loop = clips[clip_u, arrays.LAST_PHASE], clips[clip_u, arrays.LOOP]
    if loop > 0.0 and phase > last:
        phase -= loop * np.ceil((phase - last) / loop)
    return phase


@inlined
def frame_near(bank: BankArrays, clip: int, phase: float) -> float:
    """A clip's frame at a phase, to within what the cells of frame_of_phase are apart."""
    clips = bank.clips
    at = (phase - clips[clip, arrays.FIRST_PHASE]) * clips[clip, arrays.CELLS_PER_CYCLE]
    cell, t = locate(at, clips[clip, arrays.FIRST_CELL], clips[clip, arrays.CELL_COUNT])
    return between(bank.frames, cell, t)


@inlined
def frame_at(bank: BankArrays, clip: int, phase: float, near: float) -> float:
    """The very frame at a phase, from one that is near: the curve itself leads to it."""
    first, count = bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT]
    for _ in range(2):
        row, _ = locate(near, first, count)
        here = bank.phases[row]
        near = row - first + (phase - here) / (bank.phases[row + ONE] - here)
    return near


@inlined
def locate(at: float, first: float, count: float) -> tuple[np.uint64, float]:
    """The table row before a real-valued position in a clip's `count` rows, and how far past it; held at the ends."""
    at = at if at > 0.0 else 0.0  # of NaN too
    at = at if at < count - 1.0 else count - 1.0
    before = min(np.floor(at), count - 2.0)
    return np.uint64(first + before), at - before


@inlined
def between(table: Array, row: Index, t: float) -> float:
    """A curve's value `t` of the way from a row to the next."""
    here = table[row]
    return here + t * (table[row + ONE] - here)


@inlined
def repeated(frame: float, last: float) -> float:
    """A frame counted on past the end, brought back into a clip whose last frame repeats its first moment."""
    return frame if frame <= last else frame - last * np.floor(frame / last)


@inlined
def fetch_ahead(table: Array, row: Index) -> None:
    """Has the processor fetch a row of a table and the next one, for memory is far."""
    for column in range(0, 2 * table.shape[1], LINE):
        prefetch(table, row, column)


@inlined
def fetch_hands(bank: BankArrays, worn: int, clip: int, row: Index) -> None:
    """The same of hands on a clip, if there are any: `worn` is their number, negative for none."""
    if worn >= 0 and bank.hand_rows[worn, clip] >= 0:
        fetch_ahead(bank.hands, row_of_hands(bank, worn, clip, row))


@inlined
def row_of_hands(bank: BankArrays, worn: int, clip: int, row: Index) -> np.uint64:
    """The row of hands that lies beside a clip's own."""
    return row - np.uint64(bank.clips[clip, arrays.FIRST_ROW]) + np.uint64(bank.hand_rows[worn, clip])
