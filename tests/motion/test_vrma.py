from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import RoleError
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.humanoid_pose import vrm_bones
from motionsplice.motion.formats.gltf.reader import read_rest
from motionsplice.motion.formats.gltf.t_pose import t_pose
from motionsplice.motion.formats.gltf.vrma import dump_vrma
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions, world_transforms
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.motion.skeleton import Skeleton
from tests.rigs import with_bind_pose, with_bones_above

WALK = make("walk", seconds=1.0)
COUNTING = gesture_pair(3, kinds=["count", "point"], seconds=1.5).truth
X, Y, Z = np.eye(3)


def turned(clip: Clip, seed: int, most: float) -> Clip:
    """Returns the clip on a rig whose limbs and fingers are bound in a random pose, facing anywhere."""
    draw = np.random.default_rng(seed)
    turns = {
        name: Rotation.from_rotvec(draw.uniform(-most, most, 3)).as_quat()
        for name in clip.skeleton.names
        if any(part in name for part in ("Arm", "Hand", "Leg", "Foot"))
    }
    return with_bind_pose(clip, {**turns, "Hips": quaternion.about(Y, draw.uniform(-3.0, 3.0))})


def in_t_pose(clip: Clip) -> tuple[Floats, Floats]:
    """Returns the positions [J, 3] and rotations [J, 4] in the world of the joints in the T-pose."""
    skeleton = clip.skeleton
    turns = t_pose(clip, find_roles(skeleton))
    places = np.zeros((skeleton.joint_count, 3))
    for joint in range(1, skeleton.joint_count):
        parent = skeleton.parents[joint]
        places[joint] = places[parent] + quaternion.rotate(turns[parent], skeleton.offsets[joint])
    return places, turns


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_the_t_pose_does_not_depend_on_the_bind_pose(seed: int) -> None:
    clip = turned(COUNTING.frames(0, 1), seed, 0.6)
    places, _ = in_t_pose(clip)

    def bone(upper: str, lower: str) -> Floats:
        between = places[clip.skeleton.index(lower)] - places[clip.skeleton.index(upper)]
        return np.asarray(between / np.linalg.norm(between))

    for side, outwards in (("Left", X), ("Right", -X)):
        for upper, lower, aim in (
            ("UpLeg", "Leg", -Y),
            ("Leg", "Foot", -Y),
            ("Arm", "ForeArm", outwards),
            ("ForeArm", "Hand", outwards),
            ("HandIndex1", "HandIndex2", outwards),
            ("HandPinky2", "HandPinky3", outwards),
            ("HandThumb1", "HandThumb2", (outwards + Z) / np.sqrt(2.0)),
        ):
            np.testing.assert_allclose(bone(side + upper, side + lower), aim, atol=1e-6, err_msg=f"{side} {upper}")
        foot = bone(f"{side}Foot", f"{side}ToeBase")
        assert abs(foot[0]) < 1e-9
        assert foot[2] > 0.0
        back = np.cross(bone(f"{side}HandPinky1", f"{side}HandIndex1"), outwards)
        np.testing.assert_allclose(back / np.linalg.norm(back), Y if side == "Left" else -Y, atol=1e-6)


def test_the_t_pose_of_a_t_pose_is_itself() -> None:
    _, turns = in_t_pose(WALK)
    assert quaternion.angle(turns, quaternion.IDENTITY).max() < 1e-9


def test_an_a_pose_keeps_the_roll_of_the_arms() -> None:
    """The T-pose turns back what has turned the arms down, and no more."""
    down = {"LeftArm": quaternion.about(Z, -0.9), "RightArm": quaternion.about(Z, 0.9)}
    clip = with_bind_pose(WALK, down)
    _, turns = in_t_pose(clip)
    for name in ("LeftArm", "LeftHand"):
        assert quaternion.angle(turns[clip.skeleton.index(name)], quaternion.about(Z, 0.9)) < 1e-9


