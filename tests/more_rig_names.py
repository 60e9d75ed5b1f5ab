"""The joint names of more real rigs: of games, phones and other languages."""

from __future__ import annotations

from tests.rig_names import LEFT, Rig

MORE_RIGS = {
    "Auto-Rig Pro": Rig(
        "root.x,spine_01.x,spine_02.x,spine_03.x,neck.x,head.x",
        "thigh_twist.l,thigh_stretch.l,leg_stretch.l,leg_twist.l,foot.l,toes_01.l,shoulder.l,"
        "arm_stretch.l,arm_twist.l,forearm_stretch.l,forearm_twist.l,hand.l,index1.l",
        (".l", ".r"),
        "thigh_stretch.l,leg_stretch.l,foot.l,toes_01.l,arm_stretch.l,forearm_stretch.l,hand.l,neck.x,head.x",
    ),
    "FromSoftware": Rig(
        "Master,Pelvis,Spine,Spine1,Neck,Head",
        "L_Thigh,L_Calf,L_Foot,L_Toe0,L_Knee,L_Clavicle,L_Shoulder,L_UpperArm,L_UpArmTwist,L_Elbow,"
        "L_Forearm,L_ForeArmTwist,L_Hand,L_Weapon,L_Finger0",
        ("L_", "R_"),
        "L_Thigh,L_Calf,L_Foot,L_Toe0,L_UpperArm,L_Forearm,L_Hand,Neck,Head",
    ),
    "Meta's body tracking": Rig(
        "Root,Hips,SpineLower,SpineMiddle,SpineUpper,Chest,Neck,Head",
        "LeftShoulder,LeftScapula,LeftArmUpper,LeftArmLower,LeftHandWristTwist,LeftHandWrist,"
        "LeftHandPalm,LeftHandThumbMetacarpal,LeftUpperLeg,LeftLowerLeg,LeftFootAnkleTwist,LeftFootAnkle,"
        "LeftFootSubtalar,LeftFootTransverse,LeftFootBall",
        LEFT,
        "LeftUpperLeg,LeftLowerLeg,LeftFootAnkle,LeftFootBall,LeftArmUpper,LeftArmLower,LeftHandWrist,Neck,Head",
    ),
    "ARKit": Rig(
        "root,hips_joint,spine_1_joint,spine_7_joint,neck_1_joint,neck_4_joint,head_joint,jaw_joint",
        "left_upLeg_joint,left_leg_joint,left_foot_joint,left_toes_joint,left_toesEnd_joint,"
        "left_shoulder_1_joint,left_arm_joint,left_forearm_joint,left_hand_joint,left_handIndex_1_joint",
        ("left", "right"),
        "left_upLeg_joint,left_leg_joint,left_foot_joint,left_toes_joint,left_arm_joint,"
        "left_forearm_joint,left_hand_joint,neck_1_joint,head_joint",
    ),
    "XPS": Rig(
        "root ground,root hips,spine lower,spine upper,head neck lower,head neck upper,head jaw",
        "leg left thigh,leg left knee,leg left ankle,leg left toes,arm left shoulder 1,"
        "arm left shoulder 2,arm left elbow,arm left wrist,arm left finger 1a,breast left",
        ("left", "right"),
        "leg left thigh,leg left knee,leg left ankle,leg left toes,arm left shoulder 2,arm left elbow,"
        "arm left wrist,head neck lower,-",
    ),
    "two digits": Rig(
        "root,spine_01,spine_02,neck_01,head_01",
        "leg_01_l,leg_02_l,foot_01_l,toe_01_l,clavicle_01_l,arm_01_l,arm_02_l,hand_01_l",
        ("_l", "_r"),
        "leg_01_l,leg_02_l,foot_01_l,toe_01_l,arm_01_l,arm_02_l,hand_01_l,neck_01,head_01",
    ),
    "Doom 3": Rig(
        "origin,Body,Hips,Waist,Chest,Shoulders,Neck,Head",
        "Lupleg,Lloleg,Lfoot,Ltoe,Lshldr,Luparm,Lloarm,Lhand,Lfingers",
        ("L", "R"),
        "Lupleg,Lloleg,Lfoot,Ltoe,Luparm,Lloarm,Lhand,Neck,Head",
    ),
    "Call of Duty": Rig(
        "tag_origin,j_mainroot,j_spinelower,j_spineupper,j_spine4,j_neck,j_head",
        "j_hip_le,j_hiptwist_le,j_knee_le,j_knee_bulge_le,j_ankle_le,j_ball_le,j_clavicle_le,"
        "j_shoulder_le,j_shouldertwist_le,j_elbow_le,j_elbow_bulge_le,j_wrist_le,j_wristtwist_le,"
        "j_index_le_1",
        ("_le", "_ri"),
        "j_hip_le,j_knee_le,j_ankle_le,j_ball_le,j_shoulder_le,j_elbow_le,j_wrist_le,j_neck,j_head",
    ),
    "lf and rt": Rig(
        "root,spine,neck,head",
        "lf_thigh,lf_shin,lf_foot,lf_toe,lf_clavicle,lf_upperArm,lf_forearm,lf_hand",
        ("lf", "rt"),
        "lf_thigh,lf_shin,lf_foot,lf_toe,lf_upperArm,lf_forearm,lf_hand,neck,head",
    ),
    "Lf and Rt": Rig(
        "bn_Hips,bn_Spine,bn_Neck,bn_Head",
        "bn_LfHip,bn_LfKnee,bn_LfAnkle,bn_LfBall,bn_LfClavicle,bn_LfShoulder,bn_LfElbow,bn_LfWrist",
        ("Lf", "Rt"),
        "bn_LfHip,bn_LfKnee,bn_LfAnkle,bn_LfBall,bn_LfShoulder,bn_LfElbow,bn_LfWrist,bn_Neck,bn_Head",
    ),
    "Chinese": Rig(
        "骨盆,脊椎,胸,脖子,头",
        "左大腿,左小腿,左脚,左脚趾,左肩,左上臂,左前臂,左手",
        ("左", "右"),
        "左大腿,左小腿,左脚,左脚趾,左上臂,左前臂,左手,脖子,头",
    ),
    "Japanese": Rig(
        "腰,背骨,胸,首,頭",
        "左太もも,左すね,左足,左つま先,左肩,左上腕,左前腕,左手",
        ("左", "右"),
        "左太もも,左すね,左足,左つま先,左上腕,左前腕,左手,首,頭",
    ),
    "MMD in Blender": Rig(
        "全ての親,センター,グルーブ,腰,上半身,上半身2,下半身,首,頭,両目",
        "足.L,ひざ.L,足首.L,つま先.L,足ＩＫ.L,足D.L,ひざD.L,足首D.L,足先EX.L,肩P.L,肩.L,肩C.L,腕.L,腕捩.L,ひじ.L,手捩.L,手首.L,親指０.L",
        (".L", ".R"),
        "足.L,ひざ.L,足首.L,つま先.L,腕.L,ひじ.L,手首.L,首,頭",
    ),
    "GTA V": Rig(
        "SKEL_ROOT,SKEL_Pelvis,SKEL_Spine_Root,SKEL_Spine0,SKEL_Spine3,SKEL_Neck_1,SKEL_Head,IK_Head,RB_Neck_1,IK_Root",
        "SKEL_L_Thigh,SKEL_L_Calf,SKEL_L_Foot,SKEL_L_Toe0,SKEL_L_Clavicle,SKEL_L_UpperArm,SKEL_L_Forearm,"
        "SKEL_L_Hand,SKEL_L_Finger00,IK_L_Hand,PH_L_Hand,IK_L_Foot,PH_L_Foot,MH_L_Knee,MH_L_Thigh,"
        "MH_L_Elbow,RB_L_ThighRoll,RB_L_ForeArmRoll,RB_L_ArmRoll",
        ("_L_", "_R_"),
        "SKEL_L_Thigh,SKEL_L_Calf,SKEL_L_Foot,SKEL_L_Toe0,SKEL_L_UpperArm,SKEL_L_Forearm,SKEL_L_Hand,"
        "SKEL_Neck_1,SKEL_Head",
    ),
    "Fallout 4": Rig(
        "Root,COM,Pelvis,SPINE1,SPINE2,Chest,Neck,HEAD",
        "LLeg_Thigh,LLeg_Calf,LLeg_Foot,LLeg_Toe1,LArm_Collarbone,LArm_UpperArm,LArm_UpperTwist1,"
        "LArm_ForeArm1,LArm_ForeArm2,LArm_Hand,LArm_Finger11",
        ("L", "R"),
        "LLeg_Thigh,LLeg_Calf,LLeg_Foot,LLeg_Toe1,LArm_UpperArm,LArm_ForeArm1,LArm_Hand,Neck,HEAD",
    ),
    "Source 2": Rig(
        "root_motion,pelvis,spine_0,spine_1,spine_2,spine_3,neck_0,head_0,weapon_hand",
        "leg_upper_L,leg_lower_L,ankle_L,ball_L,clavicle_L,arm_upper_L,arm_lower_L,hand_L,"
        "arm_upper_L_TWIST,arm_lower_L_TWIST1,leg_upper_L_TWIST,finger_index_0_L",
        ("_L", "_R"),
        "leg_upper_L,leg_lower_L,ankle_L,ball_L,arm_upper_L,arm_lower_L,hand_L,neck_0,head_0",
    ),
    "KayKit": Rig(
        "root,hips,spine,chest,head",
        "upperarm.l,lowerarm.l,wrist.l,hand.l,handslot.l,upperleg.l,lowerleg.l,foot.l,toes.l,kneeIK.l,"
        "control-toe-roll.l,control-foot-roll.l,elbowIK.l,handIK.l",
        (".l", ".r"),
        "upperleg.l,lowerleg.l,foot.l,toes.l,upperarm.l,lowerarm.l,wrist.l,-,head",
    ),
    "hair, skirt and weapons": Rig(
        "Hips,Spine,Chest,Neck,Head,Hair_Head_01,Hair_Neck_01,Weapon_Hand,Tail_Leg",
        "UpperLeg_L,LowerLeg_L,Foot_L,Toes_L,Skirt_UpperLeg_L,Skirt_LowerLeg_L,Shoulder_L,UpperArm_L,"
        "LowerArm_L,Hand_L,Sleeve_UpperArm_L,Sleeve_LowerArm_L,Sleeve_Hand_L,Weapon_Hand_L,Hair_Arm_L",
        ("_L", "_R"),
        "UpperLeg_L,LowerLeg_L,Foot_L,Toes_L,UpperArm_L,LowerArm_L,Hand_L,Neck,Head",
    ),
    "SOMA": Rig(
        "Root,Hips,Spine1,Spine2,Chest,Neck1,Neck2,Head",
        "LeftShoulder,LeftArm,LeftForeArm,LeftHand,LeftLeg,LeftShin,LeftFoot,LeftToeBase,LeftHandThumb1",
        LEFT,
        "LeftLeg,LeftShin,LeftFoot,LeftToeBase,LeftArm,LeftForeArm,LeftHand,Neck1,Head",
    ),
}
