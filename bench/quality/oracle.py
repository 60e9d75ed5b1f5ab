"""What no splice can be expected to beat: one that knows the truth, and one stride against the next."""

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

ORACLE_RATE = 30.0  # frames per second at which the oracle looks


def oracle_error(locomotion: Clip, action: Clip, truth: Clip, offsets: tuple[Floats, Floats], roles: Roles) -> float:
    """Metres: the mean error of a splice that picks, for each frame, the action's frame nearest to the truth.

    Each frame of the action is first aligned as a splice is, with `offsets`, the torso offsets [F, 4] of locomotion and
    action at their own frames. Frames are picked one by one, without any regard to time, as no motion could be.
    """
    upper = locomotion.skeleton.subtree(roles.pelvis)[1:]
    torso_l, torso_u = measure_torso(locomotion, roles), measure_torso(action, roles)
    hung = _hung_on_pelvis(action, upper, roles)
    world = world_transforms(locomotion.skeleton, locomotion.root_positions, locomotion.rotations)[1]
    goals = joint_positions(truth)
    parent = int(locomotion.skeleton.parents[roles.pelvis])
    candidates = _every(action)
    nearest = []
    for frame in _every(locomotion.frames(0, min(locomotion.frame_count, truth.frame_count))):
        turn = quaternion.multiply(offsets[1][candidates], quaternion.conjugate(offsets[0][frame]))
        seen = quaternion.multiply(torso_l.frames[frame], turn)
        seen = quaternion.multiply(seen, quaternion.conjugate(torso_l.frames[frame]))
        laid = horn_rotation(torso_l.clouds[frame], torso_u.clouds[candidates])
        pelvis = quaternion.multiply(seen, quaternion.multiply(locomotion.rotations[frame, roles.pelvis], laid))
        turned = quaternion.rotate(quaternion.multiply(world[frame, parent], pelvis)[:, None], hung[candidates])
        wanted = goals[frame, upper] - goals[frame, roles.pelvis]
        nearest.append(np.linalg.norm(turned - wanted, axis=-1).mean(axis=1).min())
    return float(np.mean(nearest))


def stride_to_stride(truth: Clip, phase: Floats, roles: Roles) -> float:
    """Metres by which a person's own upper body differs from one stride to the next, spatially aligned as a splice is.

    phase [F] in cycles is that of the truth's legs. NaN for a clip of less than a stride and a half.
    """
    if phase[-1] - phase[0] < 1.5:
        return float("nan")
    errors = []
    for shift in (1.0, -1.0):
        inside = np.flatnonzero((phase + shift >= phase[0]) & (phase + shift <= phase[-1]))
        kept = truth.frames(int(inside[0]), int(inside[-1]) + 1)
        there = np.interp(phase[inside] + shift, phase, np.arange(len(phase)))
        other = Clip(truth.name, truth.skeleton, truth.rate, *truth.sampled(there))
        laid = horn_rotation(measure_torso(kept, roles).clouds, measure_torso(other, roles).clouds)
        errors.append(upper_body_errors(attach(kept, other.rotations, laid, roles), kept, roles).mean())
    return float(np.mean(errors))


def _every(clip: Clip) -> NDArray[np.int64]:
    """The frames of a clip at about the oracle's rate."""
    return np.arange(0, clip.frame_count, max(1, round(clip.rate / ORACLE_RATE)))


def _hung_on_pelvis(clip: Clip, joints: list[int], roles: Roles) -> Floats:
    """Where joints are in the pelvis's own frame [F, n, 3], metres."""
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    over = positions[:, joints] - positions[:, roles.pelvis, None]
    return quaternion.rotate(quaternion.conjugate(world[:, roles.pelvis])[:, None], over)
