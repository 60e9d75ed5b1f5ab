"""Truths of other takes and gaits: a clip of the same action, aligned to a locomotion by its legs.

The alignment is the papers' own whole-clip one, which no splice of the bank uses, so it favours none of its timings.
"""

from __future__ import annotations

from dataclasses import replace

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import heading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_paths
from motionsplice.precompute.splice import align_in_time


def aligned_truth(locomotion: Clip, other: Clip, roles: Roles) -> Clip:
    """Returns `other` as it would show the upper body of the locomotion: at its pace, with hips that face its way.

    It ends where the alignment ends. Raises SkeletonError or ClipError as `align_in_time` does.
    """
    frames = align_in_time(locomotion, other, roles)[1]
    positions, rotations = other.sampled(frames)
    played = Clip(f"{other.name}, aligned", other.skeleton, locomotion.rate, positions, rotations)
    turn = quaternion.about([0.0, 1.0, 0.0], _facing(locomotion, roles)[: len(frames)] - _facing(played, roles))
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    return replace(played, rotations=rotations)


def _facing(clip: Clip, roles: Roles) -> Floats:
    """Returns the heading [F] of the hips, radians about Y."""
    left, right = joint_paths(clip, (roles.left_hip, roles.right_hip)).swapaxes(0, 1)
    return heading(left - right)
