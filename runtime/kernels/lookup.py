"""Look-up: the rows of a bank for a character, and the position between them.

The rows lie in the clip even if a table is damaged.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BLOCK, NEXT, PHASE, ROW_L, ROW_U, SHARE_L, SHARE_U, BankArrays
from motionsplice.runtime.kernels.fetching import fetch_rows
from motionsplice.runtime.kernels.rotations import ONE
from motionsplice.runtime.simd.compiled import Array, Index, Real, inlined, kernel

NONE, NAIVE, SPLICE = 0, 1, 2  # methods
IN_STEP = 1e-3  # cycles by which an action may begin before its start


@kernel
def look_up(bank: BankArrays, requests: Array, first: int, count: int, block: Array) -> None:
    """Finds the rows of `count` characters from `first` on, as those of the next block.

    Each step is done for all characters before the next step, so that their waits for memory overlap. Rows that few
    requests need are prefetched.
    """
    clips, own_clocks = bank.clips, 0
    row_l, share_l = ROW_L * BLOCK + NEXT, SHARE_L * BLOCK + NEXT
    row_u, share_u = ROW_U * BLOCK + NEXT, SHARE_U * BLOCK + NEXT
    for k in range(count):
        request = requests[first + k]
        clip_l, clip_u = request["locomotion"], request["action"]
        first_l, count_l = clips[clip_l, arrays.FIRST_ROW], clips[clip_l, arrays.FRAME_COUNT]
        row, t = locate(request["time"] * clips[clip_l, arrays.RATE], first_l, count_l)
        block[row_l + k], block[share_l + k] = np.int64(row), t
        if follows_phase(bank, request):
            block[PHASE * BLOCK + k] = phase_in_step(bank, clip_l, row, t, clip_u, request["start"], request["cycles"])
        else:
            if request["method"] == SPLICE:
                own_clocks += 1
                fetch_rows(bank.upper, row)  # of the locomotion
                frame = own_frame(bank, clip_u, seconds_played(bank, request))
                row, t = locate(frame, clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.ROW_COUNT])
            elif request["method"] == NAIVE:
                count_u = clips[clip_u, arrays.FRAME_COUNT]
                frame = repeated((request["start"] + request["time"]) * clips[clip_u, arrays.RATE], count_u - 1.0)
                row, t = locate(frame, clips[clip_u, arrays.FIRST_ROW], count_u)
            fetch_hands(bank, int(request["hands"]) - 1, clip_l if request["method"] == NONE else clip_u, row)
            block[row_u + k], block[share_u + k] = np.int64(row), t
    for k in range(count):
        if requests[first + k]["method"] == SPLICE and (own_clocks == 0 or follows_phase(bank, requests[first + k])):
            block[row_u + k] = frame_near(bank, requests[first + k]["action"], block[PHASE * BLOCK + k])
    for k in range(count):
        if requests[first + k]["method"] == SPLICE and (own_clocks == 0 or follows_phase(bank, requests[first + k])):
            clip_u = requests[first + k]["action"]
            frame = frame_at(bank, clip_u, block[PHASE * BLOCK + k], block[row_u + k])
            row, t = locate(frame, clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.ROW_COUNT])
            fetch_hands(bank, int(requests[first + k]["hands"]) - 1, clip_u, row)
            block[row_u + k], block[share_u + k] = np.int64(row), t


@inlined
def is_mirrored(bank: BankArrays, clip: int) -> bool:
    """Whether a clip's number is that of a mirror image."""
    return bank.clips[clip, arrays.MIRRORED] > 0.0


@inlined
def follows_phase(bank: BankArrays, request: Array) -> bool:
    """Whether a request's action follows the phase of its locomotion: spliced, and not a standing action."""
    return request["method"] == SPLICE and bank.clips[request["action"], arrays.STANCE] < 0.0


@inlined
def seconds_played(bank: BankArrays, request: Array) -> float:
    """Returns the time of an action that plays at its own speed: also while its locomotion has gone back `cycles`."""
    seconds, clip = request["start"] + request["time"], request["locomotion"]
    if request["cycles"] != 0 and bank.clips[clip, arrays.LOOP] > 0.0:
        stride = frames_in_loop(bank, clip) / bank.clips[clip, arrays.LOOP] / bank.clips[clip, arrays.RATE]
        seconds = max(seconds + request["cycles"] * stride, 0.0)
    return seconds


@inlined
def own_frame(bank: BankArrays, clip: int, seconds: float) -> float:
    """Returns the frame that a clip shows after so many seconds at its own speed.

    At its end it goes on as its loop does; without a loop it holds its last frame.
    """
    frame, last = seconds * bank.clips[clip, arrays.RATE], bank.clips[clip, arrays.ROW_COUNT] - 1.0
    if frame > last and bank.clips[clip, arrays.LOOP] > 0.0:
        lasting = frames_in_loop(bank, clip)
        frame -= lasting * np.ceil((frame - last) / lasting)
    return min(frame, last)


@inlined
def frames_in_loop(bank: BankArrays, clip: int) -> float:
    """Returns how many frames a clip with a loop goes back at its last row."""
    phase = bank.clips[clip, arrays.LAST_PHASE] - bank.clips[clip, arrays.LOOP]
    return bank.clips[clip, arrays.ROW_COUNT] - 1.0 - frame_at(bank, clip, phase, frame_near(bank, clip, phase))


