"""How the upper body sits on the root: upper clouds, posture frames and posture (Heck et al. 2006, 3.2 and 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_transforms
from motionsplice.precompute.body.turned_points import turned_points

UP, FORWARD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
HIPS_APART = 1e-6  # metres, measured over the floor: closer hips show no facing direction


@dataclass(frozen=True, eq=False)
class Torso:
    """What spatial alignment and posture transfer use of a clip.

    clouds:  [F, P, 3] spine joints, then left and right shoulder, in the pelvis's own frame, metres.
    frames:  [F, 4] the posture frame H relative to the pelvis's parent: R^-1 H, in one hemisphere.
    upright: [F, P, 3] the clouds in the posture frame, metres.
    """

    clouds: Floats
    frames: Floats
    upright: Floats

    @property
    def posture(self) -> Floats:
        """The posture [2, 3]: the mean over the frames of left and right shoulder in the posture frame, metres."""
        return np.asarray(self.upright[:, -2:].mean(axis=0))


def measure_torso(clip: Clip, roles: Roles) -> Torso:
    """Measures the torso at every frame of a clip.

    Raises ClipError with the frame number if the hips of a frame show no facing direction.
    """
    pelvis_parent = int(clip.skeleton.parents[roles.pelvis])
    positions, world = joint_transforms(
        clip, (roles.pelvis, pelvis_parent, roles.left_hip, roles.right_hip, *roles.upper_cloud), turning=2
    )
    hip_line = positions[:, 2] - positions[:, 3]
    if len(steep := np.flatnonzero(np.hypot(hip_line[:, 0], hip_line[:, 2]) < HIPS_APART)):
        raise ClipError(
            "one hip is straight above the other or in the same place, so the facing direction is unknown",
            place=f"clip {clip.name!r}, frame {steep[0]}",
            mend="Remove the frame, or name other hip joints in a roles file and pass it as --roles",
        )
    frame = posture_frame(hip_line)
    cloud = positions[:, 4:] - positions[:, :1]
    return Torso(
        clouds=turned_points(quaternion.conjugate(world[:, 0]), cloud),
        frames=quaternion.one_hemisphere(quaternion.multiply(quaternion.conjugate(world[:, 1]), frame)),
        upright=turned_points(quaternion.conjugate(frame), cloud),
    )


def posture_frame(hip_line: Floats) -> Floats:
    """Returns the world rotations H [F, 4] of the posture frame, from the vectors [F, 3] from right to left hip.

    x lies along the hips, z = x cross up, y = z cross x. In this frame a torso is free of the hips' yaw and roll, but
    keeps its lean against gravity (docs/method.md). The hips must be at least HIPS_APART apart over the floor.
    """
    x, y, z = hip_line[:, 0], hip_line[:, 1], hip_line[:, 2]
    yaw = quaternion.about(UP, np.arctan2(-z, x))
    return quaternion.multiply(yaw, quaternion.about(FORWARD, np.arctan2(y, np.hypot(x, z))))


def posture_angle(a: Floats, b: Floats) -> float:
    """Returns the angle in radians of the rotation that best lays one posture [2, 3] on another."""
    return float(quaternion.angle(horn_rotation(a, b), quaternion.IDENTITY))
