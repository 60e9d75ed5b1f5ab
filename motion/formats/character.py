"""Writes an animation into a copy of a character's own file: its skeleton, so that its meshes move."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
from motionsplice.motion.formats.gltf.reader import animation_names, malformed, read_rest
from motionsplice.motion.formats.legs import with_legs_in_place
from motionsplice.motion.formats.names import numbered
from motionsplice.motion.formats.reading import root_of
from motionsplice.motion.formats.scene import Scene, joints_of, nodes_of
from motionsplice.motion.formats.transforms import rotations_of
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, find_roles
from motionsplice.motion.skeleton import Skeleton, chain

RENAME = "Name its bones as a common rig does (Mixamo, Unreal, Rigify ...), or export it as VRM"
PLACED = 1e-5  # of the longest bone: a node that rests nearer to its place in the bind pose needs no translation


@dataclass(frozen=True, eq=False)
class Base:
    """A bone on the ground, above the hips, on which engines expect root motion. It goes where the hips go, unturned.

    node: its number in the file. joints: those whose nodes hang on it by way of nodes that are no joints.
    place, hips: where it and the hips rest in the world. inwards: the transform [4, 4] from the world to its parent.
    """

    node: int
    joints: frozenset[int]
    place: Floats
    hips: Floats
    inwards: Floats


@dataclass(frozen=True, eq=False)
class Character:
    """A character's file, and the skeleton of J joints in it.

    skeleton: in the file's own unit of length; each joint's axes are those of the world in the bind pose, not those of
    its node. roles: of its joints.
    nodes: [J] the number of each joint's node in the file.
    bind: [J, 4] the rotation of each node in the world in the bind pose.
    inwards: by joint, the transform [4, 4] from the world to the parent of its node, for the root and for joints whose
    nodes hang elsewhere than on the joint that they follow.
    placed: the translations [3] of the nodes that do not rest where the bind pose has them.
    base: the highest bone above the skeleton, which goes over the ground with it, if there is one.
    animations: the names of those that the file has.
    """

    document: Document
    binary: bytes
    skeleton: Skeleton
    roles: Roles
    nodes: list[int]
    bind: Floats
    inwards: Mapping[int, Floats]
    placed: Mapping[int, Floats]
    base: Base | None
    animations: list[str]

    def keys(self, clip: Clip) -> tuple[dict[int, Floats], dict[int, Floats]]:
        """Returns the translations and the local rotations of nodes, by node, that show a clip of this skeleton.

        They are [F, 3] and [F, 4]; a node that stays at one place has a translation [1, 3]. Nodes without a translation
        keep their own.
        """
        positions, turns = world_transforms(clip.skeleton, clip.root_positions, clip.rotations)
        turns = quaternion.multiply(turns, self.bind)
        translations = {node: place[None] for node, place in self.placed.items()}
        if self.base is not None:
            travelled = (positions[:, 0] - self.base.hips) * [1.0, 0.0, 1.0]
            translations[self.base.node] = _seen_from(self.base.inwards, self.base.place + travelled)
        rotations = {}
        for joint, (node, parent) in enumerate(zip(self.nodes, self.skeleton.parents.tolist(), strict=True)):
            if joint in self.inwards:
                inwards, places = self.inwards[joint], positions[:, joint]
                if self.base is not None and joint in self.base.joints:
                    places = places - travelled
                translations[node] = _seen_from(inwards, places)
                rotations[node] = quaternion.multiply(rotations_of(inwards[:3]), turns[:, joint])
            else:
                rotations[node] = quaternion.multiply(quaternion.conjugate(turns[:, parent]), turns[:, joint])
        return translations, rotations

    def animated(self, clip: Clip) -> bytes:
        """Returns a copy of the file with one more animation: a clip of this skeleton, under the clip's name.

        The nodes of the skeleton get keys; everything else is as it was, other animations included. If one of these has
        the clip's name, a number is added to the new one's.
        """
        document = deepcopy(self.document)
        translations, rotations = self.keys(clip)
        for node in rotations.keys() | translations.keys():
            _without_matrix(document["nodes"][node])
        binary = Binary(document, self.binary)
        *_, name = numbered([*self.animations, clip.name])
        added = binary.animation(name, clip.rate, translations, rotations)
        document["animations"] = [*document.get("animations", ()), added]
        return glb(document, binary.data)


def read_character(path: Path) -> Character:
    """Reads a character, .glb or .vrm, for animations to be written into it. It need not have any.

    Raises FormatError if the file is not one that can be written into, RoleError if its roles cannot be found.
    """
    try:
        return parse_character(read_bytes(path))
    except MotionError as error:
        raise error.within(str(path)) from None


def parse_character(data: bytes, most_nodes: int | None = None) -> Character:
    """Reads a character from the bytes of a GLB file, which may have at most so many nodes.

    Raises FormatError, or RoleError, as `read_character` does.
    """
    if data[:4] != MAGIC:
        raise FormatError("this is not a GLB file", mend="Export the character as .glb or .vrm")
    try:
        with malformed(), np.errstate(over="ignore", invalid="ignore"):  # Skeleton rejects numbers that are not finite
            return _parsed(data, most_nodes)
    except RoleError as error:
        raise RoleError(error.problem, mend=RENAME) from None


def _parsed(data: bytes, most_nodes: int | None) -> Character:
    document, binary = read_document(data)
    if most_nodes is not None and len(document["nodes"]) > most_nodes:
        problem = f"it has {len(document['nodes'])} nodes, more than {most_nodes}"
        raise FormatError(problem, mend="Leave out those that are not joints, and bones of hair and cloth")
    if "uri" in (document.get("buffers") or [{}])[0]:
        raise FormatError("its data are not in the file's binary chunk", mend="Export it as one GLB file")
    loose, numbers = read_rest(data)
    scene, order = with_legs_in_place(loose)
    inside, *_ = joints_of(scene)
    nodes, _ = nodes_of(scene)
    skeleton = fold(nodes, root_of(nodes, None, scene.roles)).skeleton
    places = [inside[nodes.names.index(name)] for name in skeleton.names]
    rest, bind = scene.world[0, places], rotations_of(scene.bind[places])
    own = [int(order[place]) for place in places]  # before the legs were put in place
    inwards = {
        joint: _inwards(loose, own[joint])
        for joint, parent in enumerate(skeleton.parents.tolist())
        if parent < 0 or int(loose.parents[own[joint]]) not in own
    }
    base = _base(loose, own, inwards, numbers)
    numbers = [numbers[place] for place in own]
    return Character(
        document,
        binary,
        skeleton,
        find_roles(skeleton, scene.roles),
        numbers,
        bind,
        inwards,
        {numbers[joint]: place for joint, place in _displaced(skeleton, bind, rest) if joint not in inwards},
        base,
        animation_names(data),
    )


def _inwards(scene: Scene, node: int) -> Floats:
    """Returns the transform [4, 4] from the world to the parent of a node at rest."""
    outwards, above = np.eye(4), int(scene.parents[node])
    if above >= 0:
        outwards[:3] = scene.world[0, above]
    return np.asarray(np.linalg.inv(outwards), np.float64)


def _seen_from(inwards: Floats, places: Floats) -> Floats:
    return places @ inwards[:3, :3].T + inwards[:3, 3]


def _base(scene: Scene, own: Sequence[int], inwards: Iterable[int], numbers: Sequence[int]) -> Base | None:
    """Returns the highest joint of the scene above the nodes `own` of a skeleton, if there is one."""
    above = [node for node in chain(scene.parents, own[0])[1:] if scene.joints[node]]
    if not above:
        return None
    highest = above[-1]
    carried = frozenset(joint for joint in inwards if highest in chain(scene.parents, own[joint]))
    place, hips = scene.world[0, [highest, own[0]], :, 3]
    return Base(numbers[highest], carried, place, hips, _inwards(scene, highest))


def _displaced(skeleton: Skeleton, bind: Floats, rest: Floats) -> Iterator[tuple[int, Floats]]:
    """Yields the joints whose nodes do not rest where the bind pose has them, and their translations [3] there."""
    near = PLACED * float(np.linalg.norm(skeleton.offsets[1:], axis=1).max())
    for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
        axes = rest[parent, :, :3]
        scale = np.cbrt(abs(np.linalg.det(axes)))
        bound = quaternion.rotate(quaternion.conjugate(bind[parent]), skeleton.offsets[joint])
        rests = scale * np.linalg.solve(axes, rest[joint, :, 3] - rest[parent, :, 3])
        if np.linalg.norm(bound - rests) > near:
            yield joint, bound / scale


def _without_matrix(node: dict[str, Any]) -> None:
    """Replaces the matrix of a node, which an animation may not move, by translation, rotation and scale."""
    if "matrix" in node:
        matrix = np.array(node.pop("matrix"), np.float64).reshape(4, 4).T[:3]
        node["translation"] = matrix[:, 3].tolist()
        node["rotation"] = rotations_of(matrix).tolist()
        node["scale"] = np.linalg.norm(matrix[:, :3], axis=0).tolist()
