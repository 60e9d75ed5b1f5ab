from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.errors import RoleError, SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.fold import Nodes, fold
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.roles import ENDS, common_ancestor, find_roles, limbs_by_name, read_roles_file
from motionsplice.motion.skeleton import Skeleton
from tests.conftest import CLIPS

SKELETON = CLIPS["walk"].skeleton

# Each rig as chains of joints; the first joint of a chain is the parent of the rest.
RIGS: Mapping[str, tuple[str, ...]] = {
    "CMU (BVH)": (
        "Hips LHipJoint LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        "Hips RHipJoint RightUpLeg RightLeg RightFoot RightToeBase",
        "Hips LowerBack Spine Spine1 Neck Neck1 Head",
        "Spine1 LeftShoulder LeftArm LeftForeArm LeftHand LeftFingerBase LeftHandIndex1",
        "Spine1 RightShoulder RightArm RightForeArm RightHand RightFingerBase RThumb",
    ),
    "CMU (ASF)": (
        "root lhipjoint lfemur ltibia lfoot ltoes",
        "root rhipjoint rfemur rtibia rfoot rtoes",
        "root lowerback upperback thorax lowerneck upperneck head",
        "thorax lclavicle lhumerus lradius lwrist lhand lfingers",
        "thorax rclavicle rhumerus rradius rwrist rhand rfingers",
    ),
    "Mixamo": (
        "mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Spine2 mixamorig:Neck mixamorig:Head",
        "mixamorig:Spine2 mixamorig:LeftShoulder mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand",
        "mixamorig:Spine2 mixamorig:RightShoulder mixamorig:RightArm mixamorig:RightForeArm mixamorig:RightHand",
        "mixamorig:Hips mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftToeBase",
        "mixamorig:Hips mixamorig:RightUpLeg mixamorig:RightLeg mixamorig:RightFoot mixamorig:RightToeBase",
    ),
    "Unreal": (
        "root pelvis spine_01 spine_02 spine_03 neck_01 head",
        "spine_03 clavicle_l upperarm_l upperarm_twist_01_l",
        "upperarm_l lowerarm_l hand_l index_01_l",
        "lowerarm_l lowerarm_twist_01_l",
        "spine_03 clavicle_r upperarm_r lowerarm_r hand_r",
        "pelvis thigh_l calf_l foot_l ball_l",
        "thigh_l thigh_twist_01_l",
        "pelvis thigh_r calf_r foot_r ball_r",
        "root ik_foot_root ik_foot_l",
        "ik_foot_root ik_foot_r",
        "root ik_hand_root ik_hand_gun ik_hand_l",
        "ik_hand_gun ik_hand_r",
    ),
    "LAFAN1": (
        "Hips LeftUpLeg LeftLeg LeftFoot LeftToe",
        "Hips RightUpLeg RightLeg RightFoot RightToe",
        "Hips Spine Spine1 Spine2 Neck Head",
        "Spine2 LeftShoulder LeftArm LeftForeArm LeftHand",
        "Spine2 RightShoulder RightArm RightForeArm RightHand",
    ),
    "Bandai Namco": (
        "joint_Root Hips Spine Chest Neck Head",
        "Chest Shoulder_L UpperArm_L LowerArm_L Hand_L",
        "Chest Shoulder_R UpperArm_R LowerArm_R Hand_R",
        "Hips UpperLeg_L LowerLeg_L Foot_L Toes_L",
        "Hips UpperLeg_R LowerLeg_R Foot_R Toes_R",
    ),
    "glTF humanoid": (
        "hips spine chest upperChest neck head",
        "upperChest leftShoulder leftUpperArm leftLowerArm leftHand",
        "upperChest rightShoulder rightUpperArm rightLowerArm rightHand",
        "hips leftUpperLeg leftLowerLeg leftFoot leftToes",
        "hips rightUpperLeg rightLowerLeg rightFoot rightToes",
    ),
    "VRoid": (
        "Root J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_UpperChest J_Bip_C_Neck J_Bip_C_Head",
        "J_Bip_C_UpperChest J_Bip_L_Shoulder J_Bip_L_UpperArm J_Bip_L_LowerArm J_Bip_L_Hand",
        "J_Bip_C_UpperChest J_Bip_R_Shoulder J_Bip_R_UpperArm J_Bip_R_LowerArm J_Bip_R_Hand",
        "J_Bip_C_Hips J_Bip_L_UpperLeg J_Bip_L_LowerLeg J_Bip_L_Foot J_Bip_L_ToeBase",
        "J_Bip_C_Hips J_Bip_R_UpperLeg J_Bip_R_LowerLeg J_Bip_R_Foot J_Bip_R_ToeBase",
    ),
    "Rigify": (
        "DEF-spine DEF-spine.001 DEF-spine.002 DEF-spine.003 DEF-spine.004 DEF-spine.006",
        "DEF-spine.003 DEF-shoulder.L DEF-upper_arm.L DEF-upper_arm.L.001 DEF-forearm.L DEF-forearm.L.001 DEF-hand.L",
        "DEF-spine.003 DEF-shoulder.R DEF-upper_arm.R DEF-upper_arm.R.001 DEF-forearm.R DEF-forearm.R.001 DEF-hand.R",
        "DEF-spine DEF-thigh.L DEF-thigh.L.001 DEF-shin.L DEF-shin.L.001 DEF-foot.L DEF-toe.L",
        "DEF-spine DEF-thigh.R DEF-thigh.R.001 DEF-shin.R DEF-shin.R.001 DEF-foot.R DEF-toe.R",
    ),
    "Mixamo (three.js)": (
        "mixamorigHips mixamorigSpine mixamorigSpine1 mixamorigSpine2 mixamorigNeck mixamorigHead",
        "mixamorigSpine2 mixamorigLeftShoulder mixamorigLeftArm mixamorigLeftForeArm mixamorigLeftHand",
        "mixamorigSpine2 mixamorigRightShoulder mixamorigRightArm mixamorigRightForeArm mixamorigRightHand",
        "mixamorigHips mixamorigLeftUpLeg mixamorigLeftLeg mixamorigLeftFoot mixamorigLeftToeBase",
        "mixamorigHips mixamorigRightUpLeg mixamorigRightLeg mixamorigRightFoot mixamorigRightToeBase",
    ),
    "SMPL": (
        "Pelvis L_Hip L_Knee L_Ankle L_Foot",
        "Pelvis R_Hip R_Knee R_Ankle R_Foot",
        "Pelvis Spine1 Spine2 Spine3 Neck Head",
        "Spine3 L_Collar L_Shoulder L_Elbow L_Wrist L_Hand",
        "Spine3 R_Collar R_Shoulder R_Elbow R_Wrist R_Hand",
    ),
    "Biped": (
        "Bip01 Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Neck Bip01_Head",
        "Bip01_Spine1 Bip01_L_Clavicle Bip01_L_UpperArm Bip01_L_Forearm Bip01_L_Hand",
        "Bip01_Spine1 Bip01_R_Clavicle Bip01_R_UpperArm Bip01_R_Forearm Bip01_R_Hand",
        "Bip01_Pelvis Bip01_L_Thigh Bip01_L_Calf Bip01_L_Foot Bip01_L_Toe0",
        "Bip01_Pelvis Bip01_R_Thigh Bip01_R_Calf Bip01_R_Foot Bip01_R_Toe0",
    ),
}
EXPECTED = {  # root, pelvis, top of the spine, left hip, left knee, left shoulder, left elbow, left wrist
    "CMU (BVH)": "Hips LowerBack Spine1 LeftUpLeg LeftLeg LeftArm LeftForeArm LeftHand",
    "CMU (ASF)": "root lowerback thorax lfemur ltibia lhumerus lradius lwrist",
    "Mixamo": "mixamorig:Hips mixamorig:Spine mixamorig:Spine2 mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftArm"
    " mixamorig:LeftForeArm mixamorig:LeftHand",
    "Unreal": "pelvis spine_01 spine_03 thigh_l calf_l upperarm_l lowerarm_l hand_l",
    "Mixamo (three.js)": "mixamorigHips mixamorigSpine mixamorigSpine2 mixamorigLeftUpLeg mixamorigLeftLeg"
    " mixamorigLeftArm mixamorigLeftForeArm mixamorigLeftHand",
    "SMPL": "Pelvis Spine1 Spine3 L_Hip L_Knee L_Shoulder L_Elbow L_Wrist",
    "LAFAN1": "Hips Spine Spine2 LeftUpLeg LeftLeg LeftArm LeftForeArm LeftHand",
    "Bandai Namco": "Hips Spine Chest UpperLeg_L LowerLeg_L UpperArm_L LowerArm_L Hand_L",
    "glTF humanoid": "hips spine upperChest leftUpperLeg leftLowerLeg leftUpperArm leftLowerArm leftHand",
    "VRoid": "J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_UpperChest J_Bip_L_UpperLeg J_Bip_L_LowerLeg J_Bip_L_UpperArm"
    " J_Bip_L_LowerArm J_Bip_L_Hand",
    "Rigify": "DEF-spine DEF-spine.001 DEF-spine.003 DEF-thigh.L DEF-shin.L DEF-upper_arm.L DEF-forearm.L DEF-hand.L",
    "Biped": "Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_L_Thigh Bip01_L_Calf Bip01_L_UpperArm Bip01_L_Forearm"
    " Bip01_L_Hand",
}


