from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.humanoid_pose import vrm_bones
from motionsplice.motion.formats.gltf.vrma import dump_vrma
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from tests.oracles.node import needs_node, run
from tests.rigs import with_bind_pose
from tests.vrm_characters import vrm_character

COUNTING = gesture_pair(3, kinds=["count", "point"], seconds=3.0).truth
X, Y, Z = np.eye(3)
A_POSE = {
    "LeftArm": quaternion.about(Z, -0.8),
    "RightArm": quaternion.about(Z, 0.7),
    "LeftForeArm": quaternion.about(Y, -0.4),
    "LeftHand": quaternion.about(X, 0.5),
    "LeftHandMiddle1": quaternion.about(Z, -0.3),
    "LeftUpLeg": quaternion.about(Z, 0.3),
    "RightUpLeg": quaternion.about(Z, -0.2),
    "RightLeg": quaternion.about(X, 0.3),
    "LeftFoot": quaternion.multiply(quaternion.about(Y, 0.4), quaternion.about(Z, -0.3)),
    "RightFoot": quaternion.multiply(quaternion.about(X, -0.3), quaternion.about(Z, 0.2)),
}
ALONG_X = {  # as in LAFAN1: legs and arms along one axis
    "LeftUpLeg": quaternion.about(Z, np.pi / 2),
    "RightUpLeg": quaternion.about(Z, np.pi / 2),
    "RightArm": quaternion.about(Y, np.pi),
}
LIMBS = ("UpperLeg LowerLeg", "LowerLeg Foot", "UpperArm LowerArm", "LowerArm Hand")
FOOT = "Foot Toes"
FINGERS = tuple(
    f"{finger}{upper} {finger}{lower}"
    for finger in ("Index", "Middle", "Ring", "Little")
    for upper, lower in (("Proximal", "Intermediate"), ("Intermediate", "Distal"))
)


def unit(v: Floats) -> Floats:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


@needs_node
@pytest.mark.parametrize("turns", [{}, A_POSE, {**A_POSE, "Hips": quaternion.about(Y, 0.9)}, ALONG_X])
def test_a_vrm_character_points_its_limbs_and_fingers_as_the_clip_does(
    tmp_path: Path, turns: dict[str, Floats]
) -> None:
    """The character has other proportions, and other local axes; the clip's rig other bind poses."""
    clip: Clip = with_bind_pose(COUNTING, turns)
    np.testing.assert_allclose(joint_positions(clip), joint_positions(COUNTING), atol=1e-9)
    roles = find_roles(clip.skeleton)
    (tmp_path / "x.vrma").write_bytes(dump_vrma(clip, roles))
    (tmp_path / "x.vrm").write_bytes(vrm_character())
    frames = [0, 50, 120]
    (found,) = run("vrma.mjs", tmp_path / "x.vrm", tmp_path / "x.vrma", *(frame / clip.rate for frame in frames))
    at = {bone: joint for joint, bone in vrm_bones(clip.skeleton, roles).items()}
    ours = joint_positions(clip)[frames]
    for side in ("left", "right"):
        for bone in (*LIMBS, FOOT, *FINGERS):
            upper, lower = (f"{side}{name}" for name in bone.split())
            theirs = unit(np.array([one[lower] for one in found]) - np.array([one[upper] for one in found]))
            own = unit(ours[:, at[lower]] - ours[:, at[upper]])
            apart = np.degrees(np.arccos(np.clip((theirs * own).sum(axis=1), -1.0, 1.0)))
            most = 0.01 if bone != FOOT else 10.0  # feet are not pointed, but turned as from rest, which differs by 5
            assert apart.max() < most, (side, bone)
