"""The per-frame arithmetic on flat arrays. Nothing here checks, allocates or holds the GIL; callers check.

Each kernel has a slow, readable twin in `tests/naive.py`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import njit
from numpy.typing import NDArray

from runtime.rotation_kernels import horn, multiply, multiply_by_inverse, normalise_into, rotate, slerp

NONE, NAIVE, SPLICE = 0, 1, 2  # methods
OFF, RELATIVE, ABSOLUTE, RUNNING = 0, 1, 2, 3  # postures
IN_STEP = 1e-3  # cycles by which an action may begin before its start and still count as in step

Array = NDArray[Any]


class BankArrays(NamedTuple):
    """A bank as the kernels see it: `TABLES`, the clips' columns, and what follows from them.

    lower, upper: joints of the two halves; the pelvis is in neither.
    """

    rotations: Array
    root_positions: Array
    phase_of_frame: Array
    frame_of_phase: Array
    upper_clouds: Array
    posture_frames: Array
    torso_offsets: Array
    postures: Array
    first_row: Array
    frame_count: Array
    row_count: Array
    rate: Array
    first_cell: Array
    cell_count: Array
    first_phase: Array
    last_phase: Array
    loop: Array
    parents: Array
    offsets: Array
    lower: Array
    upper: Array
    pelvis: int


class RequestArrays(NamedTuple):
    """What each of n characters plays: clips by number, times in seconds, method and posture by constant."""

    locomotion: Array
    time: Array
    action: Array
    start: Array
    method: Array
    posture: Array


class PostureArrays(NamedTuple):
    """Each of n characters' running posture [n, 2, 3], NaN before its first frame, and how much a new frame counts."""

    means: Array
    share: float


class Scratch(NamedTuple):
    """Room for one character's intermediate values."""

    pelvis: Array  # [4]
    turn: Array  # [4]
    frame: Array  # [4]
    other: Array  # [4]
    correlation: Array  # [3, 3]


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate(
    bank: BankArrays,
    requests: RequestArrays,
    running: PostureArrays,
    scratch: Scratch,
    roots: Array,
    rotations: Array,
) -> None:
    """Writes each character's root position [n, 3] and local rotations [n, joints, 4]."""
    for character in range(len(requests.time)):
        clip_l, clip_u = requests.locomotion[character], requests.action[character]
        method = requests.method[character]
        frame_l = requests.time[character] * bank.rate[clip_l]
        row_l, t_l = locate(frame_l, bank.first_row[clip_l], bank.frame_count[clip_l])
        for axis in range(3):
            here = bank.root_positions[row_l, axis]
            roots[character, axis] = here + t_l * (bank.root_positions[row_l + 1, axis] - here)
        out = rotations[character]
        sample(bank.rotations, row_l, t_l, bank.lower, out)
        slerp(bank.rotations[row_l, bank.pelvis], bank.rotations[row_l + 1, bank.pelvis], t_l, scratch.pelvis)
        if method == NONE:
            sample(bank.rotations, row_l, t_l, bank.upper, out)
        elif method == NAIVE:
            seconds = requests.start[character] + requests.time[character]
            frame_u = repeated(seconds * bank.rate[clip_u], bank.frame_count[clip_u] - 1.0)
            row_u, t_u = locate(frame_u, bank.first_row[clip_u], bank.frame_count[clip_u])
            sample(bank.rotations, row_u, t_u, bank.upper, out)
            slerp(
                bank.rotations[row_u, bank.pelvis],
                bank.rotations[row_u + 1, bank.pelvis],
                t_u,
                scratch.pelvis,
            )
        else:
            frame_u = action_frame(bank, clip_l, row_l, t_l, clip_u, requests.start[character])
            row_u, t_u = locate(frame_u, bank.first_row[clip_u], bank.row_count[clip_u])
            sample(bank.rotations, row_u, t_u, bank.upper, out)
            correlate_clouds(bank.upper_clouds, row_l, t_l, row_u, t_u, scratch.correlation)
            horn(scratch.correlation, scratch.turn)
            multiply(scratch.pelvis, scratch.turn, scratch.pelvis)
            posture = requests.posture[character]
            if posture != OFF:
                slerp(bank.posture_frames[row_l], bank.posture_frames[row_l + 1], t_l, scratch.frame)
                if posture == RELATIVE:
                    relative_turn(bank, row_l, t_l, row_u, t_u, scratch)
                elif posture == ABSOLUTE:
                    posture_turn(bank.postures[clip_u], bank.postures[clip_l], scratch)
                else:
                    follow_posture(bank, running, character, clip_l, row_u, t_u, scratch)
                    posture_turn(bank.postures[clip_u], running.means[character], scratch)
                transfer_posture(scratch)
        normalise_into(scratch.pelvis, out[bank.pelvis])


