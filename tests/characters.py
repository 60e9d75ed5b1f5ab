"""Character files for tests: a skeleton with bones turned and scaled as exporters do, and a box for each bone."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.document import ASSET, Binary, Document, glb
from motionsplice.motion.kinematics import bind_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.skeleton import Skeleton
from tests.glb_files import edited

HEIGHT = 0.95  # metres: where the root is bound


def character_file(
    skeleton: Skeleton,
    *,
    scale: float = 1.0,
    seed: int | None = None,
    matrices: bool = False,
    bound_to_base: bool = False,
) -> bytes:
    """Returns a GLB file of a skinned mesh: a box of 24 vertices from each joint's parent to it, in joint order.

    The mesh is bound in the skeleton's bind pose, facing +Z, the root at HEIGHT. Above the root are an armature,
    scaled by `scale` and lying on its back, and a bone `base`; below are end sites.

    seed: of random axes for the bones; None for the world's. matrices: whether nodes have matrices. bound_to_base:
    whether the mesh is bound to `base` too.
    """
    count = skeleton.joint_count
    places = standing(skeleton)
    lying = quaternion.about([1.0, 0.0, 0.0], -np.pi / 2)
    axes = (
        np.tile(quaternion.IDENTITY, (count, 1))
        if seed is None
        else Rotation.random(count, random_state=seed).as_quat()
    )
    world = np.tile(np.eye(4), (count + 2, 1, 1))  # armature, base, joints
    world[0, :3, :3] = scale * quaternion_matrix(lying)
    world[1, :3] = world[0, :3] + [[0.0, 0.0, 0.0, 0.1]] * 3
    for joint in range(count):
        world[2 + joint, :3, :3] = scale * quaternion_matrix(axes[joint])
        world[2 + joint, :3, 3] = places[joint]
    parents = [-1, 0, 1, *(2 + skeleton.parents[1:]).tolist()]
    names = ["Armature", "base", *skeleton.names]
    nodes: list[dict[str, Any]] = []
    for node, parent in enumerate(parents):
        local = np.linalg.inv(world[parent]) @ world[node] if node else world[node]
        nodes.append({"name": names[node]} | (_matrix(local) if matrices else _parts(local)))
        if node:
            nodes[parent].setdefault("children", []).append(node)
    document: Document = {
        "asset": ASSET | {"copyright": "café"},
        "scene": 0,
        "scenes": [{"nodes": [0, len(nodes)]}],
        "nodes": [*nodes, {"name": "Body", "mesh": 0, "skin": 0}],
        "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.3, 1.0]}}],
    }
    binary = Binary(document)
    bones = [*range(2, count + 2), *([1] if bound_to_base else [])]
    inverse = np.asarray(np.linalg.inv(world[bones]), np.float64).transpose(0, 2, 1).reshape(-1, 16)
    document["skins"] = [{"joints": bones, "inverseBindMatrices": binary.add(inverse)}]
    vertices, normals, moved_by, indices = boxes(skeleton, places)
    attributes = {
        "POSITION": binary.add(vertices, bounds=True),
        "NORMAL": binary.add(normals),
        "WEIGHTS_0": binary.add(np.tile([1.0, 0.0, 0.0, 0.0], (len(vertices), 1))),
        "JOINTS_0": _add_shorts(document, binary, np.pad(moved_by[:, None], ((0, 0), (0, 3)))),
    }
    primitive = {"attributes": attributes, "indices": _add_shorts(document, binary, indices[:, None]), "material": 0}
    document["meshes"] = [{"primitives": [primitive]}]
    return glb(document, binary.data)


def standing(skeleton: Skeleton) -> Floats:
    """Returns the positions of the joints [J, 3] in which the mesh is bound."""
    return bind_positions(skeleton) + np.array([0.0, HEIGHT, 0.0])


def boxes(skeleton: Skeleton, places: Floats) -> tuple[Floats, Floats, Any, Any]:
    """Returns the vertices and normals [V, 3] of the boxes, the joint that moves each vertex, and the triangles."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (0.0, 1.0)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    vertices, normals = list[Floats](), list[Floats]()
    moved_by, indices = list[int](), list[int]()
    for joint in range(1, skeleton.joint_count):
        parent = int(skeleton.parents[joint])
        turn = quaternion_matrix(quaternion.between(np.array([0.0, 0.0, 1.0]), skeleton.offsets[joint]))
        length = np.linalg.norm(skeleton.offsets[joint])
        box = places[parent] + corners * (0.2 * length, 0.2 * length, length) @ turn.T
        for face in faces:
            normal = np.cross(box[face[1]] - box[face[0]], box[face[2]] - box[face[0]])
            indices += [len(vertices) + corner for corner in (0, 1, 2, 0, 2, 3)]
            vertices += [box[corner] for corner in face]
            normals += [normal / np.linalg.norm(normal)] * 4
            moved_by += [parent] * 4
    return np.array(vertices), np.array(normals), np.array(moved_by), np.array(indices)


