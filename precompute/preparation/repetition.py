"""How far an upper body is from itself a stride later: what no alignment by the legs can know."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.best_rotations import best_rotations
from motionsplice.precompute.body.joint_paths import upper_joints

RATE = 30.0  # frames per second at most at which strides are compared
DECIMALS = 6  # micrometres: a bank's bytes must not depend on last bits, in which compilations of a kernel differ
LEAST = 1.5  # strides: fewer have too little to be compared


def stride_to_stride(clip: Clip, clouds: Floats, phase: Floats, roles: Roles) -> float:
    """Returns the mean distance, metres, of the upper body's joints from themselves a stride later and earlier.

    The strides are aligned in space like a splice, so only what the arms and the spine's bend do counts. clouds: the
    torso clouds [F, P, 3] in the pelvis's frame. phase: [F] cycles. Returns 0 for less than LEAST strides.
    """
    step = max(1, int(clip.rate / RATE))
    phase = phase[: clip.frame_count : step]
    if phase[-1] - phase[0] < LEAST:
        return 0.0
    local, clouds = upper_joints(clip, roles, step), clouds[: clip.frame_count : step]
    apart = []
    for shift in (1.0, -1.0):
        inside = np.flatnonzero((phase + shift >= phase[0]) & (phase + shift <= phase[-1]))
        later = np.interp(phase[inside] + shift, phase, np.arange(len(phase)))
        aligned = best_rotations(clouds[inside], quaternion.interpolated(clouds, later))
        apart.append(mean_distance(local, inside, *quaternion.neighbours(len(local), later), aligned))
    return round(float(np.mean(apart)), DECIMALS)


@compiled(nogil=True, error_model="numpy")
def mean_distance(
    local: Floats,
    frames: NDArray[np.int64],
    before: NDArray[np.int64],
    after: NDArray[np.int64],
    t: Floats,
    turns: Floats,
) -> float:
    """Returns the mean distance of points [F, p, 3] at `frames` [n] from those at moments `t` [n] of the way from
    frames `before` [n] to frames `after` [n], turned by `turns` [n, 4]."""
    total = 0.0
    for k in range(len(frames)):
        x, y, z, w = turns[k, 0], turns[k, 1], turns[k, 2], turns[k, 3]
        here, first, last = local[frames[k]], local[before[k]], local[after[k]]
        for i in range(local.shape[1]):
            vx = first[i, 0] + t[k] * (last[i, 0] - first[i, 0])
            vy = first[i, 1] + t[k] * (last[i, 1] - first[i, 1])
            vz = first[i, 2] + t[k] * (last[i, 2] - first[i, 2])
            tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
            dx = here[i, 0] - (vx + w * tx + y * tz - z * ty)
            dy = here[i, 1] - (vy + w * ty + z * tx - x * tz)
            dz = here[i, 2] - (vz + w * tz + x * ty - y * tx)
            total += np.sqrt(dx * dx + dy * dy + dz * dz)
    return total / (len(frames) * local.shape[1])
