"""How far an upper body is from itself a stride later: what no alignment by the legs can know."""

from __future__ import annotations

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
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
        turned = quaternion.rotate(aligned[:, None], quaternion.interpolated(local, later))
        apart.append(np.linalg.norm(local[inside] - turned, axis=2).mean())
    return round(float(np.mean(apart)), DECIMALS)
