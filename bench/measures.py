"""The numbers by which a splice is judged."""

from __future__ import annotations

import numpy as np

from motion.clip import Clip
from motion.kinematics import joint_positions
from motion.quaternion import Floats
from motion.roles import Roles
from precompute.posture import measure_torso, posture_angle


def upper_body_errors(result: Clip, truth: Clip, roles: Roles) -> Floats:
    """Distances [frames, joints], metres, of the upper body's joints with the hips at the origin.

    Over the frames that both clips have; the pelvis, which both have in one place, is left out.
    """
    frames = min(result.frame_count, truth.frame_count)
    upper = [joint for joint in result.skeleton.subtree(roles.pelvis) if joint != roles.pelvis]
    over_root = []
    for clip in (result, truth):
        positions = joint_positions(clip.frames(0, frames))
        over_root.append(positions[:, upper] - positions[:, :1])
    return np.asarray(np.linalg.norm(over_root[0] - over_root[1], axis=-1))


def posture_error(result: Clip, wanted: Clip, roles: Roles) -> float:
    """Radians between the postures of two clips."""
    return posture_angle(measure_torso(result, roles).posture, measure_torso(wanted, roles).posture)