def rig(chains: tuple[str, ...]) -> Skeleton:
    """A rig of these chains. The offsets are arbitrary, because only names matter here."""
    names: list[str] = []
    parents: list[int] = []
    for chain in chains:
        joints = chain.split()
        for above, joint in zip([None, *joints], joints, strict=False):
            if joint not in names:
                names.append(joint)
                parents.append(-1 if above is None else names.index(above))
    return Skeleton(tuple(names), np.array(parents), np.ones((len(names), 3)), np.zeros(0, np.int64), np.zeros((0, 3)))


def folded(skeleton: Skeleton) -> Skeleton:
    found = limbs_by_name(skeleton.names, {})
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (1, skeleton.joint_count, 1))
    nodes = Nodes(
        skeleton.names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets, {}, rotations
    )
    return fold(nodes, common_ancestor(skeleton.parents, [found[role] for role in ENDS])).skeleton


@pytest.mark.parametrize("name", RIGS)
def test_the_roles_of_common_rigs_are_found_by_name(name: str) -> None:
    skeleton = folded(rig(RIGS[name]))
    roles = find_roles(skeleton)
    joints = [roles.root, roles.pelvis, roles.spine[-1], roles.left_hip, roles.left_knee]
    joints += [roles.left_shoulder, roles.left_elbow, roles.left_wrist]
    assert " ".join(skeleton.names[joint] for joint in joints) == EXPECTED[name]
    for role in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist"):
        left, right = (skeleton.names[getattr(roles, f"{side}_{role}")] for side in ("left", "right"))
        mirrored = left.replace("Left", "Right").replace("left", "right")
        mirrored = re.sub(r"(?:(?<=[_.])|^)[lL](?=$|_)", lambda side: {"l": "r", "L": "R"}[side[0]], mirrored)
        assert right == ("r" + left[1:] if name == "CMU (ASF)" else mirrored)


