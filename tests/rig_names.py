"""The joint names of real rigs, and the roles of these joints, for tests."""

from __future__ import annotations

from typing import NamedTuple

from motionsplice.motion.role_names import PAIRED


class Rig(NamedTuple):
    """Joint names: those in the middle, and those of the left side, from which the right ones follow.

    roles: hip, knee, ankle, toe, shoulder, elbow, wrist on the left, then neck and head; "-" for none.
    """

    middle: str
    left: str
    sides: tuple[str, str]
    roles: str

    def names(self) -> tuple[str, ...]:
        left = self.left.split(",")
        return (*self.middle.split(","), *left, *(self.right(name) for name in left))

    def right(self, name: str) -> str:
        left, right = self.sides
        return name.replace(left, right, 1)

    def expected(self) -> dict[str, str]:
        *limbs, neck, head = self.roles.split(",")
        left = {f"left_{role}": name for role, name in zip(PAIRED, limbs, strict=True)}
        right = {f"right_{role}": self.right(name) for role, name in zip(PAIRED, limbs, strict=True)}
        found = left | right | {"neck": neck, "head": head}
        return {role: name for role, name in found.items() if name != "-"}


LEFT = ("Left", "Right")
HIK = "LeftUpLeg,LeftLeg,LeftFoot,LeftToeBase,LeftShoulder,LeftArm,LeftForeArm,LeftHand,LeftHandThumb1,LeftHandIndex1"
HIK_ROLES = "LeftUpLeg,LeftLeg,LeftFoot,LeftToeBase,LeftArm,LeftForeArm,LeftHand,Neck,Head"
MIDDLE = "Hips,Spine,Spine1,Spine2,Neck,Head,HeadTop_End"


def with_words(before: str, names: str, after: str = "") -> str:
    return ",".join(f"{before}{name}{after}" for name in names.split(","))


def worded(before: str, after: str = "") -> Rig:
    """HumanIK's names with the same words before and after each."""
    middle, left, roles = (with_words(before, names, after) for names in (MIDDLE, HIK, HIK_ROLES))
    return Rig(middle, left, LEFT, roles)


