from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.format.packed_rows import packed
from motionsplice.runtime.format.rows import (
    CLOUD,
    FIRST_JOINT,
    PELVIS,
    POSTURE_FRAME,
    ROOT,
    SIZE,
    TORSO_OFFSET,
    Float32s,
    Half,
    Layout,
    TorsoRows,
)
from tests.conftest import CLIPS

SKELETON = CLIPS["walk"].skeleton
LAYOUT = Layout.of(SKELETON, find_roles(SKELETON))


def packed_slowly(half: Half, roots: Floats, rotations: Floats, torso: TorsoRows) -> Float32s:
    """The twin of the kernel: a table's rows, column by column."""
    rows = np.zeros((len(roots), half.columns), np.float32)
    rows[:, ROOT : ROOT + 3] = roots
    rows[:, SIZE] = 0.5 * np.sum(torso.clouds**2, axis=(1, 2))
    for axis in range(3):
        first = CLOUD + axis * LAYOUT.cloud_width
        rows[:, first : first + LAYOUT.points] = torso.clouds[:, :, axis]
    lanes = half.lanes(rows)
    lanes[:] = quaternion.IDENTITY
    lanes[:, PELVIS], lanes[:, POSTURE_FRAME] = rotations[:, LAYOUT.pelvis], torso.frames
    lanes[:, TORSO_OFFSET] = torso.offsets
    lanes[:, FIRST_JOINT : FIRST_JOINT + len(half.joints)] = rotations[:, half.joints]
    return rows


@pytest.mark.parametrize("frames", [0, 1, 300])
def test_rows_are_packed_as_by_the_slow_twin(frames: int) -> None:
    rng = np.random.default_rng(frames)
    roots, rotations = rng.normal(size=(frames, 3)), rng.normal(size=(frames, SKELETON.joint_count, 4))
    still = np.broadcast_to(quaternion.IDENTITY, (frames, 4))
    torso = TorsoRows(rng.normal(size=(frames, LAYOUT.points, 3)), rng.normal(size=(frames, 4)), still)
    for name, rows in packed(LAYOUT, roots, rotations, torso).items():
        np.testing.assert_array_equal(rows, packed_slowly(LAYOUT.halves[name], roots, rotations, torso))


def test_motion_is_what_was_packed() -> None:
    rng = np.random.default_rng(1)
    roots, rotations = rng.normal(size=(5, 3)), rng.normal(size=(5, SKELETON.joint_count, 4))
    torso = TorsoRows(rng.normal(size=(5, LAYOUT.points, 3)), rng.normal(size=(5, 4)), rng.normal(size=(5, 4)))
    rows = packed(LAYOUT, roots, rotations, torso)
    for found, wanted in zip(LAYOUT.motion(rows["lower"], rows["upper"]), (roots, rotations), strict=True):
        np.testing.assert_array_equal(found, wanted.astype(np.float32))
    for found, wanted in zip(LAYOUT.torso(rows["lower"]), torso, strict=True):
        np.testing.assert_array_equal(found, wanted.astype(np.float32))