@pytest.mark.parametrize("clip", [WALK, COUNTING, turned(COUNTING, 1, 0.5)], ids=["body", "fingers", "turned"])
def test_a_vrm_animation_is_read_back_as_the_same_motion(tmp_path: Path, clip: Clip) -> None:
    (tmp_path / "x.vrma").write_bytes(dump_vrma(clip, find_roles(clip.skeleton)))
    found = read_clip(tmp_path / "x.vrma").clip
    joints = [clip.skeleton.index(name) for name in found.skeleton.names]
    assert sorted(joints) == list(range(clip.skeleton.joint_count))
    assert (found.rate, found.frame_count) == (clip.rate, clip.frame_count)
    np.testing.assert_allclose(joint_positions(found), joint_positions(clip)[:, joints], atol=1e-5)


def test_the_file_is_as_the_specification_says() -> None:
    document, _ = read_document(dump_vrma(COUNTING, find_roles(COUNTING.skeleton)))
    assert document["extensionsUsed"] == ["VRMC_vrm_animation"]
    extension = document["extensions"]["VRMC_vrm_animation"]
    assert extension["specVersion"] == "1.0"
    bones = {bone: document["nodes"][one["node"]] for bone, one in extension["humanoid"]["humanBones"].items()}
    named = {bone: node["name"] for bone, node in bones.items()}
    assert len(bones) == 52
    assert (named["hips"], named["spine"], named["chest"], named["upperChest"]) == ("Hips", "Spine", "Spine1", "Spine2")
    assert (named["leftShoulder"], named["leftUpperArm"], named["rightToes"]) == (
        "LeftShoulder",
        "LeftArm",
        "RightToeBase",
    )
    assert (named["leftThumbMetacarpal"], named["rightLittleDistal"]) == ("LeftHandThumb1", "RightHandPinky3")
    assert bones["hips"]["translation"][1] > 0.8  # above the soles
    (animation,) = document["animations"]
    assert animation["name"] == COUNTING.name
    moved = [document["nodes"][one["target"]["node"]]["name"] for one in animation["channels"]]
    assert sorted(moved) == sorted([*named.values(), "Hips"])


@pytest.mark.parametrize(("height", "lowest"), [(0.0, None), (3.0, 0.0)])
def test_at_rest_the_feet_are_as_high_as_on_the_floor(height: float, lowest: float | None) -> None:
    """If the clip is not on the floor, its lowest joint is taken to be there."""
    clip = replace(WALK, root_positions=WALK.root_positions + height * Y)
    scene, _ = read_rest(dump_vrma(clip, find_roles(clip.skeleton)))
    expected = joint_positions(WALK)[..., 1].min() if lowest is None else lowest
    assert abs(scene.world[0, :, 1, 3].min() - expected) < 1e-6


def test_turns_of_joints_without_a_bone_are_part_of_the_next_bones(tmp_path: Path) -> None:
    """Twist bones and extra joints of the neck: the hand and the head still turn as in the clip."""
    clip = with_bones_above(WALK, {"LeftHand": "LeftForeArmTwist", "Head": "Neck1"})
    rotations = clip.rotations.copy()
    for name in ("LeftForeArmTwist", "Neck1"):
        rotations[:, clip.skeleton.index(name)] = quaternion.about(X, 0.5)
    clip = Clip("walk", clip.skeleton, clip.rate, clip.root_positions, rotations)
    roles = find_roles(clip.skeleton)
    assert clip.skeleton.index("Neck1") not in vrm_bones(clip.skeleton, roles)
    _, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    (tmp_path / "x.vrma").write_bytes(dump_vrma(clip, roles))
    back = read_clip(tmp_path / "x.vrma").clip
    _, found = world_transforms(back.skeleton, back.root_positions, back.rotations)
    assert "LeftForeArmTwist" not in back.skeleton.names
    for name in ("LeftHand", "Head"):
        theirs, ours = found[:, back.skeleton.index(name)], world[:, clip.skeleton.index(name)]
        assert quaternion.angle(theirs, ours).max() < 1e-5


def test_a_rig_without_a_head_is_refused() -> None:
    skeleton = WALK.skeleton
    names = tuple(name.replace("Head", "Top") for name in skeleton.names)
    headless = Skeleton(names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets)
    clip = Clip("walk", headless, WALK.rate, WALK.root_positions, WALK.rotations)
    with pytest.raises(RoleError, match="needs a head"):
        dump_vrma(clip, find_roles(headless))
