"""How the upper body sits on the root: upper clouds, posture frames and posture (Heck et al. 2006, 3.2, 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from motion import quaternion
from motion.clip import Clip
from motion.errors import ClipError
from motion.kinematics import world_transforms
from motion.pointcloud import horn_rotation
from motion.quaternion import Floats
from motion.roles import Roles

UP = np.array([0.0, 1.0, 0.0])
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
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    pelvis = positions[:, roles.pelvis, None]
    cloud = positions[:, list(roles.upper_cloud)] - pelvis
    from_pelvis = quaternion.conjugate(world[:, roles.pelvis, None])
    hip_line = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    if len(steep := np.flatnonzero(np.hypot(hip_line[:, 0], hip_line[:, 2]) < HIPS_APART)):
        raise ClipError(
            "one hip is straight above the other or in its place, so they do not show which way the body faces",
            place=f"clip {clip.name!r}, frame {steep[0]}",
            mend="Leave the frame out, or name other joints for the hips in a file and pass it as --roles",
        )
    frame = posture_frame(hip_line)
    parent = world[:, clip.skeleton.parents[roles.pelvis]]
    return Torso(
        clouds=quaternion.rotate(from_pelvis, cloud),
        frames=quaternion.one_hemisphere(quaternion.multiply(quaternion.conjugate(parent), frame)),
        upright=quaternion.rotate(quaternion.conjugate(frame)[:, None], cloud),
    )


def posture_frame(hip_line: Floats) -> Floats:
    """World rotations H [F, 4] of the posture frame, from the vectors [F, 3] from right to left hip.

    x lies along the hips, z = x cross up, y = z cross x: the hips' yaw and roll are taken out, while the lean
    against gravity stays (docs/method.md). The hips must lie HIPS_APART over the floor.
    """
    x = hip_line / np.linalg.norm(hip_line, axis=-1, keepdims=True)
    z = np.cross(x, UP)
    z /= np.linalg.norm(z, axis=-1, keepdims=True)
    return np.asarray(Rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1)).as_quat())


def posture_angle(a: Floats, b: Floats) -> float:
    """Radians between two postures [2, 3]: the turn that lays one on the other."""
    return float(quaternion.angle(horn_rotation(a, b), quaternion.IDENTITY))
