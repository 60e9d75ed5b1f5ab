"""How the upper body sits on the root: upper clouds, posture frames and posture (Heck et al. 2006, 3.2 and 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.joint_paths import joint_transforms

UP, FORWARD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
HIPS_APART = 1e-6  # metres, measured over the floor: closer hips show no facing direction


@dataclass(frozen=True, eq=False)
class Torso:
    """The data of a clip that spatial alignment and posture transfer use.

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
    clouds, frames = np.empty((len(positions), positions.shape[1] - 4, 3)), np.empty((len(positions), 4))
    upright = np.empty_like(clouds)
    fill_torso(positions, world, posture_frame(hip_line), clouds, frames, upright)
    return Torso(clouds, quaternion.one_hemisphere(frames), upright)


@compiled(nogil=True, error_model="numpy")
def fill_torso(
    positions: Floats, world: Floats, turns: Floats, clouds: Floats, frames: Floats, upright: Floats
) -> None:
    """Fills `clouds`, `frames` and `upright`, of a `Torso`.

    positions: [F, 4 + P, 3], the pelvis first and the cloud from 4 on. world: [F, 2, 4] the rotations of the pelvis and
    of its parent. turns: [F, 4] the posture frames in the world.
    """
    for frame in range(len(positions)):
        pelvis, above, turn = world[frame, 0], world[frame, 1], turns[frame]
        x, y, z, w = -above[0], -above[1], -above[2], above[3]
        frames[frame, 0] = w * turn[0] + x * turn[3] + y * turn[2] - z * turn[1]
        frames[frame, 1] = w * turn[1] - x * turn[2] + y * turn[3] + z * turn[0]
        frames[frame, 2] = w * turn[2] + x * turn[1] - y * turn[0] + z * turn[3]
        frames[frame, 3] = w * turn[3] - x * turn[0] - y * turn[1] - z * turn[2]
        for point in range(clouds.shape[1]):
            vx = positions[frame, 4 + point, 0] - positions[frame, 0, 0]
            vy = positions[frame, 4 + point, 1] - positions[frame, 0, 1]
            vz = positions[frame, 4 + point, 2] - positions[frame, 0, 2]
            _turn_back(pelvis, vx, vy, vz, clouds[frame, point])
            _turn_back(turn, vx, vy, vz, upright[frame, point])


@compiled(nogil=True, error_model="numpy")
def _turn_back(q: Floats, vx: float, vy: float, vz: float, turned: Floats) -> None:
    """Fills `turned` [3] with a vector turned by the inverse of `q` [4]."""
    x, y, z, w = -q[0], -q[1], -q[2], q[3]
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    turned[0] = vx + w * tx + y * tz - z * ty
    turned[1] = vy + w * ty + z * tx - x * tz
    turned[2] = vz + w * tz + x * ty - y * tx


def posture_frame(hip_line: Floats) -> Floats:
    """Returns the world rotations H [F, 4] of the posture frame, from the vectors [F, 3] from right to left hip.

    x lies along the hips, z = x cross up, y = z cross x. In this frame a torso is free of the hips' yaw and roll, but
    keeps its lean against gravity (docs/method.md). The hips must be at least HIPS_APART apart over the floor.
    """
    x, y, z = hip_line[:, 0], hip_line[:, 1], hip_line[:, 2]
    yaw = quaternion.about(UP, np.arctan2(-z, x))
    return quaternion.multiply(yaw, quaternion.about(FORWARD, np.arctan2(y, np.hypot(x, z))))
