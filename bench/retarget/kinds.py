"""Kinds of rigs that games use: names, spines, bind poses and proportions like those of the real ones."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from bench.retarget.rigs import TRUNK, Kind
from motionsplice.motion import quaternion
from motionsplice.motion.quaternion import Floats

X, Y, Z = np.eye(3)
LEG = re.compile(r"(UpLeg|Leg)$")
FOOT = re.compile(r"(Foot|ToeBase)$")
ARM = re.compile(r"Arm|Hand")
COLLAR_AND_ARM = re.compile(r"Shoulder|Arm|Hand")
FINGER = re.compile(r"Hand([A-Z][a-z]+)(\d)")


def _t_pose(joint: str) -> Floats:
    return quaternion.IDENTITY


def _facing_back(joint: str) -> Floats:
    """A T-pose that faces -Z, as in VRM 0.x."""
    return quaternion.about(Y, np.pi)


def _a_pose(arms: float, palms: float, legs: float) -> Callable[[str], Floats]:
    """Arms lowered, palms rolled towards the body and legs spread, all in degrees. The feet stay flat."""

    def bind(joint: str) -> Floats:
        side = 1.0 if joint.startswith("Left") else -1.0
        if LEG.search(joint):
            return quaternion.about(Z, side * np.radians(legs))
        if not ARM.search(joint):
            return quaternion.IDENTITY
        lowered = quaternion.about(Z, -side * np.radians(arms))
        rolled = quaternion.about(X, side * np.radians(palms))
        return quaternion.multiply(lowered, rolled) if "Hand" in joint else lowered

    return bind


def _along_x(joint: str) -> Floats:
    """All bones along X, as in LAFAN1's files: no pose of a body."""
    trunk = quaternion.about(Z, -0.5 * np.pi)  # up along X, left along -Y
    if LEG.search(joint):
        return quaternion.multiply(trunk, quaternion.about(X, np.pi))
    if FOOT.search(joint):
        return quaternion.multiply(trunk, quaternion.about(X, 1.5 * np.pi))
    if COLLAR_AND_ARM.search(joint):
        return quaternion.IDENTITY if joint.startswith("Left") else quaternion.about(Y, np.pi)
    return trunk


def _named(known: Mapping[str, str], parts: str, form: str, finger_form: str) -> Callable[[str], str]:
    """Returns a function that names joints.

    known: names of joints without a side. parts: names of collar, arm, forearm, hand, thigh, shin, foot and toe. form,
    finger_form: the name of a part and of a finger, with {side} as l, {Side} as L.
    """
    builtin = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
    by_part = dict(zip(builtin, parts.split(), strict=True))

    def name(joint: str) -> str:
        if joint in known:
            return known[joint]
        side, part = re.fullmatch("(Left|Right)(.*)", joint).groups()  # type: ignore[union-attr]
        letters = {"side": side[0].lower(), "Side": side[0]}
        if finger := FINGER.fullmatch(part):
            return finger_form.format(finger=finger[1].lower(), Finger=finger[1], number=finger[2], **letters)
        return form.format(part=by_part[part], **letters)

    return name


def _without_fingers(joint: str) -> str:
    return "" if FINGER.search(joint) else joint


def _both(names: Mapping[str, str]) -> dict[str, str]:
    """Returns names by joint for both sides; {Side} in a name is L or R."""
    sides = (("Left", "L"), ("Right", "R"))
    return {word + joint: name.format(Side=letter) for word, letter in sides for joint, name in names.items()}


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "built-in": Kind(lambda joint: joint, TRUNK, _t_pose),
        "Mixamo": Kind(
            lambda joint: f"mixamorig:{joint}",
            tuple(f"mixamorig:{name}" for name in TRUNK),
            _t_pose,
            sizes={"Leg": 1.06, "ForeArm": 0.92, "Hand": 0.95, "Shoulder": 1.1},
        ),
        "Rigify": Kind(
            _named(
                {"Hips": "DEF-spine", "Neck": "DEF-neck", "Head": "DEF-head"},
                "shoulder upper_arm forearm hand thigh shin foot toe",
                "DEF-{part}.{Side}",
                "DEF-f_{finger}.0{number}.{Side}",
            ),
            ("DEF-spine.001", "DEF-spine.002", "DEF-spine.003"),
            _a_pose(arms=12.0, palms=0.0, legs=3.0),
            between=_both(
                {
                    "ForeArm": "DEF-upper_arm.{Side}.001",
                    "Hand": "DEF-forearm.{Side}.001",
                    "Leg": "DEF-thigh.{Side}.001",
                    "Foot": "DEF-shin.{Side}.001",
                }
            ),
            sizes={"Leg": 0.95, "Foot": 0.97, "ForeArm": 1.03},
        ),
        "VRM": Kind(
            _named(
                {"Hips": "J_Bip_C_Hips", "Neck": "J_Bip_C_Neck", "Head": "J_Bip_C_Head"},
                "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot ToeBase",
                "J_Bip_{Side}_{part}",
                "J_Bip_{Side}_{Finger}{number}",
            ),
            ("J_Bip_C_Spine", "J_Bip_C_Chest", "J_Bip_C_UpperChest"),
            _facing_back,
            sizes={"Leg": 0.8, "Foot": 0.86, "ForeArm": 0.8, "Hand": 0.8, "Neck": 0.9},
        ),
        "Unreal": Kind(
            _named(
                {"Hips": "pelvis", "Neck": "neck_01", "Head": "head"},
                "clavicle upperarm lowerarm hand thigh calf foot ball",
                "{part}_{side}",
                "{finger}_0{number}_{side}",
            ),
            tuple(f"spine_0{number}" for number in range(1, 6)),
            _a_pose(arms=48.0, palms=25.0, legs=4.0),
            sizes={"Leg": 1.02, "Foot": 1.08, "ForeArm": 1.05, "Hand": 1.05},
        ),
        "CMU": Kind(
            _without_fingers,
            ("LowerBack", "Spine", "Spine1"),
            _a_pose(arms=0.0, palms=0.0, legs=20.0),
            between=_both({"UpLeg": "{Side}HipJoint"}),
            sizes={"Leg": 0.93, "Foot": 1.05, "Shoulder": 0.9},
        ),
        "LAFAN1": Kind(_without_fingers, TRUNK, _along_x, sizes={"ForeArm": 1.1}),
    }
)
