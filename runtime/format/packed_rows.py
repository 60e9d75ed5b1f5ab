"""Packs the rows of a bank."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.format.rows import (
    CLOUD,
    FIRST_JOINT,
    PELVIS,
    POSTURE_FRAME,
    ROOT,
    SIZE,
    TORSO_OFFSET,
    Float32s,
    Layout,
    TorsoRows,
)


def packed(layout: Layout, roots: Floats, rotations: Floats, torso: TorsoRows) -> dict[str, Float32s]:
    """Returns rows [n, columns] of both tables for n frames: roots [n, 3] metres, rotations [n, J, 4], torsos."""
    sizes = 0.5 * np.sum(torso.clouds**2, axis=(1, 2))
    roots, rotations = np.ascontiguousarray(roots, np.float64), np.ascontiguousarray(rotations, np.float64)
    clouds, frames, offsets = (np.ascontiguousarray(one, np.float64) for one in torso)
    rows = {name: np.zeros((len(roots), half.columns), np.float32) for name, half in layout.halves.items()}
    for name, half in layout.halves.items():
        joints = np.array((layout.pelvis, *half.joints), np.int64)
        planes = (layout.cloud_width, half.first_plane, half.width)
        fill_rows(rows[name], roots, sizes, rotations, clouds, frames, offsets, joints, planes)
    return rows


def packed_stance(layout: Layout, rotations: Floats) -> Float32s:
    """Returns the row [1, columns] of the table `stances` for a pose [J, 4]; only its rotations are not zero."""
    none = TorsoRows(np.zeros((1, layout.points, 3)), quaternion.IDENTITY[None], quaternion.IDENTITY[None])
    return packed(layout, np.zeros((1, 3)), rotations[None], none)["upper"]


@compiled(nogil=True, error_model="numpy")
def fill_rows(
    rows: Float32s,
    roots: Floats,
    sizes: Floats,
    rotations: Floats,
    clouds: Floats,
    frames: Floats,
    offsets: Floats,
    joints: NDArray[np.int64],
    planes: tuple[int, int, int],
) -> None:
    """Fills rows [n, columns] of zeros of a table; roots, rotations and torsos as in `packed`.

    sizes: [n] half the sum of a cloud's squares. joints: the pelvis, then those of the table. planes: the width of the
    cloud's planes, the first column of the rotations' planes, and their width.
    """
    cloud_width, first_plane, width = planes
    for row in range(len(rows)):
        for i in range(3):
            rows[row, ROOT + i] = roots[row, i]
            for point in range(clouds.shape[1]):
                rows[row, CLOUD + i * cloud_width + point] = clouds[row, point, i]
        rows[row, SIZE] = sizes[row]
        for i in range(4):
            plane = first_plane + i * width
            rows[row, plane + PELVIS] = rotations[row, joints[0], i]
            rows[row, plane + POSTURE_FRAME] = frames[row, i]
            rows[row, plane + TORSO_OFFSET] = offsets[row, i]
            for number in range(1, len(joints)):
                rows[row, plane + FIRST_JOINT - 1 + number] = rotations[row, joints[number], i]
        for lane in range(FIRST_JOINT - 1 + len(joints), width):  # no joint: the identity
            rows[row, first_plane + 3 * width + lane] = 1.0
