"""The same motion on rigs that differ, for tests that the answer does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from motion import quaternion
from motion.clip import Clip
from motion.quaternion import Floats


def local_axes(joints: int, seed: int) -> Floats:
    """A random constant rotation for each joint's local frame [joints, 4]."""
    return np.asarray(Rotation.random(joints, random_state=seed).as_quat())


def with_local_axes(clip: Clip, axes: Floats) -> Clip:
    """The same motion on a rig whose local frames are turned by `axes`: all world positions stay."""
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
    """The same motion at other times: real-valued frames [n] of the clip."""
    positions, rotations = clip.sampled(frames)
    return Clip(name, clip.skeleton, clip.rate, positions, rotations)


def uneven_time(frame_count: int) -> Floats:
    """Frames of a clip played unevenly: between half and one and a half times as fast."""
    seconds = np.linspace(0.0, 1.0, frame_count)
    curve = seconds + 0.05 * np.sin(2.0 * np.pi * seconds) + 0.009 * np.sin(6.0 * np.pi * seconds)
    return (curve - curve[0]) / (curve[-1] - curve[0]) * (frame_count - 1)
