"""Clips joined to one, such as one that first stands, then walks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import heading
from motionsplice.motion.procedural.path import ease
from motionsplice.motion.quaternion import Floats

OVERLAP = 0.5  # seconds in which a clip goes over to the next


def joined(name: str, clips: Sequence[Clip]) -> Clip:
    """Returns clips of the built-in humanoid one after another, each turned and moved to where the one before ends.

    A clip begins OVERLAP before the end of the one before, and fades in within this time.
    """
    return replace(reduce(_followed, clips), name=name)


def begins(clips: Sequence[Clip]) -> list[float]:
    """Returns the seconds into the joined clip at which each clip begins."""
    return [0.0, *np.cumsum([clip.duration - OVERLAP for clip in clips[:-1]]).tolist()]


def _followed(first: Clip, then: Clip) -> Clip:
    frames = round(OVERLAP * first.rate) + 1
    before, count = first.frame_count - frames, first.frame_count + then.frame_count - frames
    turn = quaternion.about([0.0, 1.0, 0.0], _facing(first)[before] - _facing(then)[0])
    steps = quaternion.rotate(turn, np.diff(then.root_positions, axis=0))
    rotations = then.rotations.copy()
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    share = np.ones(count)
    share[:before] = 0.0
    share[before : before + frames] = ease(np.arange(frames) / (frames - 1.0))
    held = np.minimum(np.arange(count), first.frame_count - 1)
    own = np.maximum(np.arange(count) - before, 0)
    step = np.zeros((count, 3))
    step[1 : first.frame_count] = (1.0 - share[1 : first.frame_count, None]) * np.diff(first.root_positions, axis=0)
    step[before + 1 :] += share[before + 1 :, None] * steps
    positions = first.root_positions[0] + np.cumsum(step, axis=0)
    positions[:, 1] = (1.0 - share) * first.root_positions[held, 1] + share * then.root_positions[own, 1]
    mixed = quaternion.slerp(first.rotations[held], rotations[own], share[:, None])
    return replace(first, root_positions=positions, rotations=mixed)


def _facing(clip: Clip) -> Floats:
    """Returns the heading [F] of the hips, radians about Y."""
    world = clip.rotations[:, 0]
    return np.asarray(heading(quaternion.rotate(world, np.array([1.0, 0.0, 0.0]))))
