"""Variants of clips and rigs that must not change a splice: local axes, extra bones, bind poses, timing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton


def local_axes(joints: int, seed: int) -> Floats:
    """Returns a random constant rotation for each joint's local frame [joints, 4]."""
    return np.asarray(Rotation.random(joints, random_state=seed).as_quat())


def with_local_axes(clip: Clip, axes: Floats) -> Clip:
    """Returns the same motion on a rig with local frames rotated by `axes` [J, 4]; world positions do not change."""
    skeleton = clip.skeleton
    above = np.concatenate([quaternion.IDENTITY[None], axes[skeleton.parents[1:]]])
    turned = replace(
        skeleton,
        offsets=quaternion.rotate(quaternion.conjugate(above), skeleton.offsets),
        end_offsets=quaternion.rotate(quaternion.conjugate(axes[skeleton.end_parents]), skeleton.end_offsets),
    )
    rotations = quaternion.multiply(quaternion.multiply(quaternion.conjugate(above), clip.rotations), axes)
    return replace(clip, skeleton=turned, rotations=rotations)


def warped(clip: Clip, frames: Floats, name: str) -> Clip:
    """Returns the clip resampled at its real-valued `frames` [n], at the same rate."""
    positions, rotations = clip.sampled(frames)
    return Clip(name, clip.skeleton, clip.rate, positions, rotations)


def uneven_time(frame_count: int) -> Floats:
    """Returns real-valued frames [frame_count] that play a clip unevenly, at 0.5 to 1.5 times its speed."""
    seconds = np.linspace(0.0, 1.0, frame_count)
    curve = seconds + 0.05 * np.sin(2.0 * np.pi * seconds) + 0.009 * np.sin(6.0 * np.pi * seconds)
    return (curve - curve[0]) / (curve[-1] - curve[0]) * (frame_count - 1)


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
