"""A glTF file that uses what exporters use: splines, steps, whole numbers, sparse keys, scale, matrices, two times."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.writer import dump_glb

ARMATURE = [0.0, 0.0, -1.1, 0.0, 0.0, 1.1, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0, 0.3, 0.2, 0.1, 1.0]  # by columns
BYTE, SHORT, UNSIGNED, FLOAT = 5120, 5122, 5123, 5126


def rich_document(clip: Clip) -> tuple[dict[str, Any], bytes]:
    """Returns a document, and its buffer, of a clip of at least 12 frames whose first joints move in many ways."""
    document, binary = read_document(dump_glb(clip))
    (animation,) = document["animations"]
    samplers, times = animation["samplers"], animation["samplers"][0]["input"]
    data = bytearray(binary)
    draw = np.random.default_rng(0)

    def view(numbers: NDArray[Any]) -> int:
        data.extend(bytes(-len(data) % 4))
        whole = {"buffer": 0, "byteOffset": len(data), "byteLength": numbers.nbytes}
        document["bufferViews"].append(whole)
        data.extend(numbers.tobytes())
        return len(document["bufferViews"]) - 1

    def accessor(numbers: NDArray[Any], kind: str, component: int, **more: Any) -> int:
        own = {"bufferView": view(numbers), "componentType": component, "type": kind, "count": len(numbers)}
        document["accessors"].append(own | more)
        return len(document["accessors"]) - 1

    def spline(values: NDArray[Any]) -> NDArray[np.float32]:
        tangents = np.gradient(values, 1.0 / clip.rate, axis=0) + draw.normal(0.0, 0.2, values.shape)
        return np.stack([tangents, values, -tangents], axis=1).reshape(-1, values.shape[1]).astype("<f4")

    turns = quaternion.one_hemisphere(clip.rotations)
    samplers[0] |= {
        "output": accessor(spline(clip.root_positions), "VEC3", FLOAT),
        "interpolation": "CUBICSPLINE",
    }
    samplers[2] |= {"output": accessor(spline(turns[:, 1]), "VEC4", FLOAT), "interpolation": "CUBICSPLINE"}
    samplers[3]["interpolation"] = "STEP"
    shorts = np.round(turns[:, 3] * 32767).astype("<i2")
    samplers[4]["output"] = accessor(shorts, "VEC4", SHORT, normalized=True)
    samplers[5]["output"] = accessor(np.round(turns[:, 4] * 127).astype("i1"), "VEC4", BYTE, normalized=True)
    sparse = {
        "count": 2,
        "indices": {"bufferView": view(np.array([3, 7], "<u2")), "componentType": UNSIGNED},
        "values": {"bufferView": view(turns[[5, 9], 5].astype("<f4"))},
    }
    document["accessors"][samplers[6]["output"]]["sparse"] = sparse
    seconds = (np.array([1.5, 4.0, 4.7, 9.2]) / clip.rate).astype("<f4")
    bounds = {"min": [float(seconds[0])], "max": [float(seconds[-1])]}
    few = accessor(seconds, "SCALAR", FLOAT, **bounds)
    samplers[7] |= {"input": few, "output": accessor(turns[[0, 3, 8, 11], 6].astype("<f4"), "VEC4", FLOAT)}
    sizes = draw.uniform(0.8, 1.2, (clip.frame_count, 3)).astype("<f4")
    samplers.append({"input": times, "output": accessor(sizes, "VEC3", FLOAT)})
    animation["channels"].append({"sampler": len(samplers) - 1, "target": {"node": 9, "path": "scale"}})
    document["nodes"][10] |= {"scale": [1.0, 0.9, 1.2]}
    document["nodes"].append({"name": "Armature", "matrix": ARMATURE, "children": [0]})
    document["scenes"][0]["nodes"] = [len(document["nodes"]) - 1]
    document["buffers"][0]["byteLength"] = len(data)
    return document, bytes(data)
