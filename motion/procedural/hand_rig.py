"""The built-in humanoid with fingers of three joints each, and poses of its hands.

Palms face down in the T-pose. The hand's length is about 0.108 of stature (Winter, figure 4.1); the proportions of the
fingers' segments follow Buryanov and Kotiuk 2010, Proportions of hand segments.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.body import LEFT, RIGHT, SKELETON, side_name
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

FINGERS = ("Thumb", "Index", "Middle", "Ring", "Pinky")
# for a left hand: offset of the first joint from the wrist, direction of the finger, lengths of its three bones; metres
_SHAPES: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]] = {
    "Thumb": ((0.022, -0.012, 0.026), (0.62, -0.22, 0.75), (0.046, 0.033, 0.027)),
    "Index": ((0.091, 0.0, 0.026), (1.0, 0.0, 0.04), (0.043, 0.025, 0.021)),
    "Middle": ((0.092, 0.002, 0.005), (1.0, 0.0, 0.0), (0.047, 0.029, 0.022)),
    "Ring": ((0.086, 0.0, -0.015), (1.0, 0.0, -0.04), (0.043, 0.027, 0.022)),
    "Pinky": ((0.079, -0.004, -0.033), (1.0, 0.0, -0.09), (0.033, 0.020, 0.019)),
}
# A pose [7]: the curl of each finger from 0 (straight) to 1 (fist), the spread of the fingers, the thumb's opposition.
SPREAD, OPPOSED, POSE = 5, 6, 7
RELAXED = np.array([0.15, 0.22, 0.28, 0.33, 0.38, 0.1, 0.25])
FIST = np.array([0.75, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0])
OPEN = np.array([0.0, 0.02, 0.0, 0.0, 0.02, 1.0, 0.0])
POINT = np.array([0.75, 0.02, 1.0, 1.0, 1.0, 0.0, 1.0])
THUMBS_UP = np.array([-0.2, 1.0, 1.0, 1.0, 1.0, 0.0, -0.15])
COUNTED: Mapping[int, Floats] = MappingProxyType(
    {
        1: POINT,
        2: np.array([0.75, 0.0, 0.0, 1.0, 1.0, 0.6, 1.0]),
        3: np.array([0.8, 0.0, 0.0, 0.0, 1.0, 0.6, 1.0]),
        4: np.array([0.8, 0.0, 0.0, 0.0, 0.02, 0.7, 1.0]),
        5: OPEN,
    }
)
_CURLS = np.radians([82.0, 100.0, 62.0])  # of the knuckle and the two joints after it, in a fist
_THUMB_CURLS = np.radians([18.0, 48.0, 62.0])
_SPREADS = np.radians([0.0, 11.0, 1.0, -8.0, -17.0])
_OPPOSED = np.radians(52.0)


def _fingered() -> Skeleton:
    names, parents, offsets = list(SKELETON.names), SKELETON.parents.tolist(), SKELETON.offsets.tolist()
    ends = dict(zip(SKELETON.end_parents.tolist(), SKELETON.end_offsets.tolist(), strict=True))
    tips = {SKELETON.names[joint]: offset for joint, offset in ends.items() if "Hand" not in SKELETON.names[joint]}
    named = {
        name: (names[parent] if parent >= 0 else "", offset)
        for name, parent, offset in zip(names, parents, offsets, strict=True)
    }
    joints: list[tuple[str, str, Floats]] = []
    for name, (parent, offset) in named.items():
        joints.append((name, parent, np.array(offset)))
        if name.endswith("Hand"):
            mirror = np.array([LEFT if name.startswith("Left") else RIGHT, 1.0, 1.0])
            for finger in FINGERS:
                base, direction, lengths = _SHAPES[finger]
                along = mirror * direction / np.linalg.norm(direction)
                above, at = name, mirror * base
                for number, length in enumerate(lengths, 1):
                    joints.append((f"{name}{finger}{number}", above, at))
                    above, at = f"{name}{finger}{number}", along * length
                tips[above] = at.tolist()
    order = [name for name, _, _ in joints]
    return Skeleton(
        names=tuple(order),
        parents=np.array([order.index(parent) if parent else -1 for _, parent, _ in joints]),
        offsets=np.array([offset for _, _, offset in joints]),
        end_parents=np.array([order.index(name) for name in tips]),
        end_offsets=np.array(list(tips.values())),
    )


FINGERED = _fingered()
_PLACES = [FINGERED.index(name) for name in SKELETON.names]


def finger_joints(side: float) -> list[int]:
    """Returns the 15 joints of a hand, finger by finger, each from the palm outwards."""
    return [FINGERED.index(f"{side_name(side)}Hand{finger}{number}") for finger in FINGERS for number in (1, 2, 3)]


def finger_rotations(pose: Floats, side: float) -> Floats:
    """Returns the local rotations [F, 15, 4] of a hand's joints in poses [F, POSE]."""
    turns = np.empty((len(pose), len(FINGERS), 3, 4))
    opposed, spread = pose[:, OPPOSED], pose[:, SPREAD]
    across = quaternion.about([1.0, 0.0, 0.0], _OPPOSED * opposed)
    for finger in range(len(FINGERS)):
        for joint in range(3):
            if finger == 0:  # bends in the plane of the palm, after its first joint has turned it across
                turn = quaternion.about([0.0, 1.0, 0.0], _THUMB_CURLS[joint] * pose[:, finger])
                turns[:, finger, joint] = quaternion.multiply(across, turn) if joint == 0 else turn
            else:
                turn = quaternion.about([0.0, 0.0, 1.0], -_CURLS[joint] * pose[:, finger])
                aside = quaternion.about([0.0, 1.0, 0.0], -_SPREADS[finger] * spread)
                turns[:, finger, joint] = quaternion.multiply(aside, turn) if joint == 0 else turn
    mirrored = turns if side == LEFT else turns * np.array([1.0, -1.0, -1.0, 1.0])
    return np.asarray(mirrored.reshape(len(pose), 15, 4))


def with_fingers(clip: Clip, poses: Mapping[float, Floats] = MappingProxyType({})) -> Clip:
    """Adds fingers to a clip of the built-in humanoid, in the poses [F, POSE] by side, relaxed by default."""
    rotations = np.empty((clip.frame_count, FINGERED.joint_count, 4))
    rotations[:, _PLACES] = clip.rotations
    for side in (LEFT, RIGHT):
        pose = poses.get(side, np.tile(RELAXED, (clip.frame_count, 1)))
        rotations[:, finger_joints(side)] = finger_rotations(pose, side)
    return replace(clip, skeleton=FINGERED, rotations=rotations)
