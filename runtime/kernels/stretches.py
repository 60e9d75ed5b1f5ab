"""Plays hybrid actions, which stand and walk by turns: finds the stretch that a request shows, and blends two of them.

A hybrid's stretches are clips of the bank. One that stands plays at its own speed, one that walks follows the
locomotion's phase; each takes over where the one before hands over (docs/bank.md).
"""

from __future__ import annotations

import math

import numpy as np

from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.kernels.arrays import BankArrays, SpliceArrays
from motionsplice.runtime.kernels.curves import smooth
from motionsplice.runtime.kernels.evaluate import first_at_fault
from motionsplice.runtime.kernels.lookup import IN_STEP, SPLICE, frame_of, frames_in_loop
from motionsplice.runtime.kernels.phase import phase_of
from motionsplice.runtime.simd.compiled import Array, inlined, kernel
from motionsplice.runtime.simd.handle import Handle, record_at

HANDOVER = 0.4  # seconds in which a stretch fades in over the one before
EARLIER = 0.25  # cycles by which a walking stretch may begin before it takes over, to be in step


@kernel
def shows_hybrids(handle: Handle, requests: Array) -> bool:
    """Whether any request shows a hybrid; invalid ones do not."""
    bank = record_at(handle, SpliceArrays).bank
    for character in range(len(requests)):
        action = requests[character]["action"]
        spliced = requests[character]["method"] == SPLICE and 0 <= action < len(bank.clips)
        if spliced and bank.clips[action, arrays.FIRST_STRETCH] >= 0.0:
            return True
    return False


@kernel
def resolve(handle: Handle, requests: Array, now: Array, before: Array, shares: Array) -> int:
    """Replaces hybrids by their stretches; returns `first_at_fault`. If a request is invalid, nothing is written.

    now, before: copies of the requests [n]; where a request shows a hybrid, `now` becomes one for the newest stretch,
    and `before` one for the stretch before it. shares: [n] of `now` in the result, 1 where nothing is blended.
    """
    bank = record_at(handle, SpliceArrays).bank
    fault = first_at_fault(bank, requests, True)
    if fault >= 0:
        return fault
    for character in range(len(requests)):
        request, shares[character] = requests[character], 1.0
        if request["method"] == SPLICE and bank.clips[request["action"], arrays.FIRST_STRETCH] >= 0.0:
            shares[character] = find_stretch(bank, request, now[character], before[character])
    return fault


@kernel
def find_stretch(bank: BankArrays, request: Array, now: Array, before: Array) -> float:
    """Writes requests for the stretch of a hybrid that is shown and for the one before; returns the share of `now`."""
    clips, locomotion, played, looped = bank.clips, int(request["locomotion"]), float(request["time"]), 0
    if request["cycles"] != 0 and clips[locomotion, arrays.LOOP] > 0.0:
        looped = int(request["cycles"])
        strides = looped * frames_in_loop(bank, locomotion) / clips[locomotion, arrays.LOOP]
        played = max(played + strides / clips[locomotion, arrays.RATE], 0.0)
    clip, frame = stretch_at(bank, int(request["action"]), request["start"])
    begun = 0.0
    while True:
        now["action"], rate = clip, clips[clip, arrays.RATE]
        if clips[clip, arrays.STANCE] >= 0.0:
            now["start"] = frame / rate - begun
            ends = begun + (clips[clip, arrays.LEAVES] - frame) / rate
        else:
            phase = unrolled_phase(bank, locomotion, begun)
            first = clips[locomotion, arrays.FIRST_PHASE]
            shift = shift_of(bank, clip, phase_of(bank, clip, frame), phase, begun > 0.0)
            now["start"] = 0.0
            now["cycles"] = shift + looped - np.ceil(clips[clip, arrays.FIRST_PHASE] - first - IN_STEP)
            ends = seconds_at(bank, locomotion, phase_of(bank, clip, clips[clip, arrays.LEAVES]) - shift)
        ends = max(ends, begun + HANDOVER)
        following = int(clips[clip, arrays.NEXT_STRETCH])
        if following < 0 or played < ends:
            return 1.0 if begun == 0.0 else smooth((played - begun) / HANDOVER)
        before["action"], before["start"], before["cycles"] = now["action"], now["start"], now["cycles"]
        now["cycles"] = request["cycles"]
        clip, frame, begun = following, clips[following, arrays.ENTERS], ends


