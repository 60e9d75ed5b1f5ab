"""The joint names of the common rigs, and roles found by them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import product
from types import MappingProxyType

# The name of a part of the body, without the side and what all joints of a rig share, in order of preference.
#                Mixamo, LAFAN1  Unreal      VRM, Unity   Poser       Daz            CAT     others
NAMES = {
    "hip":      ("upleg",        "thigh",    "upperleg",              "thighbend",   "leg1",
                 "legupper", "femur", "hip", "大腿", "太もも", "足", "leg"),
    "knee":     ("leg",          "calf",     "lowerleg",  "shin",     "shinbend",    "leg2",
                 "lowleg", "loleg", "leglower", "shank", "tibia", "knee", "ひざ", "膝", "小腿", "すね"),
    "ankle":    ("ankle",        "foot",     "足首", "脚", "足"),  # SMPL has both; its "foot" is the ball
    "toe":      ("toebase",      "ball",     "toes",      "toe",      "つま先", "脚趾"),
    "shoulder": ("arm",          "upperarm", "uparm",     "shldr",    "shldrbend",   "arm1",
                 "uarm", "armupper", "bicep", "humerus", "shoulder2", "shoulder", "上臂", "上腕", "腕"),
    "elbow":    ("forearm",      "lowerarm",                          "forearmbend", "arm2",
                 "lowarm", "loarm", "farm", "armlower", "radius", "ulna", "elbow", "ひじ", "肘", "前臂", "前腕"),
    "wrist":    ("wrist",        "hand",                                             "palm",
                 "手首", "手"),
    "neck":     ("neck",                                              "necklower",   "necktwist",
                 "lowerneck", "首", "脖子"),
    "head":     ("head",         "頭", "头"),
}  # fmt: skip
PAIRED = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist")
OPTIONAL = ("left_toe", "right_toe", "neck", "head")

NAMESPACE = re.compile(r"^.*[:|]|\[[^\[\]]*\]")  # "mixamorig:", and Skyrim's "NPC L Thigh [LThg]"
WORD = re.compile(r"[LR](?=[A-Z]{1,2}[a-z])|[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|左|右|[^\W\d_A-Za-z左右]+")
LEFT, RIGHT = ("left", "le", "lf", "lt", "lft", "l", "左"), ("right", "ri", "rt", "rgt", "r", "右")
SIDES = dict.fromkeys(LEFT, "left") | dict.fromkeys(RIGHT, "right")
WITHOUT_MEANING = ("c", "m", "x", "stretch")  # J_Bip_C_Head of VRoid, head.x and arm_stretch.l of Auto-Rig Pro
LIMB_WORDS = (
    "arm",
    "leg",
    "hand",
    "foot",
    "head",
    "neck",
)  # CAT's LLegAnkle, mGear's arm_L0_hand_jnt, XPS' head neck
MOST_WORDS = 20  # in a name; longer ones are not names of joints
HELPERS = {"ik", "fk", "mch", "ctrl", "pole", "target", "twist", "roll"}  # joints by which others are posed

Affixes = tuple[tuple[str, ...], tuple[str, ...]]  # the words before and after the part of the body
Part = tuple[str, str]  # side ("left", "right" or "") and one of NAMES

KNOWN = {name for names in NAMES.values() for name in names}
PARTS: dict[str, Part] = {  # with names like "lfemur" and "leftupleg", in which no capital parts side and part;
    # of "lf" and "arm" or "l" and "farm", the latter
    text: (side, name)
    for word, side in SIDES.items()
    for name in KNOWN
    for text in (word + name, name + word)
} | {name: ("", name) for name in KNOWN}
BEGINNINGS = {text[:length] for text in PARTS for length in range(1, len(text) + 1)}


@lru_cache(maxsize=16)  # the clips of a bank are of few rigs
def roles_by_name(names: tuple[str, ...]) -> Mapping[str, int]:
    """Returns the joints of the limbs, neck and head that are found by name alone, by role.

    All joints of a body have the same words around the part: none, or "Bip01", "CC_Base", "m_avg", "_jnt". So the roles
    are those of the words with which most are found. Joints beside the body, such as "ik_foot_l" and "thigh_twist_l",
    have others.
    """
    matches = [
        (numbered, joint, affixes, part)
        for joint, name in enumerate(names)
        for affixes, part, numbered in parts_in(name)
    ]
    bodies: dict[Affixes, dict[Part, int]] = {}
    for _, joint, affixes, part in sorted(matches):  # "thigh.L" goes before "thigh.L.001"
        bodies.setdefault(affixes, {}).setdefault(part, joint)
    found = [(affixes, _roles(_numbered(parts))) for affixes, parts in bodies.items()]
    return MappingProxyType(max(found, key=lambda one: _rank(*one), default=(((), ()), {}))[1])


def words_of(name: str) -> tuple[list[str], str]:
    """Returns the words of a joint's name in lower case, without the side, and the side ("left", "right" or "")."""
    words = [word.lower().lstrip("0") or "0" for word in WORD.findall(NAMESPACE.sub("", name))]
    sides = [SIDES[word] for word in words if word in SIDES]
    return [word for word in words if word not in SIDES and word not in WITHOUT_MEANING], sides[0] if sides else ""


