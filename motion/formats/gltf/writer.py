"""Writes a clip as a glTF file that engines and Blender open: joints, a skin that names them, and one animation."""

from __future__ import annotations

from typing import Any

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.document import ASSET, Binary, Document, glb, gltf
from motionsplice.motion.kinematics import bind_positions


def dump_glb(clip: Clip) -> bytes:
    """Writes a clip as a GLB file (glTF 2.0), in metres, at the clip's own frames.

    The joints keep their names, and the animation has the clip's. The root moves by translation and rotation, the other
    joints by rotation. A skin without a mesh lists the joints, so that Blender makes bones of them, not empties. End
    sites become leaf nodes.

    Args:
        clip: The motion.

    Returns:
        The contents of the file.
    """
    return glb(*_written(clip))


def dump_gltf(clip: Clip) -> bytes:
    """Writes a clip as `dump_glb` does, but as one text file, .gltf, with its buffer in it as base64.

    Args:
        clip: The motion.

    Returns:
        The contents of the file.
    """
    return gltf(*_written(clip))


def _written(clip: Clip) -> tuple[Document, bytes]:
    skeleton = clip.skeleton
    count = skeleton.joint_count
    children: list[list[int]] = [[] for _ in range(count)]
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            children[parent].append(joint)
    for end, parent in enumerate(skeleton.end_parents.tolist()):
        children[parent].append(count + end)
    offsets = skeleton.offsets.copy()
    offsets[0] = clip.root_positions[0]
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": offset.tolist()} | ({"children": below} if below else {})
        for name, offset, below in zip(skeleton.names, offsets, children, strict=True)
    ]
    for parent, offset in zip(skeleton.end_parents.tolist(), skeleton.end_offsets.tolist(), strict=True):
        nodes.append({"name": f"{skeleton.names[parent]}_end", "translation": offset})
    inverse = np.tile(np.eye(4), (count, 1, 1))
    inverse[:, :3, 3] = -(bind_positions(skeleton) + clip.root_positions[0])
    document: Document = {"asset": ASSET, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes}
    binary = Binary(document)
    turns = {joint: clip.rotations[:, joint] for joint in range(count)}
    document["animations"] = [binary.animation(clip.name, clip.rate, {0: clip.root_positions}, turns)]
    bind = binary.add(inverse.transpose(0, 2, 1).reshape(-1, 16))
    document["skins"] = [{"joints": list(range(count)), "inverseBindMatrices": bind}]
    return document, bytes(binary.data)
