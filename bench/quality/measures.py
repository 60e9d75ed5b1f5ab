"""The numbers by which the shape of a splice is judged."""

from __future__ import annotations

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.pointcloud import planar_distance
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.baseline import level
from motionsplice.precompute.body.posture import measure_torso, posture_angle

SEEN_RATE = 30.0  # frames per second at which jitter is seen: above it, derivatives show the capture's noise


def upper_body_errors(result: Clip, truth: Clip, roles: Roles) -> Floats:
    """Distances [frames, joints], metres, of the upper body's joints with the hips at the origin.

    Over the frames that both clips have; the pelvis, which both have in one place, is left out.
    """
    frames = min(result.frame_count, truth.frame_count)
    upper = result.skeleton.subtree(roles.pelvis)[1:]
    over_root = []
    for clip in (result, truth):
        positions = joint_positions(clip.frames(0, frames))
        over_root.append(positions[:, upper] - positions[:, :1])
    return np.asarray(np.linalg.norm(over_root[0] - over_root[1], axis=-1))


def posture_error(result: Clip, wanted: Clip, roles: Roles) -> float:
    """Radians between the postures of two clips."""
    return posture_angle(measure_torso(result, roles).posture, measure_torso(wanted, roles).posture)


def promised_posture(locomotion: Clip, action: Clip, turns: Floats, posture: str, roles: Roles) -> Floats:
    """The mean posture [2, 3] that a posture form promises of a splice.

    For `relative` it is the locomotion's, turned at each frame by `turns` [F, 4]: what the action does beyond its gait.
    """
    if posture in ("absolute", "running"):
        return measure_torso(action, roles).posture
    own = measure_torso(locomotion, roles)
    if posture == "relative":
        return np.asarray(quaternion.rotate(turns[:, None], own.upright[:, -2:]).mean(axis=0))
    return own.posture


def neck_over_root(clip: Clip, roles: Roles) -> Floats:
    """The joint where the arms part, over the root [F, 3], metres (thesis, Figure 4.5)."""
    top = roles.spine[-1] if roles.spine else roles.pelvis
    positions = joint_positions(clip)
    return np.asarray(positions[:, top] - positions[:, 0])


def neck_jitter(clip: Clip, roles: Roles) -> float:
    """Root-mean-square third derivative of the neck over the root, m/s^3."""
    seen = _seen(clip)
    jerk = np.diff(neck_over_root(seen, roles), n=3, axis=0) * seen.rate**3
    return float(np.sqrt(np.mean(np.sum(jerk**2, axis=1))))


def neck_excursion(clip: Clip, roles: Roles) -> float:
    """The farthest that the neck goes from its mean height and distance over the root, metres.

    Its way about the vertical is left out, for there a turn would count.
    """
    way = neck_over_root(clip, roles)
    seen = np.stack([way[:, 1], np.hypot(way[:, 0], way[:, 2])], axis=1)
    return float(np.linalg.norm(seen - seen.mean(axis=0), axis=1).max())


def accelerations(clip: Clip) -> Floats:
    """Accelerations of the joints over the root, each frame's largest [frames - 2], m/s^2, seen at 30 Hz at most."""
    seen = _seen(clip)
    positions = joint_positions(seen)
    bent = np.diff(positions - positions[:, :1], n=2, axis=0)
    return np.asarray(np.linalg.norm(bent, axis=-1).max(axis=1) * seen.rate**2)


def change_within_halves(result: Clip, locomotion: Clip, upper_rotations: Floats, roles: Roles) -> float:
    """Radians, the largest by which a joint of either half turns otherwise than in its source; the pelvis is neither.

    upper_rotations [F, J, 4] are the action's at the frames that the result shows.
    """
    count = result.frame_count
    upper = result.skeleton.subtree(roles.pelvis)[1:]
    lower = [joint for joint in range(result.skeleton.joint_count) if joint not in {*upper, roles.pelvis}]
    return max(
        float(quaternion.angle(result.rotations[:, joints], source[:count, joints]).max())
        for joints, source in ((upper, upper_rotations), (lower, locomotion.rotations))
    )


def mismatch(locomotion: Clip, action: Clip, action_frames: Floats, roles: Roles) -> Floats:
    """How far root and knees are from each other's at aligned frames [F]: root-mean-square, metres."""
    cloud = list(roles.lower_cloud)
    sampled = Clip(action.name, action.skeleton, locomotion.rate, *action.sampled(action_frames))
    kept = locomotion.frames(0, len(action_frames))
    apart = planar_distance(*(level(joint_positions(clip)[:, cloud]) for clip in (kept, sampled)))
    return np.sqrt(apart / len(cloud))


def _seen(clip: Clip) -> Clip:
    return clip.resampled(SEEN_RATE) if clip.rate > SEEN_RATE else clip
