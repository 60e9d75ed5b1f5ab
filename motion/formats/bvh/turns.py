"""Rotations from the Euler channels of many joints."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motionsplice.motion.quaternion import Floats

BLOCK = 256  # frames converted at once, so that their angles stay in a core's cache


def fill_rotations(
    rotations: Floats, joints: NDArray[np.int64], order: str, values: Floats, columns: NDArray[np.int64]
) -> None:
    """Fills the rotations [F, J, 4] of `joints` [n] from intrinsic Euler angles, in degrees.

    order: the k axes of the turns, such as "zxy". columns: [n, k] those of `values` [F, width] with the angles.
    """
    axes = np.array(["xyz".index(axis) for axis in order])
    for first in range(0, len(values), BLOCK):
        halves = np.radians(values[first : first + BLOCK, columns]) * 0.5
        compose(np.sin(halves), np.cos(halves), axes, joints, rotations[first : first + BLOCK])


@njit(cache=True, nogil=True, error_model="numpy")
def compose(
    sines: Floats, cosines: Floats, axes: NDArray[np.int64], joints: NDArray[np.int64], rotations: Floats
) -> None:
    """Fills `rotations` [F, joints, 4], as `quaternion.from_euler`; sines, cosines [F, n, k] are of half the angles."""
    q = np.empty(4)
    for frame in range(len(sines)):
        for number in range(len(joints)):
            q[:3], q[3] = 0.0, 1.0
            for turn in range(len(axes)):
                i = axes[turn]
                j, k = (i + 1) % 3, (i + 2) % 3
                s, c = sines[frame, number, turn], cosines[frame, number, turn]
                qi, qj, qk, qw = q[i], q[j], q[k], q[3]
                q[i], q[j], q[k], q[3] = c * qi + s * qw, c * qj + s * qk, c * qk - s * qj, c * qw - s * qi
            rotations[frame, joints[number]] = q