UNREAL = (
    "pelvis,spine_01,spine_02,spine_03,neck_01,head,ik_foot_root,ik_hand_root,ik_hand_gun,interaction,center_of_mass"
)
RIGS = {
    "Mixamo": worded("mixamorig:"),
    "Mixamo in three.js": worded("mixamorig"),
    "a second Mixamo character": worded("mixamorig7:"),
    "HumanIK": worded(""),
    "HumanIK with a character's name": worded("Character1_"),
    "HumanIK with a reference and rolls": Rig(
        with_words("Character1_", f"Reference,{MIDDLE}"),
        with_words("Character1_", f"LeftUpLegRoll,LeftLegRoll,LeftArmRoll,LeftForeArmRoll,{HIK}"),
        LEFT,
        with_words("Character1_", HIK_ROLES),
    ),
    "Perception Neuron": worded("Robot_"),
    "names of a studio": worded("", "_jnt"),
    "names of another studio": worded("Hero_02_", "_BIND"),
    "numbers of Sketchfab": Rig(
        "Hips_01,Spine_02,Neck_03,Head_04",
        "LeftUpLeg_055,LeftLeg_056,LeftFoot_057,LeftToeBase_058,LeftShoulder_07,LeftArm_08,LeftForeArm_09,LeftHand_010",
        LEFT,
        "LeftUpLeg_055,LeftLeg_056,LeftFoot_057,LeftToeBase_058,LeftArm_08,LeftForeArm_09,LeftHand_010,Neck_03,Head_04",
    ),
    "no capitals": Rig(MIDDLE.lower(), HIK.lower(), ("left", "right"), HIK_ROLES.lower()),
    "no capitals, side last": Rig(
        "hips,spine,neck,head",
        "uplegleft,legleft,footleft,shoulderleft,armleft,forearmleft,handleft",
        ("left", "right"),
        "uplegleft,legleft,footleft,-,armleft,forearmleft,handleft,neck,head",
    ),
    "all capitals": Rig(
        "HIPS,SPINE,NECK,HEAD",
        "LEFT_UP_LEG,LEFT_LEG,LEFT_FOOT,LEFT_TOE,LEFT_ARM,LEFT_FORE_ARM,LEFT_HAND",
        ("LEFT", "RIGHT"),
        "LEFT_UP_LEG,LEFT_LEG,LEFT_FOOT,LEFT_TOE,LEFT_ARM,LEFT_FORE_ARM,LEFT_HAND,NECK,HEAD",
    ),
    "CMU (ASF)": Rig(
        "root,lowerback,upperback,thorax,lowerneck,upperneck,head",
        "lhipjoint,lfemur,ltibia,lfoot,ltoes,lclavicle,lhumerus,lradius,lwrist,lhand,lfingers,lthumb",
        ("l", "r"),
        "lfemur,ltibia,lfoot,ltoes,lhumerus,lradius,lwrist,lowerneck,head",
    ),
    "Unreal 4": Rig(
        UNREAL,
        "thigh_l,calf_l,calf_twist_01_l,foot_l,ball_l,thigh_twist_01_l,clavicle_l,upperarm_l,lowerarm_l,"
        "lowerarm_twist_01_l,hand_l,index_01_l,upperarm_twist_01_l,ik_foot_l,ik_hand_l",
        ("_l", "_r"),
        "thigh_l,calf_l,foot_l,ball_l,upperarm_l,lowerarm_l,hand_l,neck_01,head",
    ),
    "Unreal 5": Rig(
        f"root,{UNREAL},spine_04,spine_05,neck_02",
        "thigh_l,thigh_twist_01_l,thigh_twist_02_l,thigh_correctiveRoot_l,thigh_fwd_l,calf_l,calf_correctiveRoot_l,"
        "calf_knee_l,calf_kneeBack_l,calf_twist_02_l,foot_l,ball_l,bigtoe_01_l,clavicle_l,clavicle_out_l,"
        "upperarm_twist_01_l,upperarm_bicep_l,upperarm_l,lowerarm_in_l,lowerarm_l,wrist_inner_l,wrist_outer_l,hand_l,"
        "thumb_01_l,ik_foot_l,ik_hand_l,weapon_l",
        ("_l", "_r"),
        "thigh_l,calf_l,foot_l,ball_l,upperarm_l,lowerarm_l,hand_l,neck_01,head",
    ),
    "Biped": Rig(
        with_words("Bip01", ", Pelvis, Spine, Spine1, Neck, Head, HeadNub, Footsteps, Prop1"),
        with_words("Bip01 L ", "Thigh,Calf,Foot,Toe0,Toe0Nub,Clavicle,UpperArm,ForeTwist,Forearm,Hand,Finger0"),
        (" L ", " R "),
        with_words("Bip01 L ", "Thigh,Calf,Foot,Toe0,UpperArm,Forearm,Hand") + ",Bip01 Neck,Bip01 Head",
    ),
    "Biped of later versions": Rig(
        with_words("Bip001_", "Pelvis,Spine,Neck,Head"),
        with_words("Bip001_L_", "Thigh,Calf,Foot,Toe0,Clavicle,UpperArm,Forearm,Hand"),
        ("_L_", "_R_"),
        with_words("Bip001_L_", "Thigh,Calf,Foot,Toe0,UpperArm,Forearm,Hand") + ",Bip001_Neck,Bip001_Head",
    ),
    "Valve's Biped": Rig(
        with_words("ValveBiped.Bip01_", "Pelvis,Spine,Spine4,Neck1,Head1"),
        with_words("ValveBiped.Bip01_L_", "Thigh,Calf,Foot,Toe0,Clavicle,UpperArm,Forearm,Hand,Finger0"),
        ("_L_", "_R_"),
        with_words("ValveBiped.Bip01_L_", "Thigh,Calf,Foot,Toe0,UpperArm,Forearm,Hand")
        + ",ValveBiped.Bip01_Neck1,ValveBiped.Bip01_Head1",
    ),
    "Skyrim": Rig(
        "NPC Root [Root],NPC Pelvis [Pelv],NPC Spine [Spn0],NPC Neck [Neck],NPC Head [Head],WEAPON",
        "NPC L Thigh [LThg],NPC L Calf [LClf],NPC L Foot [Lft ],NPC L Toe0 [LToe],NPC L Clavicle [LClv],"
        "NPC L UpperArm [LUar],NPC L UpperarmTwist1 [LUt1],NPC L Forearm [LLar],NPC L Hand [LHnd]",
        ("L", "R"),
        "NPC L Thigh [LThg],NPC L Calf [LClf],NPC L Foot [Lft ],NPC L Toe0 [LToe],NPC L UpperArm [LUar],"
        "NPC L Forearm [LLar],NPC L Hand [LHnd],NPC Neck [Neck],NPC Head [Head]",
    ),
    "Character Creator": Rig(
        "RL_BoneRoot,"
        + with_words("CC_Base_", "Hip,Pelvis,Waist,Spine01,Spine02,NeckTwist01,NeckTwist02,Head,JawRoot"),
        with_words(
            "CC_Base_L_",
            "ThighTwist01,Thigh,CalfTwist01,Calf,KneeShareBone,Foot,ToeBase,BigToe1,Clavicle,UpperarmTwist01,Upperarm,"
            "ElbowShareBone,ForearmTwist01,Forearm,Hand,Thumb1,Index1,Eye,Breast",
        ),
        ("_L_", "_R_"),
        with_words("CC_Base_L_", "Thigh,Calf,Foot,ToeBase,Upperarm,Forearm,Hand") + ",CC_Base_NeckTwist01,CC_Base_Head",
    ),
    "Poser": Rig(
        "hip,abdomen,chest,neck,head",
        "lButtock,lThigh,lShin,lFoot,lToe,lCollar,lShldr,lForeArm,lHand,lThumb1,lIndex1,lEye",
        ("l", "r"),
        "lThigh,lShin,lFoot,lToe,lShldr,lForeArm,lHand,neck,head",
    ),
    "Daz Genesis 3 and 8": Rig(
        "hip,pelvis,abdomenLower,abdomenUpper,chestLower,chestUpper,neckLower,neckUpper,head,upperJaw",
        "lThighBend,lThighTwist,lShin,lFoot,lMetatarsals,lToe,lSmallToe1,lBigToe,lCollar,lShldrBend,lShldrTwist,"
        "lForearmBend,lForearmTwist,lHand,lThumb1,lCarpal1,lPectoral",
        ("l", "r"),
        "lThighBend,lShin,lFoot,lToe,lShldrBend,lForearmBend,lHand,neckLower,head",
    ),
    "Daz Genesis 9": Rig(
        "hip,pelvis,spine1,spine2,spine3,spine4,neck1,neck2,head",
        "l_thigh,l_thightwist1,l_shin,l_foot,l_metatarsal,l_toes,l_shoulder,l_upperarm,l_upperarmtwist1,l_forearm,l_hand",
        ("l_", "r_"),
        "l_thigh,l_shin,l_foot,l_toes,l_upperarm,l_forearm,l_hand,neck1,head",
    ),
    "Biovision": Rig(
        "Hips,Chest,Chest2,Neck,Head",
        "LeftUpLeg,LeftLowLeg,LeftFoot,LeftCollar,LeftUpArm,LeftLowArm,LeftHand",
        LEFT,
        "LeftUpLeg,LeftLowLeg,LeftFoot,-,LeftUpArm,LeftLowArm,LeftHand,Neck,Head",
    ),
    "Blender's cgtookit": Rig(
        "Hips,Spine1,Spine3,Neck,Head",
        "UpLeg_L,LoLeg_L,Foot_L,Toe_L,Clavicle_L,UpArm_L,LoArm_L,Hand_L",
        ("_L", "_R"),
        "UpLeg_L,LoLeg_L,Foot_L,Toe_L,UpArm_L,LoArm_L,Hand_L,Neck,Head",
    ),
    "by joints (Xsens and 3ds Max BVH)": Rig(
        "Hips,Chest,Chest2,Chest3,Chest4,Neck,Head",
        "LeftHip,LeftKnee,LeftAnkle,LeftToe,LeftCollar,LeftShoulder,LeftElbow,LeftWrist",
        LEFT,
        "LeftHip,LeftKnee,LeftAnkle,LeftToe,LeftShoulder,LeftElbow,LeftWrist,Neck,Head",
    ),
    "Xsens": Rig(
        "Pelvis,L5,L3,T12,T8,Neck,Head",
        "LeftShoulder,LeftUpperArm,LeftForeArm,LeftHand,LeftUpperLeg,LeftLowerLeg,LeftFoot,LeftToe",
        LEFT,
        "LeftUpperLeg,LeftLowerLeg,LeftFoot,LeftToe,LeftUpperArm,LeftForeArm,LeftHand,Neck,Head",
    ),
    "Rokoko": Rig(
        "Root,Hip,Spine1,Spine2,Spine3,Spine4,Neck,Head",
        "LeftThigh,LeftShin,LeftFoot,LeftToe,LeftShoulder,LeftArm,LeftForeArm,LeftHand,LeftFinger1Proximal",
        LEFT,
        "LeftThigh,LeftShin,LeftFoot,LeftToe,LeftArm,LeftForeArm,LeftHand,Neck,Head",
    ),
    "OptiTrack": Rig(
        with_words("Skeleton_", "Hip,Ab,Chest,Neck,Head"),
        with_words("Skeleton_L", "Thigh,Shin,Foot,Toe,Shoulder,UArm,FArm,Hand"),
        ("_L", "_R"),
        with_words("Skeleton_L", "Thigh,Shin,Foot,Toe,UArm,FArm,Hand") + ",Skeleton_Neck,Skeleton_Head",
    ),
    "Vicon": Rig(
        "Pelvis,Thorax,Neck,Head",
        "LFemur,LTibia,LFoot,LToes,LClavicle,LHumerus,LRadius,LHand",
        ("L", "R"),
        "LFemur,LTibia,LFoot,LToes,LHumerus,LRadius,LHand,Neck,Head",
    ),
    "Sony mocopi": Rig(
        "root,torso_1,torso_2,torso_7,neck_1,neck_2,head",
        "l_shoulder,l_up_arm,l_low_arm,l_hand,l_up_leg,l_low_leg,l_foot,l_toes",
        ("l_", "r_"),
        "l_up_leg,l_low_leg,l_foot,l_toes,l_up_arm,l_low_arm,l_hand,neck_1,head",
    ),
    "Kinect 2": Rig(
        "SpineBase,SpineMid,SpineShoulder,Neck,Head",
        "HipLeft,KneeLeft,AnkleLeft,FootLeft,ShoulderLeft,ElbowLeft,WristLeft,HandLeft,HandTipLeft,ThumbLeft",
        LEFT,
        "HipLeft,KneeLeft,AnkleLeft,-,ShoulderLeft,ElbowLeft,WristLeft,Neck,Head",
    ),
    "Azure Kinect": Rig(
        "PELVIS,SPINE_NAVEL,SPINE_CHEST,NECK,HEAD",
        "HIP_LEFT,KNEE_LEFT,ANKLE_LEFT,FOOT_LEFT,CLAVICLE_LEFT,SHOULDER_LEFT,ELBOW_LEFT,WRIST_LEFT,HAND_LEFT",
        ("LEFT", "RIGHT"),
        "HIP_LEFT,KNEE_LEFT,ANKLE_LEFT,-,SHOULDER_LEFT,ELBOW_LEFT,WRIST_LEFT,NECK,HEAD",
    ),
    "OpenNI": Rig(
        "TORSO,NECK,HEAD",
        "LEFT_HIP,LEFT_KNEE,LEFT_FOOT,LEFT_SHOULDER,LEFT_ELBOW,LEFT_HAND",
        ("LEFT", "RIGHT"),
        "LEFT_HIP,LEFT_KNEE,LEFT_FOOT,-,LEFT_SHOULDER,LEFT_ELBOW,LEFT_HAND,NECK,HEAD",
    ),
    "SMPL": Rig(
        with_words("m_avg_", "root,Pelvis,Spine1,Spine2,Spine3,Neck,Head"),
        with_words("m_avg_L_", "Hip,Knee,Ankle,Foot,Collar,Shoulder,Elbow,Wrist,Hand"),
        ("_L_", "_R_"),
        with_words("m_avg_L_", "Hip,Knee,Ankle,-,Shoulder,Elbow,Wrist").replace("m_avg_L_-", "-")
        + ",m_avg_Neck,m_avg_Head",
    ),
    "SMPL-X": Rig(
        "pelvis,spine1,spine2,spine3,neck,head,jaw",
        "left_hip,left_knee,left_ankle,left_foot,left_collar,left_shoulder,left_elbow,left_wrist,left_index1",
        ("left", "right"),
        "left_hip,left_knee,left_ankle,-,left_shoulder,left_elbow,left_wrist,neck,head",
    ),
    "Rigify": Rig(
        with_words("DEF-", "spine,spine.001,spine.006")
        + ","
        + with_words("ORG-", "spine,spine.006")
        + ",neck,head,torso",
        "thigh_ik.L,foot_ik.L,hand_ik.L,thigh_fk.L,shin_fk.L,foot_fk.L,toe_fk.L,upper_arm_fk.L,forearm_fk.L,hand_fk.L,"
        "DEF-thigh.L,DEF-thigh.L.001,DEF-shin.L,DEF-shin.L.001,DEF-foot.L,DEF-toe.L,DEF-shoulder.L,DEF-upper_arm.L,"
        "DEF-upper_arm.L.001,DEF-forearm.L,DEF-forearm.L.001,DEF-hand.L,DEF-f_index.01.L,ORG-thigh.L,ORG-shin.L,"
        "ORG-foot.L,ORG-toe.L,ORG-upper_arm.L,ORG-forearm.L,ORG-hand.L,MCH-thigh_parent.L,MCH-foot_ik.parent.L",
        (".L", ".R"),
        "DEF-thigh.L,DEF-shin.L,DEF-foot.L,DEF-toe.L,DEF-upper_arm.L,DEF-forearm.L,DEF-hand.L,-,-",
    ),
    "Rigify in three.js": Rig(
        "DEF-hips,DEF-spine001,DEF-neck,DEF-head",
        "DEF-thighL,DEF-thighL001,DEF-shinL,DEF-footL,DEF-toeL,DEF-shoulderL,DEF-upper_armL,DEF-forearmL,DEF-handL",
        ("L", "R"),
        "DEF-thighL,DEF-shinL,DEF-footL,DEF-toeL,DEF-upper_armL,DEF-forearmL,DEF-handL,DEF-neck,DEF-head",
    ),
    "Blender's human meta-rig": Rig(
        "spine,spine.001,spine.002,spine.003,spine.004,spine.005,spine.006,face",
        "pelvis.L,thigh.L,shin.L,foot.L,toe.L,heel.02.L,shoulder.L,upper_arm.L,forearm.L,hand.L,palm.01.L,thumb.01.L",
        (".L", ".R"),
        "thigh.L,shin.L,foot.L,toe.L,upper_arm.L,forearm.L,hand.L,-,-",
    ),
    "MakeHuman": Rig(
        "root,spine05,spine04,spine03,spine02,spine01,neck01,neck02,neck03,head",
        "pelvis.L,upperleg01.L,upperleg02.L,lowerleg01.L,lowerleg02.L,foot.L,toe1-1.L,toe2-1.L,clavicle.L,shoulder01.L,"
        "upperarm01.L,upperarm02.L,lowerarm01.L,lowerarm02.L,wrist.L,finger1-1.L,breast.L",
        (".L", ".R"),
        "upperleg01.L,lowerleg01.L,foot.L,toe1-1.L,upperarm01.L,lowerarm01.L,wrist.L,neck01,head",
    ),
    "VRoid": Rig(
        "Root,"
        + with_words("J_Bip_C_", "Hips,Spine,Chest,UpperChest,Neck,Head")
        + ",J_Sec_Hair1_01,J_Adj_C_UpperChest",
        with_words("J_Bip_L_", "UpperLeg,LowerLeg,Foot,ToeBase,Shoulder,UpperArm,LowerArm,Hand,Index1")
        + ",J_Sec_L_UpperArm,J_Sec_L_LowerArm,J_Adj_L_FaceEye",
        ("_L_", "_R_"),
        with_words("J_Bip_L_", "UpperLeg,LowerLeg,Foot,ToeBase,UpperArm,LowerArm,Hand") + ",J_Bip_C_Neck,J_Bip_C_Head",
    ),
    "Unity, Godot, Roblox R15": Rig(
        "Hips,Spine,Chest,UpperChest,Neck,Head,LowerTorso,UpperTorso",
        "LeftUpperLeg,LeftLowerLeg,LeftFoot,LeftToes,LeftShoulder,LeftUpperArm,LeftLowerArm,LeftHand,LeftIndexProximal",
        LEFT,
        "LeftUpperLeg,LeftLowerLeg,LeftFoot,LeftToes,LeftUpperArm,LeftLowerArm,LeftHand,Neck,Head",
    ),
    "Advanced Skeleton": Rig(
        "Root_M,RootPart1_M,Spine1_M,Chest_M,Neck_M,NeckPart1_M,Head_M,Jaw_M",
        "Hip_L,HipPart1_L,Knee_L,KneePart1_L,Ankle_L,Toes_L,Scapula_L,Shoulder_L,ShoulderPart1_L,Elbow_L,ElbowPart1_L,"
        "Wrist_L,IndexFinger1_L,Cup_L",
        ("_L", "_R"),
        "Hip_L,Knee_L,Ankle_L,Toes_L,Shoulder_L,Elbow_L,Wrist_L,Neck_M,Head_M",
    ),
    "CAT": Rig(
        "CATRigHub001,CATRigSpine1,CATRigHub002,CATRigSpine2,CATRigHub003",
        with_words("CATRigL", "Leg1,Leg2,LegAnkle,LegDigit11,LegPlatform,ArmCollarbone,Arm1,Arm2,ArmPalm,ArmDigit11"),
        ("RigL", "RigR"),
        with_words("CATRigL", "Leg1,Leg2,LegAnkle") + ",-," + with_words("CATRigL", "Arm1,Arm2,ArmPalm") + ",-,-",
    ),
    "mGear": Rig(
        "root_C0_0_jnt,spine_C0_01_jnt,neck_C0_neck_jnt,neck_C0_head_jnt",
        "leg_L0_upleg_jnt,leg_L0_lowleg_jnt,leg_L0_foot_jnt,foot_L0_ball_jnt,shoulder_L0_shoulder_jnt,"
        "arm_L0_upperarm_jnt,arm_L0_lowerarm_jnt,arm_L0_hand_jnt,ik_foot_L0_0_jnt,ik_hand_L0_0_jnt",
        ("_L0", "_R0"),
        "leg_L0_upleg_jnt,leg_L0_lowleg_jnt,leg_L0_foot_jnt,foot_L0_ball_jnt,arm_L0_upperarm_jnt,arm_L0_lowerarm_jnt,"
        "arm_L0_hand_jnt,neck_C0_neck_jnt,neck_C0_head_jnt",
    ),
    "Second Life": Rig(
        "mPelvis,mTorso,mChest,mNeck,mHead,mSkull",
        "mHipLeft,mKneeLeft,mAnkleLeft,mFootLeft,mToeLeft,mCollarLeft,mShoulderLeft,mElbowLeft,mWristLeft,mHandIndex1Left",
        LEFT,
        "mHipLeft,mKneeLeft,mAnkleLeft,mToeLeft,mShoulderLeft,mElbowLeft,mWristLeft,mNeck,mHead",
    ),
    "upper and lower after the limb": Rig(
        "Hips,Spine,Neck,Head",
        "LegUpper.L,LegLower.L,Foot.L,ArmUpper.L,ArmLower.L,Hand.L,Hand_IK.L,Foot_IK.L",
        (".L", ".R"),
        "LegUpper.L,LegLower.L,Foot.L,-,ArmUpper.L,ArmLower.L,Hand.L,Neck,Head",
    ),
    "a studio with short sides": Rig(
        "spine_jnt,neck_jnt,head_jnt",
        "lt_thigh_jnt,lt_shin_jnt,lt_foot_jnt,lt_shoulder_jnt,lt_bicep_jnt,lt_forearm_jnt,lt_hand_jnt,lt_foot_ctrl",
        ("lt", "rt"),
        "lt_thigh_jnt,lt_shin_jnt,lt_foot_jnt,-,lt_bicep_jnt,lt_forearm_jnt,lt_hand_jnt,neck_jnt,head_jnt",
    ),
    "Quaternius": Rig(
        "Body,Hips,Abdomen,Torso,Neck,Head,Bone",
        "UpperLeg.L,LowerLeg.L,Foot.L,Shoulder.L,UpperArm.L,LowerArm.L,Palm1.L,PoleTarget.L",
        (".L", ".R"),
        "UpperLeg.L,LowerLeg.L,Foot.L,-,UpperArm.L,LowerArm.L,Palm1.L,Neck,Head",
    ),
    "Synty": Rig(
        "Root,Hips,Spine_01,Spine_02,Spine_03,Neck,Head,Prop_L,Prop_R",
        "UpperLeg_L,LowerLeg_L,Ankle_L,Ball_L,Toes_L,Clavicle_L,Shoulder_L,Elbow_L,Hand_L,Thumb_01_L",
        ("_L", "_R"),
        "UpperLeg_L,LowerLeg_L,Ankle_L,Ball_L,Shoulder_L,Elbow_L,Hand_L,Neck,Head",
    ),
    "MMD in English": Rig(
        "Hips,Spine,Chest,Neck,Head",
        "Left leg,Left knee,Left ankle,Left toe,Left shoulder,Left arm,Left elbow,Left wrist,Thumb0_L",
        LEFT,
        "Left leg,Left knee,Left ankle,Left toe,Left arm,Left elbow,Left wrist,Neck,Head",
    ),
    "MMD": Rig(
        "センター,上半身,下半身,首,頭",
        "左足,左ひざ,左足首,左つま先,左足ＩＫ,左つま先ＩＫ,左足D,左肩,左腕,左腕捩,左ひじ,左手捩,左手首,左親指０",
        ("左", "右"),
        "左足,左ひざ,左足首,左つま先,左腕,左ひじ,左手首,首,頭",
    ),
}