@inlined
def phase_in_step(bank: BankArrays, clip_l: int, row: Index, t: float, clip_u: int, start: float, cycles: int) -> float:
    """Returns the action's phase at a row of the locomotion.

    It is the locomotion's phase, plus the whole cycles that bring the action to its start or later, plus `cycles`,
    brought back by whole loops if the action has ended.
    """
    clips = bank.clips
    phase = between(bank.phases, row, t) + clips[clip_l, arrays.PHASE_SHIFT]
    begins = clips[clip_u, arrays.FIRST_PHASE]
    if start > 0.0:
        at = start * clips[clip_u, arrays.RATE]
        row, t = locate(at, clips[clip_u, arrays.FIRST_ROW], clips[clip_u, arrays.FRAME_COUNT])
        begins = between(bank.phases, row, t) + clips[clip_u, arrays.PHASE_SHIFT]
    phase += np.ceil(begins - clips[clip_l, arrays.FIRST_PHASE] - IN_STEP) + cycles
    last, loop = clips[clip_u, arrays.LAST_PHASE], clips[clip_u, arrays.LOOP]
    if loop > 0.0 and phase > last:
        phase -= loop * np.ceil((phase - last) / loop)
    return phase


@inlined
def frame_near(bank: BankArrays, clip: int, phase: float) -> float:
    """Returns a clip's frame at a phase, as exactly as the cells of frame_of_phase allow."""
    cell, t = cell_of(bank, clip, phase)
    return between(bank.frames, cell, t)


@inlined
def cell_of(bank: BankArrays, clip: int, phase: float) -> tuple[np.uint64, float]:
    """Returns the cell of frame_of_phase before a phase of a clip, and the share of the next cell."""
    clips = bank.clips
    at = (phase - clips[clip, arrays.FIRST_PHASE]) * clips[clip, arrays.CELLS_PER_CYCLE]
    return locate(at, clips[clip, arrays.FIRST_CELL], clips[clip, arrays.CELL_COUNT])


@inlined
def frame_at(bank: BankArrays, clip: int, phase: float, near: float) -> float:
    """Refines a frame near a phase to the exact frame, by a step along the phase curve.

    A second step is taken if the first leads to another row. Few do, so processors foresee it.
    """
    first, count = bank.clips[clip, arrays.FIRST_ROW], bank.clips[clip, arrays.ROW_COUNT]
    phase -= bank.clips[clip, arrays.PHASE_SHIFT]
    before, _ = divided(near, count)
    frame = frame_on(bank, first, before, phase)
    there, _ = divided(frame, count)
    return frame if there == before else frame_on(bank, first, there, phase)


@inlined
def frame_on(bank: BankArrays, first: float, before: np.int64, phase: float) -> float:
    """Returns the frame at a phase, on the line from a row of a clip, `before`, to the next."""
    row = as_index(first) + np.uint64(before)
    here = bank.phases[row]
    return before + (phase - here) / (bank.phases[row + ONE] - here)


@inlined
def frame_of(bank: BankArrays, clip: int, phase: float) -> float:
    """Returns a clip's real-valued frame at a phase, clamped to its ends."""
    last = bank.clips[clip, arrays.ROW_COUNT] - 1.0
    return min(max(frame_at(bank, clip, phase, frame_near(bank, clip, phase)), 0.0), last)


@inlined
def frame_after_last(bank: BankArrays, clip: int) -> float:
    """Returns the frame to which a looping clip jumps back from its last row."""
    return frame_of(bank, clip, bank.clips[clip, arrays.LAST_PHASE] - bank.clips[clip, arrays.LOOP])


@inlined
def locate(at: float, first: float, count: float) -> tuple[np.uint64, float]:
    """Returns the row before a real-valued position in a clip's `count` rows, and the share of the next; clamped."""
    before, t = divided(at, count)
    return as_index(first) + np.uint64(before), t


@inlined
def divided(at: float, count: float) -> tuple[np.int64, float]:
    """Returns the row before a position in `count` rows, as a number from the first on, and the share of the next."""
    at = at if at > 0.0 else 0.0  # NaN becomes 0 too
    at = at if at < count - 1.0 else count - 1.0
    before = np.int64(min(at, count - 1.5))  # the last row but one at most
    return before, at - before


@inlined
def as_index(at: float) -> np.uint64:
    """Returns a whole number of 0 or more as an index. Processors convert to signed integers in one instruction."""
    return np.uint64(np.int64(at))


@inlined
def between(table: Array, row: Index, t: float) -> float:
    """Interpolates a curve `t` of the way from a row to the next."""
    here = table[row]
    return here + t * (table[row + ONE] - here)


@inlined
def between_rows(table: Array, row: Index, column: Index, t: Real) -> Real:
    """Interpolates a column `t` of the way from a row to the next."""
    here = table[row, column]
    return here + t * (table[row + ONE, column] - here)


@inlined
def repeated(frame: float, last: float) -> float:
    """Wraps a frame past the end back into a clip whose last frame is the same moment as its first."""
    return frame if frame <= last else frame - last * np.floor(frame / last)


@inlined
def fetch_hands(bank: BankArrays, worn: int, clip: int, row: Index) -> None:
    """Prefetches the rows of hands on a clip, if aligned; `worn` is the number of the hands, negative for none."""
    if worn >= 0 and bank.hand_rows[worn, clip] >= 0:
        fetch_rows(bank.hands, row_of_hands(bank, worn, clip, row))


@inlined
def row_of_hands(bank: BankArrays, worn: int, clip: int, row: Index) -> np.uint64:
    """Returns the row of the table `hands` that goes with a row of a clip."""
    return row - as_index(bank.clips[clip, arrays.FIRST_ROW]) + np.uint64(bank.hand_rows[worn, clip])
