"""The numbers by which a splice is judged."""

from __future__ import annotations

import numpy as np

from motion.clip import Clip
from motion.kinematics import joint_positions
from motion.quaternion import Floats
from motion.roles import Roles
from precompute.posture import measure_torso, posture_angle

LEAST_SWING = 0.03  # metres of amplitude: an arm that swings less, as under a box, has no phase to speak of


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


def arm_lag(clip: Clip, phase: Floats, roles: Roles) -> float:
    """How far the arms' swing is behind the opposite legs', as a part of a stride in (-0.5, 0.5], mean of both sides.

    phase [F] is the clip's, in cycles. Swing is the wrist's (knee's) way forward of the shoulder (root), at the
    stride's own period. NaN if neither arm swings.
    """
    positions = joint_positions(clip)
    across = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    forward = np.cross(across, [0.0, 1.0, 0.0])
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    weights = np.gradient(phase)  # so that every part of the stride counts alike, however fast it passes

    def swing(joint: int, about: int) -> complex:
        way = np.sum((positions[:, joint] - positions[:, about]) * forward, axis=1)
        way = way - np.average(way, weights=weights)
        return complex(2.0 * np.average(way * np.exp(-2j * np.pi * phase), weights=weights))

    behind = 0j
    for arm, leg in (("left", "right"), ("right", "left")):
        hand = swing(getattr(roles, f"{arm}_wrist"), getattr(roles, f"{arm}_shoulder"))
        knee = swing(getattr(roles, f"{leg}_knee"), roles.root)
        if abs(hand) > LEAST_SWING:
            behind += hand * np.conj(knee)
    return float(-np.angle(behind) / (2.0 * np.pi)) if behind else float("nan")


def lag_error(result: Clip, truth: Clip, phase: Floats, roles: Roles) -> float:
    """Radians of a stride by which the arms are out of step, against the truth; NaN where they do not swing."""
    frames = min(result.frame_count, truth.frame_count)
    lags = [arm_lag(clip.frames(0, frames), phase[:frames], roles) for clip in (result, truth)]
    apart = lags[0] - lags[1]
    return float(2.0 * np.pi * abs(apart - np.round(apart)))


def neck_jitter(clip: Clip, roles: Roles) -> float:
    """Root-mean-square third derivative of the joint where the arms part over the root, m/s^3 (thesis, Figure 4.5)."""
    top = roles.spine[-1] if roles.spine else roles.pelvis
    positions = joint_positions(clip.resampled(30.0) if clip.rate > 30.0 else clip)
    jerk = np.diff(positions[:, top] - positions[:, 0], n=3, axis=0) * min(clip.rate, 30.0) ** 3
    return float(np.sqrt(np.mean(np.sum(jerk**2, axis=1))))


def accelerations(clip: Clip) -> Floats:
    """Accelerations of the joints over the root, each frame's largest [frames - 2], m/s^2, seen at 30 Hz at most."""
    seen = clip.resampled(30.0) if clip.rate > 30.0 else clip
    positions = joint_positions(seen)
    bent = np.diff(positions - positions[:, :1], n=2, axis=0)
    return np.asarray(np.linalg.norm(bent, axis=-1).max(axis=1) * seen.rate**2)
