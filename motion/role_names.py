"""The joint names of the common rigs, and roles found by them."""

from __future__ import annotations

import re

# A joint's name without prefixes, separators and the side, in order of preference.
#                Mixamo, LAFAN1  Unreal            VRM, Bandai     Rigify       CMU (ASF)     others
NAMES = {
    "hip":      ("upleg",        "thigh",          "upperleg",                  "femur",      "hip"),
    "knee":     ("leg",          "calf",           "lowerleg",     "shin",      "tibia",      "knee"),
    "ankle":    ("ankle",        "foot"),  # SMPL has both; its "foot" is the ball
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
    """Returns a joint's side ("left", "right" or "") and the rest of its name, in lower case without separators.

    "mixamorig:LeftUpLeg" gives ("left", "upleg"), "DEF-thigh.L" ("left", "thigh"), "lfemur" ("left", "femur").
    """
    words = [word.lower() for word in WORD.findall(PREFIX.sub("", NAMESPACE.sub("", name)))]
    sides = [SIDES[word] for word in words if word in SIDES]
    part = "".join(word for word in words if word not in SIDES)
    if not sides and part[:1] in SIDES and any(part[1:] in names for names in NAMES.values()):
        return SIDES[part[0]], part[1:]  # CMU's lfemur, rhumerus
    return (sides[0] if sides else ""), part


def roles_by_name(names: tuple[str, ...]) -> dict[str, int]:
    """Returns the joints of the limbs, neck and head that are found by name alone, by role."""
    parts: dict[tuple[str, str], int] = {}
    for joint, name in enumerate(names):
        parts.setdefault(side_and_part(name), joint)
    found: dict[str, int] = {}
    for role, candidates in NAMES.items():
        sides = ("left", "right") if role in PAIRED else ("",)
        # Both sides use the same candidate, the first that either side has. Otherwise, if one arm had an unknown name,
        # the collar bone on its side, which some rigs call "shoulder", would be taken instead.
        matches = [[side for side in sides if (side, part) in parts] for part in candidates]
        best = next(filter(None, matches), [])
        for side in best:
            found[f"{side}_{role}" if side else role] = parts[side, candidates[matches.index(best)]]
    return found