def quaternion_matrix(turn: Floats) -> Floats:
    return quaternion.rotate(turn, np.eye(3)).T


def _matrix(local: Floats) -> dict[str, Any]:
    return {"matrix": local.T.ravel().tolist()}


def _parts(local: Floats) -> dict[str, Any]:
    scale = np.linalg.norm(local[:3, :3], axis=0)
    rotation = quaternion.from_matrices(local[:3, :3] / scale)
    return {"translation": local[:3, 3].tolist(), "rotation": rotation.tolist(), "scale": scale.tolist()}


def _add_shorts(document: Document, binary: Binary, values: Any) -> int:
    """Adds whole numbers [n, 1 or 4], and returns their accessor."""
    view = {"buffer": 0, "byteOffset": len(binary.data), "byteLength": 2 * values.size}
    data = values.astype("<u2").tobytes()
    binary.data += data + b"\0" * (-len(data) % 4)
    document["bufferViews"].append(view)
    kind = "SCALAR" if values.shape[1] == 1 else "VEC4"
    document["accessors"].append(
        {"bufferView": len(document["bufferViews"]) - 1, "componentType": 5123, "count": len(values), "type": kind}
    )
    document["buffers"][0]["byteLength"] = len(binary.data)
    return len(document["accessors"]) - 1


def facing_back(data: bytes, bones: dict[str, str]) -> bytes:
    """Returns the character of `character_file` as a VRM 0.x file, which faces -Z. bones: the node of each VRM bone."""
    document, chunk = read_document(data)
    binary, views, accessors = bytearray(chunk), document["bufferViews"], document["accessors"]

    def turn(accessor: int, matrix: Floats) -> None:
        view = views[accessors[accessor]["bufferView"]]
        place = slice(view["byteOffset"], view["byteOffset"] + view["byteLength"])
        rows = np.frombuffer(bytes(binary[place]), "<f4").reshape(-1, len(matrix))
        binary[place] = (rows @ matrix).astype("<f4").tobytes()

    round_y = np.diag([-1.0, 1.0, -1.0, 1.0])
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    turn(attributes["POSITION"], round_y[:3, :3])
    turn(attributes["NORMAL"], round_y[:3, :3])
    turn(document["skins"][0]["inverseBindMatrices"], np.asarray(np.kron(round_y, np.eye(4)), np.float64))

    def edit(document: Document) -> None:
        top = document["nodes"][0]
        top["rotation"] = quaternion.multiply(np.array([0.0, 1.0, 0.0, 0.0]), np.array(top["rotation"])).tolist()
        numbers = {node["name"]: number for number, node in enumerate(document["nodes"])}
        human = [{"bone": bone, "node": numbers[name]} for bone, name in bones.items()]
        document["extensions"] = {"VRM": {"specVersion": "0.0", "humanoid": {"humanBones": human}}}
        bounds = accessors[attributes["POSITION"]]
        low, high = bounds["min"], bounds["max"]
        document["accessors"][attributes["POSITION"]] |= {
            "min": [-high[0], low[1], -high[2]],
            "max": [-low[0], high[1], -low[2]],
        }

    return edited(data, edit, bytes(binary))