@njit(cache=True, nogil=True, error_model="numpy")
def action_frames(bank: BankArrays, requests: RequestArrays, frames: Array) -> None:
    """Writes each character's real-valued action frame [n]."""
    for character in range(len(requests.time)):
        clip_l = requests.locomotion[character]
        frame_l = requests.time[character] * bank.rate[clip_l]
        row_l, t_l = locate(frame_l, bank.first_row[clip_l], bank.frame_count[clip_l])
        frames[character] = action_frame(
            bank, clip_l, row_l, t_l, requests.action[character], requests.start[character]
        )


@njit(cache=True, nogil=True, error_model="numpy")
def action_frame(bank: BankArrays, clip_l: int, row_l: int, t_l: float, clip_u: int, start: float) -> float:
    """The action's frame in step with the locomotion's: frame_of_phase_U(phase_of_frame_L + shift) (docs/bank.md)."""
    here = bank.phase_of_frame[row_l]
    phase = here + t_l * (bank.phase_of_frame[row_l + 1] - here)
    row_s, t_s = locate(start * bank.rate[clip_u], bank.first_row[clip_u], bank.frame_count[clip_u])
    start_phase = bank.phase_of_frame[row_s]
    start_phase += t_s * (bank.phase_of_frame[row_s + 1] - start_phase)
    phase += math.ceil(start_phase - bank.first_phase[clip_l] - IN_STEP)
    first, last, loop = bank.first_phase[clip_u], bank.last_phase[clip_u], bank.loop[clip_u]
    if loop > 0 and phase > last:
        phase -= loop * math.ceil((phase - last) / loop)
    cells = bank.cell_count[clip_u]
    cell, t = locate((phase - first) / (last - first) * (cells - 1.0), bank.first_cell[clip_u], cells)
    frame = bank.frame_of_phase[cell]
    frame += t * (bank.frame_of_phase[cell + 1] - frame)
    for _ in range(2):  # the table is as fine as its cells; from so near, the curve itself leads to the very frame
        row, t = locate(frame, bank.first_row[clip_u], bank.row_count[clip_u])
        here = bank.phase_of_frame[row]
        frame = row - bank.first_row[clip_u] + (phase - here) / (bank.phase_of_frame[row + 1] - here)
    return frame


@njit(cache=True, nogil=True, error_model="numpy")
def relative_turn(bank: BankArrays, row_l: int, t_l: float, row_u: int, t_u: float, scratch: Scratch) -> None:
    """q_G into scratch.turn: what the action does beyond its gait now, without what the locomotion does beyond its."""
    turn, own = scratch.turn, scratch.other
    slerp(bank.torso_offsets[row_u], bank.torso_offsets[row_u + 1], t_u, turn)
    slerp(bank.torso_offsets[row_l], bank.torso_offsets[row_l + 1], t_l, own)
    multiply_by_inverse(turn, own, turn)


@njit(cache=True, nogil=True, error_model="numpy")
def posture_turn(wanted: Array, given: Array, scratch: Scratch) -> None:
    """q_G into scratch.turn: from one posture [2, 3] to another."""
    correlation = scratch.correlation
    for i in range(3):
        for j in range(3):
            correlation[i, j] = wanted[0, i] * given[0, j] + wanted[1, i] * given[1, j]
    horn(correlation, scratch.turn)


