from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.retarget.kinds import FOOT, KINDS
from bench.retarget.rigs import on_rig
from motionsplice.motion import quaternion
from motionsplice.motion.kinematics import bind_positions
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.stance import standing_pose, stands
from motionsplice.motion.roles import find_roles

WALK = make("walk", seconds=2.0, rate=30.0)


@pytest.mark.parametrize("name", [name for name in KINDS if name != "LAFAN1"])
def test_a_bind_pose_that_stands_is_the_standing_pose_turned_to_the_front(name: str) -> None:
    clip = on_rig(WALK, KINDS[name])
    roles = find_roles(clip.skeleton)
    assert stands(clip.skeleton, roles)
    pose = standing_pose(clip.skeleton, roles, clip)
    facing = quaternion.about([0.0, 1.0, 0.0], np.pi if name == "VRM" else 0.0)
    assert quaternion.angle(pose, facing).max() < 1e-6


def test_a_bind_pose_along_one_axis_stands_as_its_motion_shows() -> None:
    kind = KINDS["LAFAN1"]
    clip = on_rig(WALK, kind)
    roles = find_roles(clip.skeleton)
    assert not stands(clip.skeleton, roles)
    pose = standing_pose(clip.skeleton, roles, clip)
    for joint, name in enumerate(clip.skeleton.names):
        truth = quaternion.conjugate(kind.bind(name))
        assert quaternion.angle(pose[joint], truth) < np.radians(9.5 if "Foot" in name or "Toe" in name else 0.1), name


def test_feet_that_are_bound_pointing_down_stand_as_their_motion_shows() -> None:
    down = quaternion.about([1.0, 0.0, 0.0], np.radians(75.0))
    kind = replace(KINDS["built-in"], bind=lambda name: down if FOOT.search(name) else quaternion.IDENTITY)
    clip = on_rig(WALK, kind)
    roles = find_roles(clip.skeleton)
    assert stands(clip.skeleton, roles)
    pose = standing_pose(clip.skeleton, roles, clip)
    for joint, name in enumerate(clip.skeleton.names):
        truth = quaternion.conjugate(kind.bind(name))
        assert quaternion.angle(pose[joint], truth) < np.radians(9.5 if FOOT.search(name) else 1e-3), name
    assert np.all(standing_pose(clip.skeleton, roles) == pose[0])


def test_limbs_that_do_not_bend_stand_as_in_the_motion() -> None:
    """As of a skeleton file with one frame in a T-pose, whose bones all point up in the bind pose."""
    up = {"LeftArm": 90.0, "RightArm": -90.0, "LeftUpLeg": 180.0, "RightUpLeg": 180.0}
    turns = {name: quaternion.about([0.0, 0.0, 1.0], np.radians(angle)) for name, angle in up.items()}
    limbs = {"Hand": "Arm", "ForeArm": "Arm", "Foot": "UpLeg", "ToeBase": "UpLeg", "Leg": "UpLeg"}

    def bind(name: str) -> Floats:
        side = "Left" if name.startswith("Left") else "Right"
        part = name.removeprefix(side).split("Hand")[0] or "Hand"
        return turns.get(side + limbs.get(part, part), quaternion.IDENTITY)

    rotations = np.tile(quaternion.IDENTITY, (1, WALK.skeleton.joint_count, 1))
    clip = on_rig(
        replace(WALK, rotations=rotations, root_positions=WALK.root_positions[:1]),
        replace(KINDS["built-in"], bind=bind),
    )
    roles = find_roles(clip.skeleton)
    assert not stands(clip.skeleton, roles)
    pose = standing_pose(clip.skeleton, roles, clip)
    for joint, name in enumerate(clip.skeleton.names):
        assert quaternion.angle(pose[joint], quaternion.conjugate(bind(name))) < 1e-3, name


def test_without_a_motion_such_a_bind_pose_is_only_turned_upright() -> None:
    clip = on_rig(WALK, KINDS["LAFAN1"])
    roles = find_roles(clip.skeleton)
    pose = standing_pose(clip.skeleton, roles)
    trunk = bind_positions(clip.skeleton)[roles.spine[-1]] - bind_positions(clip.skeleton)[roles.pelvis]
    up = quaternion.rotate(pose[0], trunk)
    assert up[1] > 0.99 * np.linalg.norm(up)
    assert np.all(pose == pose[0])