@inlined
def stretch_at(bank: BankArrays, hybrid: int, seconds: float) -> tuple[int, float]:
    """Returns the stretch that is shown so many seconds into a hybrid, and its frame."""
    clip = int(bank.clips[hybrid, arrays.FIRST_STRETCH])
    ahead = seconds * bank.clips[hybrid, arrays.RATE]
    while True:
        lasting, following = (
            bank.clips[clip, arrays.LEAVES] - bank.clips[clip, arrays.ENTERS],
            int(bank.clips[clip, arrays.NEXT_STRETCH]),
        )
        if following < 0 or ahead < lasting:
            return clip, bank.clips[clip, arrays.ENTERS] + ahead
        clip, ahead = following, ahead - lasting


@inlined
def shift_of(bank: BankArrays, clip: int, start: float, phase: float, takes_over: bool) -> float:
    """Returns the whole cycles from a locomotion's phase to that of a stretch that begins at its phase `start`.

    The first stretch begins at `start` or later. One that takes over may begin EARLIER, while it fades in.
    """
    if not takes_over:
        return np.ceil(start - phase - IN_STEP)
    shift = np.ceil(start - phase - EARLIER)
    return shift + 1.0 if phase + shift < bank.clips[clip, arrays.FIRST_PHASE] else shift


@inlined
def unrolled_phase(bank: BankArrays, clip: int, seconds: float) -> float:
    """Returns the phase of a locomotion so many seconds after its start, through all its loops."""
    frame, loop = seconds * bank.clips[clip, arrays.RATE], bank.clips[clip, arrays.LOOP]
    if loop == 0.0:
        return phase_of(bank, clip, min(frame, bank.clips[clip, arrays.FRAME_COUNT] - 1.0))
    last, rounds = bank.clips[clip, arrays.ROW_COUNT] - 1.0, 0.0
    if frame > last:
        lasting = frames_in_loop(bank, clip)
        rounds = np.ceil((frame - last) / lasting)
        frame -= rounds * lasting
    return phase_of(bank, clip, frame) + rounds * loop


@inlined
def seconds_at(bank: BankArrays, clip: int, phase: float) -> float:
    """Returns the time of a locomotion's unrolled phase; infinite if it ends before."""
    rate, loop, rounds = bank.clips[clip, arrays.RATE], bank.clips[clip, arrays.LOOP], 0.0
    last = bank.clips[clip, arrays.LAST_PHASE]
    if phase > last:
        if loop == 0.0:
            return np.inf
        rounds = np.ceil((phase - last) / loop)
    frame = frame_of(bank, clip, phase - rounds * loop)
    return (frame + (rounds * frames_in_loop(bank, clip) if rounds > 0.0 else 0.0)) / rate


@kernel
def blend(rotations: Array, before: Array, rows: Array, shares: Array) -> None:
    """Blends poses [n, 4 J] with those of the stretches before [m, 4 J]; rows [m] are those that are blended."""
    for number in range(len(rows)):
        row = rows[number]
        share = np.float32(shares[row])
        for joint in range(0, rotations.shape[1], 4):
            dot = square = np.float32(0.0)
            for i in range(joint, joint + 4):
                dot += rotations[row, i] * before[number, i]
            other = np.float32(1.0) - share
            if dot < 0.0:
                other = -other
            for i in range(joint, joint + 4):
                rotations[row, i] = share * rotations[row, i] + other * before[number, i]
                square += rotations[row, i] * rotations[row, i]
            scale = np.float32(1.0 / math.sqrt(square))
            for i in range(joint, joint + 4):
                rotations[row, i] *= scale


@kernel
def frames_of_hybrids(handle: Handle, requests: Array, now: Array, frames: Array) -> None:
    """Replaces frames [n] of stretches by those of the hybrids of which they are a part."""
    bank = record_at(handle, SpliceArrays).bank
    for character in range(len(requests)):
        if requests[character]["action"] != now[character]["action"]:
            stretch = now[character]["action"]
            frames[character] += bank.clips[stretch, arrays.BEGINS] - bank.clips[stretch, arrays.ENTERS]
