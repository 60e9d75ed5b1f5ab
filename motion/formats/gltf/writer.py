"""Writes a clip as a GLB file that engines and Blender open: joints, a skin that names them, and one animation."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.container import CHUNK, HEAD, MAGIC, VERSION
from motionsplice.motion.quaternion import Floats

FLOAT, WIDTHS = 5126, {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def dump_glb(clip: Clip) -> bytes:
    """Writes a clip as a GLB file (glTF 2.0), in metres, at the clip's own frames.

    The joints keep their names. The root moves by translation and rotation, the other joints by rotation. A skin
    without a mesh lists the joints, so that Blender makes bones of them, not empties. End sites become leaf nodes.

    Args:
        clip: The motion.

    Returns:
        The contents of the file.
    """
    skeleton, binary = clip.skeleton, _Binary()
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
    places = offsets.copy()
    for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
        places[joint] += places[parent]
    inverse = np.tile(np.eye(4), (count, 1, 1))
    inverse[:, :3, 3] = -places
    times = binary.add(np.arange(clip.frame_count)[:, None] / clip.rate, bounds=True)
    turns = quaternion.one_hemisphere(clip.rotations)
    samplers = [{"input": times, "output": binary.add(clip.root_positions)}]
    samplers += [{"input": times, "output": binary.add(turns[:, joint])} for joint in range(count)]
    targets = [(0, "translation"), *((joint, "rotation") for joint in range(count))]
    channels = [{"sampler": at, "target": {"node": node, "path": path}} for at, (node, path) in enumerate(targets)]
    skin = {"joints": list(range(count)), "inverseBindMatrices": binary.add(inverse.transpose(0, 2, 1).reshape(-1, 16))}
    return _glb(
        {
            "asset": {"version": "2.0", "generator": "motionsplice"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
            "skins": [skin],
            "animations": [{"name": clip.name, "samplers": samplers, "channels": channels}],
            "accessors": binary.accessors,
            "bufferViews": binary.views,
            "buffers": [{"byteLength": len(binary.data)}],
        },
        bytes(binary.data),
    )


class _Binary:
    """The binary chunk as it grows: each array is one buffer view and one accessor."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: Floats, *, bounds: bool = False) -> int:
        """Adds an array [n, width] as float32, and returns its accessor."""
        numbers: NDArray[np.float32] = np.ascontiguousarray(values, np.float32)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": numbers.nbytes})
        self.data += numbers.tobytes()
        accessor: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": FLOAT,
            "count": len(numbers),
            "type": WIDTHS[numbers.shape[1]],
        }
        if bounds:
            accessor |= {"min": numbers.min(axis=0).tolist(), "max": numbers.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _glb(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = HEAD.size + 2 * CHUNK.size + len(text) + len(binary)
    head = HEAD.pack(MAGIC, VERSION, length)
    return head + CHUNK.pack(len(text), b"JSON") + text + CHUNK.pack(len(binary), b"BIN\0") + binary
