"""The names by which rigs call their joints."""

from __future__ import annotations

import re

# What is left of a joint's name once prefixes, separators and the side are taken off, in order of preference.
#                Mixamo, LAFAN1  Unreal            VRM, Bandai     Rigify       CMU (ASF)     others
NAMES = {
    "hip":      ("upleg",        "thigh",          "upperleg",                  "femur",      "hip"),
    "knee":     ("leg",          "calf",           "lowerleg",     "shin",      "tibia",      "knee"),
    "ankle":    ("ankle",        "foot"),  # SMPL has both, and its foot is the ball
    "toe":      ("toebase",      "ball",           "toes",         "toe"),
    "shoulder": ("arm",          "upperarm",                                    "humerus",    "shoulder"),
    "elbow":    ("forearm",      "lowerarm",                                    "radius",     "elbow"),
    "wrist":    ("wrist",        "hand"),
    "neck":     ("neck",         "neck01",                                      "lowerneck"),
    "head":     ("head",),
}  # fmt: skip
PAIRED = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist")
OPTIONAL = ("left_toe", "right_toe", "neck", "head")

NAMESPACE = re.compile(r"^.*[:|]")
PREFIX = re.compile(r"^(mixamorig\d*[-_ .]*|(DEF|ORG|MCH|J_Bip|Bip\d*|CC_Base|joint)[-_ .]+)", re.IGNORECASE)
SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")


def side_and_part(name: str) -> tuple[str, str]:
    """A joint's side ("left", "right" or "") and the rest of its name, in small letters without separators.

    "mixamorig:LeftUpLeg", "DEF-thigh.L", "J_Bip_L_UpperLeg", "thigh_l" and "lfemur" are all some left hip.
    """
    words = [word.lower() for word in WORD.findall(PREFIX.sub("", NAMESPACE.sub("", name)))]
    sides = [SIDES[word] for word in words if word in SIDES]
    part = "".join(word for word in words if word not in SIDES)
    if not sides and part[:1] in SIDES and any(part[1:] in names for names in NAMES.values()):
        return SIDES[part[0]], part[1:]  # CMU's lfemur, rhumerus
    return (sides[0] if sides else ""), part


def roles_by_name(names: tuple[str, ...]) -> dict[str, int]:
    """The joint of each role that names alone can tell: limbs, neck and head."""
    parts: dict[tuple[str, str], int] = {}
    for joint, name in enumerate(names):
        parts.setdefault(side_and_part(name), joint)
    found: dict[str, int] = {}
    for role, candidates in NAMES.items():
        sides = ("left", "right") if role in PAIRED else ("",)
        # The first name that either side has counts for both: if one arm is called oddly, it is not its collar bone.
        known = [[side for side in sides if (side, part) in parts] for part in candidates]
        best = next(filter(None, known), [])
        for side in best:
            found[f"{side}_{role}" if side else role] = parts[side, candidates[known.index(best)]]
    return found
