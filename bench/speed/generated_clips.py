"""Clips of any length for timing: built-in walks at 120 frames per second on a rig of 31 joints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make

RATE = 120.0
FINGERS = tuple(
    f"{side}Hand{name}1"
    for side, names in (("Left", "Thumb Index Middle Ring Pinky"), ("Right", "Thumb Index Middle Ring"))
    for name in names.split()
)
FINGER = np.array([0.0, -0.08, 0.0])  # metres from the hand
GAITS = ("walk", "run", "curve", "side_step")


def generated(gait: str, seconds: float, seed: int) -> Clip:
    """A built-in motion with nine fingers that curl and stretch over time."""
    clip = make(gait, seconds=seconds, rate=RATE, seed=seed)
    rig = clip.skeleton
    hands = [rig.index(finger[: finger.index("Hand") + 4]) for finger in FINGERS]
    skeleton = replace(
        rig,
        names=rig.names + FINGERS,
        parents=np.concatenate([rig.parents, hands]),
        offsets=np.concatenate([rig.offsets, np.tile(FINGER, (len(hands), 1))]),
    )
    time = np.arange(clip.frame_count)[:, None] / RATE + np.arange(len(hands))
    curls = quaternion.about([1.0, 0.0, 0.0], 0.4 + 0.3 * np.sin(time))
    return replace(clip, skeleton=skeleton, rotations=np.concatenate([clip.rotations, curls], axis=1))


def write_generated(folder: Path, count: int, seconds: float) -> None:
    """Writes `count` BVH files. Motions repeat after four files, but no two files are equal, so no cache applies."""
    folder.mkdir(parents=True)
    motions = [dump_bvh(generated(gait, seconds, seed)) for seed, gait in enumerate(GAITS[: min(count, len(GAITS))])]
    for number in range(count):
        file = folder / f"{GAITS[number % len(GAITS)]}_{number:04}.bvh"
        file.write_bytes(motions[number % len(GAITS)] + b" " * number + b"\n")
