"""The built-in motions on rigs like those of the field: with their names, spines, bind poses and proportions.

The built-in joints' world rotations are the truth on each rig, so a retargeted clip can be compared with it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton

X, Y, Z = np.eye(3)
NOTHING: Mapping[str, str] = MappingProxyType({})
Turn = Callable[[str], Floats]


@dataclass(frozen=True)
class Kind:
    """A kind of rig, as it differs from the built-in one.

    name: of a joint, from its built-in name; an empty name leaves the joint and those below it out. trunk: names of
    the joints from the pelvis to the chest. between: names of extra bones in the middle of a bone, by the built-in
    name of the joint at its end. sizes: lengths of bones by the built-in name without its side, relative to the
    built-in rig. bind: world rotation of a joint in the bind pose, relative to the built-in T-pose.
    """

    name: Callable[[str], str]
    trunk: tuple[str, ...]
    bind: Turn
    between: Mapping[str, str] = field(default_factory=dict)
    sizes: Mapping[str, float] = field(default_factory=dict)


def on_rig(clip: Clip, kind: Kind) -> Clip:
    """Returns a built-in clip on a rig of another kind."""
    clip = with_fingers(clip)
    at, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    names, sources, parents, offsets = list[str](), list[int](), list[int](), list[Floats]()
    places: dict[int, int] = {}
    rig = clip.skeleton
    trunk = [rig.index(name) for name in ("Spine", "Spine1", "Spine2")]

    def add(name: str, source: int, parent: int, offset: Floats) -> None:
        names.append(name)
        sources.append(source)
        parents.append(parent)
        offsets.append(offset)

    for joint, builtin in enumerate(rig.names):
        parent = int(rig.parents[joint])
        size = kind.sizes.get(re.sub("^(Left|Right)", "", builtin), 1.0)
        if joint in trunk:
            if joint == trunk[0]:
                above = rig.offsets[trunk[0]] * size
                length = rig.offsets[trunk[1:]].sum(axis=0) * size / max(len(kind.trunk) - 1, 1)
                for number, name in enumerate(kind.trunk):
                    part = number / max(len(kind.trunk) - 1, 1)
                    source = trunk[min(int(2.0 * part + 0.5), 2)]
                    add(name, source, len(names) - 1 if number else 0, length if number else above)
            places[joint] = len(names) - 1 if joint == trunk[2] else -2
            continue
        name = kind.name(builtin)
        if not name or (parent >= 0 and parent not in places):
            continue
        offset, above = rig.offsets[joint] * size, places[parent] if parent >= 0 else -1
        if builtin in kind.between:
            add(kind.between[builtin], parent, above, 0.5 * offset)
            offset, above = 0.5 * offset, len(names) - 1
        add(name, joint, above, offset if parent >= 0 else np.zeros(3))
        places[joint] = len(names) - 1
    binds = np.array([kind.bind(rig.names[source]) for source in sources])
    turned = quaternion.multiply(world[:, sources], quaternion.conjugate(binds))
    rotations = turned.copy()
    rotations[:, 1:] = quaternion.multiply(quaternion.conjugate(turned[:, parents[1:]]), turned[:, 1:])
    ends = [end for end, joint in enumerate(rig.end_parents) if places.get(int(joint), -2) >= 0]
    end_parents = np.array([places[int(rig.end_parents[end])] for end in ends])
    skeleton = Skeleton(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.array(
            [quaternion.rotate(binds[max(parent, 0)], offset) for parent, offset in zip(parents, offsets, strict=True)]
        ),
        end_parents=end_parents,
        end_offsets=quaternion.rotate(binds[end_parents], rig.end_offsets[ends]),
    )
    return Clip(clip.name, skeleton, clip.rate, at[:, 0] * _leg(kind), quaternion.one_hemisphere(rotations))


def _leg(kind: Kind) -> float:
    return 0.5 * (kind.sizes.get("Leg", 1.0) + kind.sizes.get("Foot", 1.0))


def _t_pose(joint: str) -> Floats:
    return quaternion.IDENTITY


def _a_pose(arms: float, palms: float, legs: float) -> Turn:
    """Arms lowered and palms rolled to the body, legs spread, all in degrees; feet stay flat."""

    def turn(joint: str) -> Floats:
        side = 1.0 if joint.startswith("Left") else -1.0
        if "UpLeg" in joint or joint.endswith("Leg"):
            return quaternion.about(Z, side * np.radians(legs))
        if joint.endswith(("Foot", "ToeBase")) or ("Arm" not in joint and "Hand" not in joint):
            return quaternion.IDENTITY
        lowered = quaternion.about(Z, -side * np.radians(arms))
        return (
            quaternion.multiply(lowered, quaternion.about(X, side * np.radians(palms))) if "Hand" in joint else lowered
        )

    return turn


def _backwards(joint: str) -> Floats:
    return quaternion.about(Y, np.pi)


def _along_x(joint: str) -> Floats:
    """All bones along X, as in the BVH files of LAFAN1: the trunk as it stands, legs folded up, arms raised."""
    stands = quaternion.about(Z, -0.5 * np.pi)  # up to +X, left to -Y
    if "UpLeg" in joint or joint.endswith(("Leg", "Foot", "ToeBase")):
        folded = quaternion.about(X, np.pi)
        if joint.endswith(("Foot", "ToeBase")):
            folded = quaternion.multiply(folded, quaternion.about(X, 0.5 * np.pi))
        return quaternion.multiply(stands, folded)
    if "Arm" in joint or "Hand" in joint:
        return quaternion.IDENTITY if joint.startswith("Left") else quaternion.about(Y, np.pi)
    return stands


def _unreal(joint: str) -> str:
    known = {"Hips": "pelvis", "Neck": "neck_01", "Head": "head"}
    parts = {
        "Shoulder": "clavicle",
        "Arm": "upperarm",
        "ForeArm": "lowerarm",
        "Hand": "hand",
        "UpLeg": "thigh",
        "Leg": "calf",
    }
    parts |= {"Foot": "foot", "ToeBase": "ball"}
    return known.get(joint) or _sided(joint, parts, "{part}_{side}", "{finger}_0{number}_{side}")


def _rigify(joint: str) -> str:
    known = {"Hips": "DEF-spine", "Neck": "DEF-neck", "Head": "DEF-head"}
    parts = {
        "Shoulder": "shoulder",
        "Arm": "upper_arm",
        "ForeArm": "forearm",
        "Hand": "hand",
        "UpLeg": "thigh",
        "Leg": "shin",
    }
    parts |= {"Foot": "foot", "ToeBase": "toe"}
    return known.get(joint) or _sided(joint, parts, "DEF-{part}.{Side}", "DEF-f_{finger}.0{number}.{Side}")


def _vrm(joint: str) -> str:
    known = {"Hips": "J_Bip_C_Hips", "Neck": "J_Bip_C_Neck", "Head": "J_Bip_C_Head"}
    parts = {"Shoulder": "Shoulder", "Arm": "UpperArm", "ForeArm": "LowerArm", "Hand": "Hand", "UpLeg": "UpperLeg"}
    parts |= {"Leg": "LowerLeg", "Foot": "Foot", "ToeBase": "ToeBase"}
    return known.get(joint) or _sided(joint, parts, "J_Bip_{Side}_{part}", "J_Bip_{Side}_{Finger}{number}")


def _sided(joint: str, parts: Mapping[str, str], form: str, finger_form: str) -> str:
    side, part = ("Left", joint[4:]) if joint.startswith("Left") else ("Right", joint[5:])
    letters = {"side": side[0].lower(), "Side": side[0]}
    if finger := re.fullmatch(r"Hand([A-Z][a-z]+)(\d)", part):
        return finger_form.format(finger=finger[1].lower(), Finger=finger[1], number=finger[2], **letters)
    return form.format(part=parts[part], **letters)


def _without_fingers(joint: str) -> str:
    return "" if re.search(r"Hand[A-Z]", joint) else joint


def _sides(names: Mapping[str, str]) -> dict[str, str]:
    return {
        f"{side}{joint}": name.format(side=side, S=side[0], s=side[0].lower())
        for joint, name in names.items()
        for side in ("Left", "Right")
    }


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "built-in": Kind(lambda joint: joint, ("Spine", "Spine1", "Spine2"), _t_pose),
        "Mixamo": Kind(
            lambda joint: f"mixamorig:{joint}",
            ("mixamorig:Spine", "mixamorig:Spine1", "mixamorig:Spine2"),
            _t_pose,
            sizes={"Leg": 1.06, "Foot": 1.0, "ForeArm": 0.92, "Hand": 0.95, "Shoulder": 1.1},
        ),
        "Rigify": Kind(
            _rigify,
            ("DEF-spine.001", "DEF-spine.002", "DEF-spine.003"),
            _a_pose(12.0, 0.0, 3.0),
            between=_sides(
                {
                    "ForeArm": "DEF-upper_arm.{S}.001",
                    "Hand": "DEF-forearm.{S}.001",
                    "Leg": "DEF-thigh.{S}.001",
                    "Foot": "DEF-shin.{S}.001",
                }
            ),
            sizes={"Leg": 0.95, "Foot": 0.97, "ForeArm": 1.03},
        ),
        "VRM": Kind(
            _vrm,
            ("J_Bip_C_Spine", "J_Bip_C_Chest", "J_Bip_C_UpperChest"),
            _backwards,
            sizes={"Leg": 0.8, "Foot": 0.86, "ForeArm": 0.8, "Hand": 0.8, "Neck": 0.9},
        ),
        "Unreal": Kind(
            _unreal,
            ("spine_01", "spine_02", "spine_03", "spine_04", "spine_05"),
            _a_pose(48.0, 25.0, 4.0),
            sizes={"Leg": 1.02, "Foot": 1.08, "ForeArm": 1.05, "Hand": 1.05},
        ),
        "CMU": Kind(
            _without_fingers,
            ("LowerBack", "Spine", "Spine1"),
            _a_pose(0.0, 0.0, 20.0),
            between={"LeftUpLeg": "LHipJoint", "RightUpLeg": "RHipJoint"},
            sizes={"Leg": 0.93, "Foot": 1.05, "Shoulder": 0.9},
        ),
        "LAFAN1": Kind(
            _without_fingers, ("Spine", "Spine1", "Spine2"), _along_x, sizes={"Leg": 1.0, "Foot": 1.0, "ForeArm": 1.1}
        ),
    }
)
