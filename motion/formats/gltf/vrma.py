"""Writes a clip as a VRM animation (VRMC_vrm_animation 1.0), which plays on any VRM character."""

from __future__ import annotations

from typing import Any

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import RoleError
from motionsplice.motion.formats.gltf.document import ASSET, Binary, Document, glb
from motionsplice.motion.formats.gltf.humanoid_pose import Humanoid
from motionsplice.motion.formats.gltf.t_pose import t_pose
from motionsplice.motion.kinematics import joint_positions, local_rotations, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton

EXTENSION, SPECIFICATION = "VRMC_vrm_animation", "1.0"
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
    if roles.head < 0:
        raise RoleError(
            "a VRM animation needs a head, but no joint has this role",
            mend="Name the head in a roles file and pass it as --roles, or write another format",
        )
    straight = t_pose(clip, roles)
    person = Humanoid(clip.skeleton, roles, straight)
    rest = _rest(clip.skeleton, straight, joint_positions(clip))[person.joints]
    nodes: list[dict[str, Any]] = []
    for node, (joint, above) in enumerate(zip(person.joints, person.above, strict=True)):
        offset = rest[node] - rest[above] if node else rest[0]
        nodes.append({"name": clip.skeleton.names[joint], "translation": offset.tolist()})
        if node:
            nodes[above].setdefault("children", []).append(node)
    _, turns = person.local(clip.root_positions, clip.rotations)
    keys = {node: turns[:, node] for node in range(len(nodes))}
    human = {bone: {"node": node} for node, bone in enumerate(person.bones)}
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


def _rest(skeleton: Skeleton, straight: Floats, positions: Floats) -> Floats:
    """Returns the positions [J, 3] in the T-pose, above the origin, with the soles on the floor.

    Receivers scale the hips' path by the height of their own hips over that of these. How far the lowest joint is from
    the sole is taken from the motion.
    """
    places = world_transforms(skeleton, np.zeros((1, 3)), local_rotations(skeleton, straight)[None])[0][0]
    lowest = float(positions[..., 1].min())
    places[:, 1] += (lowest if 0.0 < lowest < SOLE else 0.0) - places[:, 1].min()
    return places