def test_given_roles_take_precedence_over_names() -> None:
    skeleton = rig(RIGS["Mixamo"])
    roles = find_roles(skeleton, {"left_wrist": "mixamorig:LeftHand", "spine": ["mixamorig:Spine2"]})
    assert roles.left_wrist == skeleton.index("mixamorig:LeftHand")
    assert roles.spine == (skeleton.index("mixamorig:Spine2"),)
    with pytest.raises(RoleError, match="Did you mean 'mixamorig:LeftHand'"):
        find_roles(skeleton, {"left_wrist": "mixamorig:LeftHnd"})


def test_the_ankle_is_preferred_to_the_foot() -> None:
    skeleton = rig(RIGS["SMPL"])
    assert skeleton.names[find_roles(skeleton).left_ankle] == "L_Ankle"


def test_twist_joints_count_towards_the_leg() -> None:
    skeleton = rig(RIGS["Rigify"])  # thigh, thigh twist, shin, shin twist, foot: four bones of length sqrt(3)
    assert find_roles(skeleton).leg_length(skeleton) == pytest.approx(4.0 * np.sqrt(3.0))


@pytest.mark.parametrize("role", ["left_nee", "root"])
def test_an_unknown_role_is_refused(role: str) -> None:
    with pytest.raises(SettingsError, match=f"unknown role '{role}'"):
        find_roles(rig(RIGS["Mixamo"]), {role: "mixamorig:Hips"})