@njit(cache=True, nogil=True, error_model="numpy")
def follow_posture(
    bank: BankArrays, running: PostureArrays, character: int, clip_l: int, row_u: int, t_u: float, scratch: Scratch
) -> None:
    """Takes the shoulders of the splice so far, as seen in the posture frame, into the character's running mean."""
    mean, seen, shoulder = running.means[character], scratch.other, scratch.correlation[0]
    for i in range(4):
        seen[i] = scratch.frame[i] * (1.0 if i == 3 else -1.0)
    multiply(seen, scratch.pelvis, seen)
    first = bank.upper_clouds.shape[1] - 2
    for point in range(2):
        for i in range(3):
            here = bank.upper_clouds[row_u, first + point, i]
            shoulder[i] = here + t_u * (bank.upper_clouds[row_u + 1, first + point, i] - here)
        rotate(seen, shoulder, shoulder)
        for i in range(3):
            if math.isnan(mean[point, i]):
                mean[point, i] = bank.postures[clip_l, point, i]
            mean[point, i] += running.share * (shoulder[i] - mean[point, i])


@njit(cache=True, nogil=True, error_model="numpy")
def transfer_posture(scratch: Scratch) -> None:
    """Turns the pelvis by q_G, applied in the locomotion's posture frame (docs/method.md)."""
    turn, frame = scratch.turn, scratch.frame
    multiply(frame, turn, turn)
    multiply_by_inverse(turn, frame, turn)
    multiply(turn, scratch.pelvis, scratch.pelvis)


@njit(cache=True, nogil=True, error_model="numpy")
def locate(at: float, first: int, count: int) -> tuple[int, float]:
    """The table row before a real-valued position in a clip's `count` rows, and how far past it; held at the ends."""
    at = min(max(at, 0.0), count - 1.0)
    before = min(int(at), count - 2)
    return first + before, at - before


@njit(cache=True, nogil=True, error_model="numpy")
def repeated(frame: float, last: float) -> float:
    """A frame counted on past the end, brought back into a clip whose last frame repeats its first moment."""
    return frame if frame <= last else frame - last * math.floor(frame / last)


@njit(cache=True, nogil=True, error_model="numpy")
def sample(table: Array, row: int, t: float, joints: Array, out: Array) -> None:
    """Local rotations of `joints` between two rows of a table [frames, joints, 4], into `out` [joints, 4]."""
    for joint in joints:
        slerp(table[row, joint], table[row + 1, joint], t, out[joint])


@njit(cache=True, nogil=True, error_model="numpy")
def correlate_clouds(clouds: Array, row_l: int, t_l: float, row_u: int, t_u: float, out: Array) -> None:
    """sum over points of target (locomotion) times source (action), [3, 3], both between two rows."""
    out[:] = 0.0
    for point in range(clouds.shape[1]):
        for i in range(3):
            target = clouds[row_l, point, i] + t_l * (clouds[row_l + 1, point, i] - clouds[row_l, point, i])
            for j in range(3):
                source = clouds[row_u, point, j] + t_u * (clouds[row_u + 1, point, j] - clouds[row_u, point, j])
                out[i, j] += target * source


@njit(cache=True, nogil=True, error_model="numpy")
def world_positions(bank: BankArrays, roots: Array, rotations: Array, world: Array, positions: Array) -> None:
    """World positions [n, joints, 3] of evaluated poses; `world` [joints, 4] is room for one character."""
    for character in range(len(roots)):
        for axis in range(3):
            positions[character, 0, axis] = roots[character, axis]
        for i in range(4):
            world[0, i] = rotations[character, 0, i]
        for joint in range(1, len(bank.parents)):
            parent, place = bank.parents[joint], positions[character, joint]
            rotate(world[parent], bank.offsets[joint], place)
            for axis in range(3):
                place[axis] += positions[character, parent, axis]
            multiply(world[parent], rotations[character, joint], world[joint])
