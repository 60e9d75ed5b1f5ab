"""Measures gaits while they are blended: their phases, and how far feet slide."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from bench.characters.joint_speeds import RATE, character_positions
from bench.characters.steady import LEGS
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.contacts import FEET
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


def slides(stage: Stage) -> Findings:
    """Measures how far feet slide in blends of two locomotions, and in each of them alone."""
    findings = Findings("Sliding of a planted foot, metres (median of stances)")
    for first, second in (("walk", "run"), ("walk", "slow_walk"), ("walk", "curve"), ("slow_walk", "run")):
        distances = [slide(stage, {first: 1.0 - weight, second: weight}) for weight in (0.0, 0.25, 0.5, 0.75, 1.0)]
        findings.add(f"{first}, alone", distances[0], "{:.3f}")
        findings.add(f"{second}, alone", distances[-1], "{:.3f}")
        most = max(distances[0], distances[-1]) + 0.01
        findings.add(f"{first} and {second}, worst of three blends", max(distances[1:-1]), "{:.3f}", most=most)
    return findings


def slide(stage: Stage, weights: Mapping[str, float]) -> float:
    """Returns the metres that the lowest joint of a foot moves over the floor in a stance, the median of stances."""
    characters = Characters(stage, RATE)
    characters.add(1, {name: weight for name, weight in weights.items() if weight})
    roles, distances = stage.bank.roles, []
    stance: dict[str, list[Floats]] = {name: [] for name in FEET}
    for _ in range(600):
        positions, planted = character_positions(characters)[0], planted_feet(stage, characters.state[0])
        for (name, bit), joints in zip(FEET.items(), roles.feet, strict=True):
            if planted & bit:
                stance[name].append(positions[joints[-1], [0, 2]])
            elif stance[name]:
                long_enough = len(stance[name]) > 6
                distances.append(float(np.linalg.norm(np.ptp(stance[name], axis=0))) if long_enough else np.nan)
                stance[name] = []
        characters.advance()
    return float(np.nanmedian(distances))


def planted_feet(stage: Stage, s: Floats) -> int:
    """Returns the bits of the feet that are planted in all locomotions of the character with state row `s`."""
    planted = 3
    for number in range(int(s[col.LOCOMOTIONS])):
        slot = s[col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS :]
        entry = stage.bank.clips[int(slot[col.CLIP])]
        planted &= int(stage.bank.tables["contacts"][entry.first_row + int(slot[col.FRAME])])
    return planted