@pytest.mark.parametrize("role", ["pelvis", "spine"])
def test_an_unknown_joint_for_the_trunk_is_refused(role: str) -> None:
    with pytest.raises(RoleError, match=f"unknown joint 'Belly' for role {role}"):
        find_roles(rig(RIGS["Mixamo"]), {role: "Belly"})


def test_missing_roles_are_reported_with_all_joints_and_a_file_to_fill_in() -> None:
    skeleton = rig(tuple(chain.replace("LeftLeg", "Alpha").replace("RightArm", "Beta") for chain in RIGS["LAFAN1"]))
    with pytest.raises(RoleError) as error:
        find_roles(skeleton)
    message = str(error.value)
    for words in ("left_knee, right_shoulder", "Alpha", "left_hip = LeftUpLeg", '[roles]\nleft_knee = ""'):
        assert words in message


def test_a_rig_without_a_trunk_is_refused() -> None:
    chains = tuple(chain.replace("Spine2 ", "Hips ") for chain in RIGS["LAFAN1"] if not chain.startswith("Hips Spine"))
    with pytest.raises(RoleError, match="no trunk found: arms and legs hang on one joint, 'Hips'") as error:
        find_roles(rig(chains))
    assert "--roles" not in str(error.value)


def test_roles_that_form_no_body_are_refused() -> None:
    skeleton = CLIPS["walk"].skeleton
    for given, words in (
        ({"left_knee": "Head"}, r"'Head' \(left knee\) is not below 'LeftUpLeg' \(left hip\), but hangs on 'Neck'"),
        ({"left_hip": "RightUpLeg"}, r"'LeftLeg' \(left knee\) is not below 'RightUpLeg'"),
        ({"left_shoulder": "RightArm"}, r"'LeftForeArm' \(left elbow\) is not below 'RightArm'"),
    ):
        with pytest.raises(RoleError, match=words):
            find_roles(skeleton, given)
    for pelvis in ("Hips", "LeftUpLeg"):
        with pytest.raises(RoleError, match="is not between the root and the arms"):
            find_roles(skeleton, {"pelvis": pelvis})
    assert skeleton.names[find_roles(skeleton).pelvis] == "Spine"


def test_feet_that_hang_on_a_target_are_named(tmp_path: Path) -> None:
    """As in rigs that are posed by IK, whose feet are no children of the shins."""
    walk = CLIPS["walk"].skeleton
    parents = walk.parents.copy()
    parents[walk.index("LeftFoot")] = 0
    clip = replace(CLIPS["walk"], skeleton=replace(walk, parents=parents))
    (tmp_path / "walk.bvh").write_bytes(dump_bvh(clip))
    with pytest.raises(RoleError, match=r"'LeftFoot' \(left ankle\) is not below 'LeftLeg' \(left knee\), but"):
        read_clip(tmp_path / "walk.bvh")


def test_a_roles_file_is_checked(tmp_path: Path) -> None:
    file = tmp_path / "roles.toml"
    with pytest.raises(SettingsError, match=r"roles\.toml: the file cannot be read"):
        read_roles_file(file)
    file.write_text('[roles]\nleft_knee = "Alpha"\nspine = ["A", "B"]\n')
    assert read_roles_file(file) == {"left_knee": "Alpha", "spine": ["A", "B"]}
    for text, words in {
        "[roles]\nleft_nee = 'x'": "Did you mean 'left_knee'",
        "[roles]\nleft_knee = 3": "not the name of a joint",
        "[rolls]\nleft_knee = 'x'": "expected one table",
        "[roles": "not TOML",
    }.items():
        file.write_text(text)
        with pytest.raises(SettingsError, match=words):
            read_roles_file(file)


def test_the_only_joint_on_an_ankle_is_the_toe_whatever_its_name() -> None:
    names = tuple(name.replace("ToeBase", "FootThumb1") for name in SKELETON.names)
    roles = find_roles(replace(SKELETON, names=names))
    assert names[roles.left_toe] == "LeftFootThumb1"
    assert names[roles.right_toe] == "RightFootThumb1"
    one_sided = tuple(name.replace("LeftToeBase", "LeftFootThumb1") for name in SKELETON.names)
    assert find_roles(replace(SKELETON, names=one_sided)).left_toe == -1
