"""Truths of other takes and gaits: a clip of the same action, aligned to a locomotion by its legs.

The alignment is the papers' own whole-clip one, which no splice of the bank uses, so it favours none of its timings.
"""

from __future__ import annotations

from dataclasses import replace

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import hips_heading, joint_positions
from motionsplice.motion.roles import Roles
from motionsplice.precompute.splice import align_in_time


def aligned_truth(locomotion: Clip, other: Clip, roles: Roles) -> Clip:
    """Returns `other` as it would show the upper body of the locomotion: at its pace, with hips that face its way.

    It ends where the alignment ends. Raises SkeletonError or ClipError as `align_in_time` does.
    """
    frames = align_in_time(locomotion, other, roles)[1]
    positions, rotations = other.sampled(frames)
    played = Clip(f"{other.name}, aligned", other.skeleton, locomotion.rate, positions, rotations)
    own, theirs = (hips_heading(joint_positions(clip), roles) for clip in (locomotion, played))
    turn = quaternion.about([0.0, 1.0, 0.0], own[: len(frames)] - theirs)
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    return replace(played, rotations=rotations)
