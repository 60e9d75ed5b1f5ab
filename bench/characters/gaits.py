"""Measures the phases of gaits while they are blended."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from bench.characters.joint_speeds import RATE
from bench.characters.steady import LEGS
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.stage import Stage

FADE = 0.5  # seconds
MOMENTS = (0.1, 0.5, 0.9)  # of a clip's duration, at which the transition starts


def phases(stage: Stage) -> Findings:
    """Measures how far apart the phases of two gaits are, at the frames evaluated, while one fades into the other."""
    bank, characters = stage.bank, Characters(stage, RATE)
    for first, second in permutations((clip for clip in bank.clips if clip.gait), 2):
        for moment in MOMENTS:
            [row] = characters.add(1, first.name, time=moment * first.duration)
            characters.play([row], second.name, blend=FADE)
    differences = []
    for _ in range(round(FADE * RATE)):
        blending = characters.state[characters.state[:, col.LOCOMOTIONS] == 2.0]
        apart = np.subtract(*(frame_phases(stage, blending[:, LEGS[number] : LEGS[number + 1]]) for number in (0, 1)))
        differences.append(np.abs(apart - np.round(apart)))
        characters.advance()
    findings = Findings(f"{len(characters)} gait transitions: phase difference, cycles")
    findings.add("median", float(np.median(np.concatenate(differences))), "{:.6f}")
    findings.add("largest", float(np.concatenate(differences).max()), "{:.6f}", most=0.02)
    return findings


def frame_phases(stage: Stage, slots: Floats) -> Floats:
    """Returns the phase [n], in cycles, at the current frame of each slot [n, columns]."""
    phase = stage.bank.tables["phase_of_frame"]
    return np.array(
        [
            np.interp(frame, np.arange(entry.row_count), phase[entry.first_row : entry.first_row + entry.row_count])
            for entry, frame in ((stage.bank.clips[int(slot[col.CLIP])], slot[col.FRAME]) for slot in slots)
        ]
    )
