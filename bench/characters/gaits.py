"""Whether gaits keep together while they are mixed: in phase, and with feet on the ground."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from bench.characters.joint_speeds import RATE, shown
from bench.characters.steady import LEGS
from bench.findings import Findings
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.format.contacts import FEET
from motionsplice.runtime.stage import Stage

FADE = 0.5  # seconds
MOMENTS = (0.1, 0.5, 0.9)  # of a clip, at which another follows


def phases(stage: Stage) -> Findings:
    """How far apart the phases of two gaits are, by the frames that are shown, while one fades into the other."""
    bank, characters = stage.bank, Characters(stage, RATE)
    for first, second in permutations((clip for clip in bank.clips if clip.gait), 2):
        for moment in MOMENTS:
            [row] = characters.add(1, first.name, time=moment * first.duration)
            characters.play([row], second.name, blend=FADE)
    found = []
    for _ in range(round(FADE * RATE)):
        mixed = characters.state[characters.state[:, col.LOCOMOTIONS] == 2.0]
        apart = np.subtract(*(phases_shown(stage, mixed[:, LEGS[number] : LEGS[number + 1]]) for number in (0, 1)))
        found.append(np.abs(apart - np.round(apart)))
        characters.advance()
    told = Findings(f"{len(characters)} times one gait into another: cycles out of step")
    told.add("median", float(np.median(np.concatenate(found))), "{:.6f}")
    told.add("largest", float(np.concatenate(found).max()), "{:.6f}", most=0.02)
    return told


def phases_shown(stage: Stage, slots: Floats) -> Floats:
    """The phase [n] of the frame of each slot."""
    phase = stage.bank.tables["phase_of_frame"]
    return np.array(
        [
            np.interp(frame, np.arange(entry.row_count), phase[entry.first_row : entry.first_row + entry.row_count])
            for entry, frame in ((stage.bank.clips[int(slot[col.CLIP])], slot[col.FRAME]) for slot in slots)
        ]
    )


def slides(stage: Stage) -> Findings:
    """Feet in mixes of two locomotions, against each of them alone."""
    told = Findings("A foot slides while it stands, metres (median over stances)")
    for first, second in (("walk", "run"), ("walk", "slow_walk"), ("walk", "curve"), ("slow_walk", "run")):
        found = [slide(stage, {first: 1.0 - weight, second: weight}) for weight in (0.0, 0.25, 0.5, 0.75, 1.0)]
        told.add(f"{first}, alone", found[0], "{:.3f}")
        told.add(f"{second}, alone", found[-1], "{:.3f}")
        most = max(found[0], found[-1]) + 0.01
        told.add(f"{first} and {second}, worst of three mixes", max(found[1:-1]), "{:.3f}", most=most)
    return told


def slide(stage: Stage, weights: Mapping[str, float]) -> float:
    """How far the lower joint of a foot goes over the floor in a stance."""
    characters = Characters(stage, RATE)
    characters.add(1, {name: weight for name, weight in weights.items() if weight})
    roles, ways = stage.bank.roles, []
    going: dict[str, list[Floats]] = {name: [] for name in FEET}
    for _ in range(600):
        positions, standing = shown(characters)[0], stands(stage, characters.state[0])
        for (name, bit), joints in zip(FEET.items(), roles.feet, strict=True):
            if standing & bit:
                going[name].append(positions[joints[-1], [0, 2]])
            elif going[name]:
                ways.append(float(np.linalg.norm(np.ptp(going[name], axis=0))) if len(going[name]) > 6 else np.nan)
                going[name] = []
        characters.advance()
    return float(np.nanmedian(ways))


def stands(stage: Stage, s: Floats) -> int:
    """The feet that all locomotions of a character have stand."""
    standing = 3
    for number in range(int(s[col.LOCOMOTIONS])):
        slot = s[col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS :]
        entry = stage.bank.clips[int(slot[col.CLIP])]
        standing &= int(stage.bank.tables["contacts"][entry.first_row + int(slot[col.FRAME])])
    return standing
