from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.errors import ClipError
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.posture import measure_torso
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
