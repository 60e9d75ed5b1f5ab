"""How the upper body sits on the root: upper clouds, posture frames and posture (Heck et al. 2006, 3.2, 3.3)."""

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

UP, FORWARD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
HIPS_APART = 1e-6  # metres over the floor: with less they show no direction


@dataclass(frozen=True, eq=False)
class Torso:
    """What spatial alignment and posture transfer need to know of a clip.

    clouds:  [F, P, 3] spine joints and, last, left and right shoulder in the pelvis's own frame, metres.
    frames:  [F, 4] the posture frame H as seen from the pelvis's parent: R^-1 H, one hemisphere.
    upright: [F, P, 3] the clouds in the posture frame, metres.
    """

    clouds: Floats
    frames: Floats
    upright: Floats

    @property
    def posture(self) -> Floats:
        """The posture [2, 3] of these frames: the mean of both shoulders."""
        return np.asarray(self.upright[:, -2:].mean(axis=0))


def measure_torso(clip: Clip, roles: Roles) -> Torso:
    """The torso of every frame of a clip. Raises ClipError, naming the frame, if its hips show no posture frame."""
    pelvis_parent = int(clip.skeleton.parents[roles.pelvis])
    positions, world = joint_transforms(
        clip, (roles.pelvis, pelvis_parent, roles.left_hip, roles.right_hip, *roles.upper_cloud)
    )
    hip_line = positions[:, 2] - positions[:, 3]
    if len(steep := np.flatnonzero(np.hypot(hip_line[:, 0], hip_line[:, 2]) < HIPS_APART)):
        raise ClipError(
            "one hip is straight above the other or in its place, so they do not show which way the body faces",
            place=f"clip {clip.name!r}, frame {steep[0]}",
            mend="Leave the frame out, or name other joints for the hips in a file and pass it as --roles",
        )
    frame = posture_frame(hip_line)
    cloud = positions[:, 4:] - positions[:, :1]
    return Torso(
        clouds=quaternion.rotate(quaternion.conjugate(world[:, :1]), cloud),
        frames=quaternion.one_hemisphere(quaternion.multiply(quaternion.conjugate(world[:, 1]), frame)),
        upright=quaternion.rotate(quaternion.conjugate(frame)[:, None], cloud),
    )


def posture_frame(hip_line: Floats) -> Floats:
    """World rotations H [F, 4] of the posture frame, from the vectors [F, 3] from right to left hip.

    x lies along the hips, z = x cross up, y = z cross x: the hips' yaw and roll are taken out, while the lean
    against gravity stays (docs/method.md). The hips must lie HIPS_APART over the floor.
    """
    x, y, z = hip_line[:, 0], hip_line[:, 1], hip_line[:, 2]
    yaw = quaternion.about(UP, np.arctan2(-z, x))
    return quaternion.multiply(yaw, quaternion.about(FORWARD, np.arctan2(y, np.hypot(x, z))))


def posture_angle(a: Floats, b: Floats) -> float:
    """Radians between two postures [2, 3]: the turn that lays one on the other."""
    return float(quaternion.angle(horn_rotation(a, b), quaternion.IDENTITY))
