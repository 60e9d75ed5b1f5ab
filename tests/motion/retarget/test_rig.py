from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.retarget.kinds import FOOT, KINDS
from bench.retarget.rigs import Kind, on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import find_roles

DOWN = quaternion.about([1.0, 0.0, 0.0], np.radians(75.0))
FEET_DOWN = replace(KINDS["built-in"], bind=lambda name: DOWN if FOOT.search(name) else quaternion.IDENTITY)


@pytest.mark.parametrize(
    ("kind", "shown"), [(KINDS["Mixamo"], True), (KINDS["VRM"], True), (KINDS["LAFAN1"], False), (FEET_DOWN, False)]
)
def test_a_rig_has_a_standing_pose_of_its_own_if_only_a_motion_shows_it(kind: Kind, shown: bool) -> None:
    clip = on_rig(make("walk", seconds=2.0, rate=30.0), kind)
    roles = find_roles(clip.skeleton)
    pose = Rig.of(clip, roles).pose
    assert (pose is None) == shown
    if pose is not None:
        np.testing.assert_array_equal(pose, standing_pose(clip.skeleton, roles, clip))
