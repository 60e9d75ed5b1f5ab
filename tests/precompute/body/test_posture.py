from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.errors import ClipError
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.posture import measure_torso, posture_frame
from tests.conftest import CLIPS

WALK = replace(CLIPS["walk"].frames(0, 20), name="walk")
ROLES = find_roles(WALK.skeleton)


def test_the_error_names_the_frame_where_one_hip_is_above_the_other() -> None:
    rotations = WALK.rotations.copy()
    rotations[7, 0] = quaternion.about([0.0, 0.0, 1.0], 0.5 * np.pi)
    with pytest.raises(ClipError, match=r"clip 'walk', frame 7: one hip is straight above the other"):
        measure_torso(replace(WALK, rotations=rotations), ROLES)


def test_hips_in_one_place_are_refused() -> None:
    offsets = WALK.skeleton.offsets.copy()
    offsets[ROLES.left_hip] = offsets[ROLES.right_hip]
    with pytest.raises(ClipError, match=r"clip 'walk', frame 0: .* in the same place"):
        measure_torso(replace(WALK, skeleton=replace(WALK.skeleton, offsets=offsets)), ROLES)


def test_the_kernel_measures_as_the_slow_twin() -> None:
    parent = int(WALK.skeleton.parents[ROLES.pelvis])
    positions, world = world_transforms(WALK.skeleton, WALK.root_positions, WALK.rotations)
    turns = posture_frame(positions[:, ROLES.left_hip] - positions[:, ROLES.right_hip])
    cloud = positions[:, ROLES.upper_cloud] - positions[:, [ROLES.pelvis]]
    torso = measure_torso(WALK, ROLES)
    for found, wanted in (
        (torso.clouds, quaternion.rotate(quaternion.conjugate(world[:, [ROLES.pelvis]]), cloud)),
        (torso.upright, quaternion.rotate(quaternion.conjugate(turns[:, None]), cloud)),
        (torso.frames, quaternion.one_hemisphere(quaternion.multiply(quaternion.conjugate(world[:, parent]), turns))),
    ):
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-13)