def parts_in(name: str) -> Iterator[tuple[Affixes, Part, bool]]:
    """Yields what a joint may be by its name: the words around the part, the part, and whether a number follows it.

    "LeftForeArm" is the left "forearm", or the left "arm" after "fore"; "DEF-thigh.L.001" is the left "thigh" after
    "def", with a number.
    """
    words, side = words_of(name)
    if len(words) > MOST_WORDS:
        return
    for start in range(len(words)):
        text = ""
        for stop in range(start + 1, len(words) + 1):
            text += words[stop - 1]
            if text not in BEGINNINGS:
                break
            own, part = PARTS.get(text, ("", ""))
            if not part or (own and side) or (words[stop:] and text + words[stop] in KNOWN):  # CAT's "leg1" is no "leg"
                continue
            before = tuple(word for word in words[:start] if not (word.isdecimal() or word in LIMB_WORDS))
            after = tuple(word for word in words[stop:] if not word.isdecimal())
            yield (before, after), (side or own, part), len(after) < len(words) - stop


def _numbered(parts: Mapping[Part, int]) -> dict[Part, int]:
    """Returns the parts, with "leg1" or "leg2" as a "leg" if the rig does not have both: it numbers all its joints."""
    alone = {
        (side, f"{limb}{own}"): (side, limb)
        for side, limb, own, other in product(("left", "right"), ("arm", "leg"), "12", "12")
        if own != other and (side, f"{limb}{other}") not in parts
    }
    found = {part: joint for part, joint in parts.items() if part not in alone}
    for part, plain in alone.items():
        if part in parts:
            found.setdefault(plain, parts[part])
    return found


def _roles(parts: Mapping[Part, int]) -> dict[str, int]:
    found: dict[str, int] = {}
    taken: set[str] = set()
    for role, candidates in NAMES.items():
        sides = ("left", "right") if role in PAIRED else ("",)
        # Both sides use the same candidate, the first that either side has. Otherwise, if one arm had an unknown name,
        # the collar bone on its side, which some rigs call "shoulder", would be taken instead.
        for part in candidates:
            matches = [side for side in sides if (side, part) in parts]
            if matches and part not in taken:  # a leg with a knee is the thigh
                taken.add(part)
                found |= {f"{side}_{role}" if side else role: parts[side, part] for side in matches}
                break
    return found


def _rank(affixes: Affixes, roles: Mapping[str, int]) -> tuple[bool, int, int]:
    words = affixes[0] + affixes[1]
    return HELPERS.isdisjoint(words), len(roles), -len(words)
