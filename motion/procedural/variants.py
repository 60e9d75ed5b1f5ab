"""Variants of clips that must not change a splice: local axes, timing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats


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
