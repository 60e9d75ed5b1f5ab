"""Writes a clip as a VRM animation (VRMC_vrm_animation 1.0), which plays on any VRM character."""

from __future__ import annotations

from typing import Any

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import RoleError
from motionsplice.motion.formats.gltf.document import ASSET, Binary, Document, glb
from motionsplice.motion.formats.gltf.humanoid import ROLES
from motionsplice.motion.formats.gltf.t_pose import t_pose
from motionsplice.motion.hand_joints import finger_places, fingers_of
from motionsplice.motion.kinematics import local_rotations, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import SIDES, Roles, common_ancestor
from motionsplice.motion.skeleton import Skeleton

EXTENSION, SPECIFICATION = "VRMC_vrm_animation", "1.0"
TRUNK = {1: ("spine",), 2: ("spine", "chest"), 3: ("spine", "chest", "upperChest")}
FINGERS = {"thumb": "Thumb", "index": "Index", "middle": "Middle", "ring": "Ring", "pinky": "Little"}
PHALANGES = ("Proximal", "Intermediate", "Distal")
THUMB = ("Metacarpal", "Proximal", "Distal")
SOLE = 0.15  # metres: the lowest joint of a foot on the floor is not higher than this


def dump_vrma(clip: Clip, roles: Roles) -> bytes:
    """Writes a clip as a VRM animation, .vrma: the turns of the bones of a person from a T-pose, and the hips' path.

    The file's nodes are the joints that VRM has a bone for, under their own names; the turns of the other joints are
    part of the next bone's below. At rest the nodes stand in the T-pose, whatever the clip's bind pose is, so that a
    receiver may put the same turns on a character of its own.

    Args:
        clip: The motion.
        roles: The roles of its joints. A head is required.

    Returns:
        The contents of the file.

    Raises:
        RoleError: The rig has no head.
    """
    bones = vrm_bones(clip.skeleton, roles)
    joints = sorted(bones)  # parent before child
    straight = t_pose(clip, roles)
    positions, world = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
    turns = quaternion.multiply(world, quaternion.conjugate(straight))
    rest = _rest(clip.skeleton, straight, positions)
    nodes: list[dict[str, Any]] = [{"name": clip.skeleton.names[0], "translation": rest[0].tolist()}]
    keys = {0: turns[:, 0]}
    for node, joint in enumerate(joints[1:], 1):
        above = next(bone for bone in clip.skeleton.chain(joint)[1:] if bone in bones)
        nodes.append({"name": clip.skeleton.names[joint], "translation": (rest[joint] - rest[above]).tolist()})
        nodes[joints.index(above)].setdefault("children", []).append(node)
        keys[node] = quaternion.multiply(quaternion.conjugate(turns[:, above]), turns[:, joint])
    human = {bones[joint]: {"node": node} for node, joint in enumerate(joints)}
    document: Document = {
        "asset": ASSET,
        "extensionsUsed": [EXTENSION],
        "extensions": {EXTENSION: {"specVersion": SPECIFICATION, "humanoid": {"humanBones": human}}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
    }
    binary = Binary(document)
    document["animations"] = [binary.animation(clip.name, clip.rate, {0: clip.root_positions}, keys)]
    return glb(document, binary.data)


def vrm_bones(skeleton: Skeleton, roles: Roles) -> dict[int, str]:
    """Returns VRM's bone of each joint that has one. Of a long spine, three joints do. Raises RoleError."""
    if roles.head < 0:
        raise RoleError(
            "a VRM animation needs a head, but no joint has this role",
            mend="Name the head in a roles file and pass it as --roles, or write another format",
        )
    bones = {roles.root: "hips"}
    trunk = [roles.pelvis, *roles.spine]
    if len(trunk) > len(TRUNK):
        trunk = [trunk[0], trunk[len(trunk) // 2], trunk[-1]]
    bones |= dict(zip(trunk, TRUNK[len(trunk)], strict=True))
    chest = common_ancestor(skeleton.parents, (roles.left_shoulder, roles.right_shoulder))
    for side in SIDES:
        collar = int(skeleton.parents[getattr(roles, f"{side}_shoulder")])
        if collar != chest:
            bones[collar] = f"{side}Shoulder"
        for joint, (finger, place) in finger_places(skeleton, fingers_of(skeleton, roles, side)).items():
            phalanges = THUMB if finger == "thumb" else PHALANGES
            if 1 <= place <= len(phalanges):
                bones[joint] = f"{side}{FINGERS[finger]}{phalanges[place - 1]}"
    return bones | {joint: bone for bone, role in ROLES.items() if (joint := int(getattr(roles, role))) >= 0}


def _rest(skeleton: Skeleton, straight: Floats, positions: Floats) -> Floats:
    """Returns the positions [J, 3] in the T-pose, above the origin, with the soles on the floor.

    Receivers scale the hips' path by the height of their own hips over that of these. How far the lowest joint is from
    the sole is taken from the motion.
    """
    places = world_transforms(skeleton, np.zeros((1, 3)), local_rotations(skeleton, straight)[None])[0][0]
    lowest = float(positions[..., 1].min())
    places[:, 1] += (lowest if 0.0 < lowest < SOLE else 0.0) - places[:, 1].min()
    return places
