"""Variants of rigs for tests: extra bones, and another bind pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton


def with_bones_above(clip: Clip, above: Mapping[str, str]) -> Clip:
    """Returns the same motion with an extra bone, which never turns, half-way to the parent of each named joint.

    above: by joint, the name of its extra bone.
    """
    skeleton = clip.skeleton
    names, parents, offsets, places = list[str](), list[int](), list[Floats](), list[int]()
    for joint, name in enumerate(skeleton.names):
        parent, offset = (places[skeleton.parents[joint]] if joint else -1), skeleton.offsets[joint]
        if name in above:
            offset = 0.5 * offset
            names.append(above[name])
            parents.append(parent)
            offsets.append(offset)
            parent = len(names) - 1
        places.append(len(names))
        names.append(name)
        parents.append(parent)
        offsets.append(offset)
    ends = np.array(places)[skeleton.end_parents]
    rig = Skeleton(tuple(names), np.array(parents), np.array(offsets), ends, skeleton.end_offsets)
    rotations = np.tile(quaternion.IDENTITY, (clip.frame_count, len(names), 1))
    rotations[:, places] = clip.rotations
    return replace(clip, skeleton=rig, rotations=rotations)


def with_arms_turned(skeleton: Skeleton, radians: float) -> Skeleton:
    """Returns the built-in rig with its arms lowered by `radians` in the bind pose: an A-pose."""
    offsets, ends = skeleton.offsets.copy(), skeleton.end_offsets.copy()
    for side, down in (("Left", -radians), ("Right", radians)):
        arm = skeleton.subtree(skeleton.index(f"{side}Arm"))
        turn = quaternion.about([0.0, 0.0, 1.0], down)
        offsets[arm[1:]] = quaternion.rotate(turn, offsets[arm[1:]])
        tips = np.isin(skeleton.end_parents, arm)
        ends[tips] = quaternion.rotate(turn, ends[tips])
    return replace(skeleton, offsets=offsets, end_offsets=ends)
