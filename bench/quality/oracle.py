"""Practical lower bounds for the error of a splice: an oracle that knows the truth, and the spread of strides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.quality.measures import upper_body_errors
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions, world_transforms
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.splice import attach

ORACLE_RATE = 30.0  # frames per second at which the oracle picks frames


def oracle_error(locomotion: Clip, action: Clip, truth: Clip, offsets: tuple[Floats, Floats], roles: Roles) -> float:
    """Returns the oracle's mean error in metres: for each frame, it picks the action's frame closest to the truth.

    Each frame of the action is first aligned in space like a splice. `offsets` are the torso offsets [F, 4] of
    locomotion and action at their own frames. Each frame is picked independently, without regard to time, which no real
    motion could do.
    """
    upper = locomotion.skeleton.subtree(roles.pelvis)[1:]
    torso_l, torso_u = measure_torso(locomotion, roles), measure_torso(action, roles)
    local = _in_pelvis_frame(action, upper, roles)
    world = world_transforms(locomotion.skeleton, locomotion.root_positions, locomotion.rotations)[1]
    goals = joint_positions(truth)
    parent = int(locomotion.skeleton.parents[roles.pelvis])
    candidates = _sampled_frames(action)
    nearest = []
    for frame in _sampled_frames(locomotion.frames(0, min(locomotion.frame_count, truth.frame_count))):
        turn = quaternion.multiply(offsets[1][candidates], quaternion.conjugate(offsets[0][frame]))
        lean = quaternion.multiply(torso_l.frames[frame], turn)
        lean = quaternion.multiply(lean, quaternion.conjugate(torso_l.frames[frame]))
        aligned = horn_rotation(torso_l.clouds[frame], torso_u.clouds[candidates])
        pelvis = quaternion.multiply(lean, quaternion.multiply(locomotion.rotations[frame, roles.pelvis], aligned))
        turned = quaternion.rotate(quaternion.multiply(world[frame, parent], pelvis)[:, None], local[candidates])
        goal = goals[frame, upper] - goals[frame, roles.pelvis]
        nearest.append(np.linalg.norm(turned - goal, axis=-1).mean(axis=1).min())
    return float(np.mean(nearest))


def stride_to_stride(truth: Clip, phase: Floats, roles: Roles) -> float:
    """Returns how much a person's upper body differs from one stride to the next, in metres.

    The strides are aligned in space like a splice. phase [F]: the phase of the truth's legs in cycles. NaN for a clip
    shorter than a stride and a half.
    """
    if phase[-1] - phase[0] < 1.5:
        return float("nan")
    errors = []
    for shift in (1.0, -1.0):
        inside = np.flatnonzero((phase + shift >= phase[0]) & (phase + shift <= phase[-1]))
        used = truth.frames(int(inside[0]), int(inside[-1]) + 1)
        shifted = np.interp(phase[inside] + shift, phase, np.arange(len(phase)))
        other = Clip(truth.name, truth.skeleton, truth.rate, *truth.sampled(shifted))
        aligned = horn_rotation(measure_torso(used, roles).clouds, measure_torso(other, roles).clouds)
        errors.append(upper_body_errors(attach(used, other.rotations, aligned, roles), used, roles).mean())
    return float(np.mean(errors))


def _sampled_frames(clip: Clip) -> NDArray[np.int64]:
    """Returns the frame numbers of a clip at about ORACLE_RATE."""
    return np.arange(0, clip.frame_count, max(1, round(clip.rate / ORACLE_RATE)))


def _in_pelvis_frame(clip: Clip, joints: list[int], roles: Roles) -> Floats:
    """Returns the positions [F, n, 3] of joints in the pelvis's frame, in metres."""
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    over = positions[:, joints] - positions[:, roles.pelvis, None]
    return quaternion.rotate(quaternion.conjugate(world[:, roles.pelvis])[:, None], over)
