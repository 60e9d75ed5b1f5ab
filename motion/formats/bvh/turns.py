"""Rotations from the Euler channels of many joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats

RADIAN = np.pi / 180.0


def fill_rotations(
    rotations: Floats, joints: NDArray[np.int64], order: str, values: Floats, columns: NDArray[np.int64]
) -> None:
    """Fills the rotations [F, J, 4] of `joints` [n] from intrinsic Euler angles, in degrees.

    order: the k axes of the turns, such as "zxy". columns: [n, k] those of `values` [F, width] with the angles.
    """
    compose(values, columns, np.array(["xyz".index(axis) for axis in order]), joints, rotations)


@compiled(nogil=True, error_model="numpy")
def compose(
    values: Floats,
    columns: NDArray[np.int64],
    axes: NDArray[np.int64],
    joints: NDArray[np.int64],
    rotations: Floats,
) -> None:
    """Fills `rotations` [F, joints, 4], as `quaternion.from_euler`; see `fill_rotations`."""
    for frame in range(len(values)):
        for number in range(len(joints)):
            x, y, z, w = 0.0, 0.0, 0.0, 1.0
            for turn in range(len(axes)):
                half = values[frame, columns[number, turn]] * RADIAN * 0.5
                s, c = np.sin(half), np.cos(half)
                if axes[turn] == 0:
                    x, y, z, w = c * x + s * w, c * y + s * z, c * z - s * y, c * w - s * x
                elif axes[turn] == 1:
                    y, z, x, w = c * y + s * w, c * z + s * x, c * x - s * z, c * w - s * y
                else:
                    z, x, y, w = c * z + s * w, c * x + s * y, c * y - s * x, c * w - s * z
            place = rotations[frame, joints[number]]
            place[0], place[1], place[2], place[3] = x, y, z, w
