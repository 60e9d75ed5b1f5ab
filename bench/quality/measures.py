"""Measures of a splice's shape: error, posture, jitter, excursion, and changes within its halves."""

from __future__ import annotations

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.comparison import at_frames, legs_apart
from motionsplice.motion.kinematics import joint_positions, world_transforms
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, common_ancestor
from motionsplice.precompute.body.posture import measure_torso

DERIVATIVE_RATE = 30.0  # Hz at most for derivatives: at higher rates they measure the noise of the capture
STILL = 0.05  # m/s of hands that do not move


def over_root(clip: Clip, roles: Roles) -> Floats:
    """Returns the joints above the pelvis relative to the root [F, n, 3], in metres."""
    positions = joint_positions(clip)
    return np.asarray(positions[:, clip.skeleton.subtree(roles.pelvis)[1:]] - positions[:, :1])


def upper_body_errors(result: Clip, truth: Clip, roles: Roles) -> Floats:
    """Returns the distances [frames, joints] between the upper bodies' joints, in metres, with the hips at the origin.

    Compares the frames that both clips have. The pelvis is left out, as it is in the same place in both.
    """
    frames = min(result.frame_count, truth.frame_count)
    ours, theirs = (over_root(clip.frames(0, frames), roles) for clip in (result, truth))
    return np.asarray(np.linalg.norm(ours - theirs, axis=-1))


def posture_error(result: Clip, wanted: Clip, roles: Roles) -> float:
    """Returns the angle between the postures of two clips, in radians."""
    return posture_angle(measure_torso(result, roles).posture, measure_torso(wanted, roles).posture)


def posture_angle(a: Floats, b: Floats) -> float:
    """Returns the angle in radians of the rotation that best lays one posture [2, 3] on another."""
    return float(quaternion.angle(horn_rotation(a, b), quaternion.IDENTITY))


def promised_posture(locomotion: Clip, action: Clip, turns: Floats, posture: str, roles: Roles) -> Floats:
    """Returns the mean posture [2, 3] that a splice should have with the posture form `posture`.

    For `relative` it is the locomotion's posture, turned at each frame by `turns` [F, 4]: the rotation that the action
    adds to its own gait.
    """
    if posture in ("absolute", "running"):
        return measure_torso(action, roles).posture
    own = measure_torso(locomotion, roles)
    if posture == "relative":
        return np.asarray(quaternion.rotate(turns[:, None], own.upright[:, -2:]).mean(axis=0))
    return own.posture


def neck_over_root(clip: Clip, roles: Roles) -> Floats:
    """Returns the spine's last joint relative to the root [F, 3], in metres (thesis, Figure 4.5)."""
    top = roles.spine[-1] if roles.spine else roles.pelvis
    positions = joint_positions(clip)
    return np.asarray(positions[:, top] - positions[:, 0])


def neck_jitter(clip: Clip, roles: Roles) -> float:
    """Returns the root-mean-square third derivative of the neck relative to the root, in m/s^3."""
    resampled = _for_derivatives(clip)
    jerk = np.diff(neck_over_root(resampled, roles), n=3, axis=0) * resampled.rate**3
    return float(np.sqrt(np.mean(np.sum(jerk**2, axis=1))))


def neck_excursion(clip: Clip, roles: Roles) -> float:
    """Returns the largest deviation of the neck from its mean height and horizontal distance over the root, in metres.

    Motion about the vertical does not count, because a turn of the person would add to it.
    """
    neck = neck_over_root(clip, roles)
    profile = np.stack([neck[:, 1], np.hypot(neck[:, 0], neck[:, 2])], axis=1)
    return float(np.linalg.norm(profile - profile.mean(axis=0), axis=1).max())


def hand_speeds(clip: Clip, roles: Roles) -> Floats:
    """Returns how fast both wrists move, seen from the chest [frames - 1, 2], in m/s. Clips are resampled to 30 Hz.

    Seen from the hips, a hand that is still on the chest moves as the locomotion turns the trunk: a push on a run at
    3.8 times its own speed. What the chest does not see is no hurry, since a splice keeps what hangs on the chest.
    """
    resampled = _for_derivatives(clip)
    skeleton = resampled.skeleton
    places, turns = world_transforms(skeleton, resampled.root_positions, resampled.rotations)
    chest = common_ancestor(skeleton.parents, [roles.left_shoulder, roles.right_shoulder])
    over = places[:, [roles.left_wrist, roles.right_wrist]] - places[:, [chest]]
    seen = quaternion.rotate(quaternion.conjugate(turns[:, [chest]]), over)
    return np.asarray(np.linalg.norm(np.diff(seen, axis=0), axis=-1) * resampled.rate)


def hurry(clip: Clip, captured: Clip, roles: Roles) -> float | None:
    """Returns how much faster hands move than in the action's capture, None if they hardly move there.

    It is the ratio of the 99th percentiles. A maximum would be that of one frame: a captured walk's own is 1.6 times
    its 99th percentile.
    """
    ours, theirs = (float(np.percentile(hand_speeds(one, roles), 99.0)) for one in (clip, captured))
    return ours / theirs if theirs > STILL else None


def accelerations(clip: Clip) -> Floats:
    """Returns each frame's largest acceleration of a joint relative to the root [frames - 2], in m/s^2.

    Clips above 30 Hz are resampled to 30 Hz first.
    """
    resampled = _for_derivatives(clip)
    positions = joint_positions(resampled)
    bent = np.diff(positions - positions[:, :1], n=2, axis=0)
    return np.asarray(np.linalg.norm(bent, axis=-1).max(axis=1) * resampled.rate**2)


def change_within_halves(result: Clip, locomotion: Clip, upper_rotations: Floats, roles: Roles) -> float:
    """Returns the largest angle between a joint's rotation in the result and in its source, in radians.

    upper_rotations [F, J, 4]: the action's rotations at the frames used in the result. The pelvis is excluded, as it
    belongs to neither half.
    """
    count = result.frame_count
    upper = result.skeleton.subtree(roles.pelvis)[1:]
    lower = [joint for joint in range(result.skeleton.joint_count) if joint not in {*upper, roles.pelvis}]
    return max(
        float(quaternion.angle(result.rotations[:, joints], source[:count, joints]).max())
        for joints, source in ((upper, upper_rotations), (lower, locomotion.rotations))
    )


def mismatch(locomotion: Clip, action: Clip, action_frames: Floats, roles: Roles) -> Floats:
    """Returns the distance of root and knees between the clips at aligned frames [F], root mean square, in metres."""
    shown = joint_positions(locomotion.frames(0, len(action_frames)))
    return legs_apart(shown, joint_positions(at_frames(action, action_frames)), roles)


def _for_derivatives(clip: Clip) -> Clip:
    return clip.resampled(DERIVATIVE_RATE) if clip.rate > DERIVATIVE_RATE else clip
