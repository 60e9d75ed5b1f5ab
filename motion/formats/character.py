"""Writes an animation into a copy of a character's own file: its skeleton, so that its meshes move."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError, RoleError
from motionsplice.motion.formats.files import read_bytes
from motionsplice.motion.formats.fold import fold
from motionsplice.motion.formats.gltf.container import MAGIC, read_document
from motionsplice.motion.formats.gltf.document import Binary, Document, glb
from motionsplice.motion.formats.gltf.reader import read_rest
from motionsplice.motion.formats.reading import root_of
from motionsplice.motion.formats.scene import joints_of, nodes_of, rotations_of
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, find_roles
from motionsplice.motion.skeleton import Skeleton

SUFFIXES = (".glb", ".vrm")
RENAME = "Name its bones as a common rig does (Mixamo, Unreal, Rigify ...), or export it as VRM"
PLACED = 1e-5  # of the longest bone: a node that rests nearer to its place in the bind pose needs no translation


@dataclass(frozen=True, eq=False)
class Character:
    """A character's file, and the skeleton of J joints in it.

    skeleton: in the file's own unit of length; each joint's axes are those of the world in the bind pose, not those of
    its node. roles: of its joints.
    nodes: [J] the number of each joint's node in the file.
    bind: [J, 4] the rotation of each node in the world in the bind pose.
    rest: [J, 3, 4] the transform of each node to the world at rest. above: [4, 4] that of the root's parent.
    """

    document: Document
    binary: bytes
    skeleton: Skeleton
    roles: Roles
    nodes: list[int]
    bind: Floats
    rest: Floats
    above: Floats

    def animated(self, clip: Clip) -> bytes:
        """Returns a copy of the file with one more animation: a clip of this skeleton, under the clip's name.

        The nodes of the skeleton get keys; everything else is as it was, other animations included. If one of these has
        the clip's name, a number is added to the new one's.
        """
        document = deepcopy(self.document)
        translations, rotations = self._keys(clip)
        for node in rotations:
            _without_matrix(document["nodes"][node])
        binary = Binary(document, self.binary)
        animations = document.setdefault("animations", [])
        name = _free_name(clip.name, {str(one.get("name")) for one in animations})
        animations.append(binary.animation(name, clip.rate, translations, rotations))
        return glb(document, binary.data)

    def _keys(self, clip: Clip) -> tuple[dict[int, Floats], dict[int, Floats]]:
        """Returns the translations and rotations of nodes on their parents over time."""
        positions, turns = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
        turns = quaternion.multiply(turns, self.bind)
        parents, root = self.skeleton.parents, self.nodes[0]
        inverse = np.linalg.inv(self.above)
        translations = {root: positions[:, 0] @ inverse[:3, :3].T + inverse[:3, 3]}
        above = rotations_of(self.above[:3])
        rotations = {root: quaternion.multiply(quaternion.conjugate(above), turns[:, 0])}
        scales = np.cbrt(np.abs(np.linalg.det(self.rest[..., :3])))
        near = PLACED * float(np.linalg.norm(self.skeleton.offsets[1:], axis=1).max())
        for joint, node in enumerate(self.nodes[1:], 1):
            parent = parents[joint]
            rotations[node] = quaternion.multiply(quaternion.conjugate(turns[:, parent]), turns[:, joint])
            bound = quaternion.rotate(quaternion.conjugate(self.bind[parent]), self.skeleton.offsets[joint])
            rests = np.linalg.solve(self.rest[parent, :, :3], self.rest[joint, :, 3] - self.rest[parent, :, 3])
            if np.linalg.norm(bound - rests * scales[parent]) > near:
                translations[node] = bound[None] / scales[parent]
        return translations, rotations


def read_character(path: Path) -> Character:
    """Reads a character, .glb or .vrm, for animations to be written into it. It need not have any.

    Raises FormatError if the file is not one that can be written into, RoleError if its roles cannot be found.
    """
    try:
        return _read(read_bytes(path))
    except RoleError as error:
        raise RoleError(error.problem, file=str(path), mend=RENAME) from None
    except MotionError as error:
        raise error.within(str(path)) from None


def _read(data: bytes) -> Character:
    if data[:4] != MAGIC:
        raise FormatError("this is not a GLB file", mend="Export the character as .glb or .vrm")
    document, binary = read_document(data)
    if "uri" in document.get("buffers", [{}])[0]:
        raise FormatError("its data are not in the file's binary chunk", mend="Export it as one GLB file")
    scene, numbers = read_rest(data)
    inside, _, _ = joints_of(scene)
    nodes, _ = nodes_of(scene)
    skeleton = fold(nodes, root_of(nodes, scene.roles)).skeleton
    places = [inside[nodes.names.index(name)] for name in skeleton.names]
    parent, above = scene.parents[places[0]], np.eye(4)
    if parent >= 0:
        above[:3] = scene.world[0, parent]
    return Character(
        document,
        binary,
        skeleton,
        find_roles(skeleton, scene.roles),
        [numbers[place] for place in places],
        rotations_of(scene.bind[places]),
        scene.world[0, places],
        above,
    )


def _without_matrix(node: dict[str, Any]) -> None:
    """Replaces the matrix of a node, which an animation may not move, by translation, rotation and scale."""
    if "matrix" in node:
        matrix = np.array(node.pop("matrix"), np.float64).reshape(4, 4).T[:3]
        node["translation"] = matrix[:, 3].tolist()
        node["rotation"] = rotations_of(matrix).tolist()
        node["scale"] = np.linalg.norm(matrix[:, :3], axis=0).tolist()


def _free_name(name: str, taken: set[str]) -> str:
    number, free = 0, name
    while free in taken:
        number += 1
        free = f"{name}.{number:03d}"
    return free
