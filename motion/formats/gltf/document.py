"""Parts of glTF files that are written: arrays in a binary chunk, animations, and the containers .glb and .gltf."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.formats.gltf.container import CHUNK, HEAD, MAGIC, VERSION
from motionsplice.motion.quaternion import Floats

FLOAT, WIDTHS = 5126, {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
ASSET = {"version": "2.0", "generator": "motionsplice"}
Document = dict[str, Any]


class Binary:
    """A document's first buffer, as it grows: each array becomes one buffer view and one accessor of the document.

    document: its `buffers`, `bufferViews` and `accessors` are extended. data: the contents of the buffer so far.
    """

    def __init__(self, document: Document, data: bytes = b"") -> None:
        self.data = bytearray(data + b"\0" * (-len(data) % 4))
        self._views = document.setdefault("bufferViews", [])
        self._accessors = document.setdefault("accessors", [])
        document["buffers"] = document.get("buffers") or [{}]
        self._buffer = document["buffers"][0]

    def add(self, values: Floats, *, bounds: bool = False) -> int:
        """Adds an array [n, width] as float32, and returns its accessor."""
        numbers: NDArray[np.float32] = np.ascontiguousarray(values, np.float32)
        self._views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": numbers.nbytes})
        self.data += numbers.tobytes()
        self._buffer["byteLength"] = len(self.data)
        accessor: dict[str, Any] = {
            "bufferView": len(self._views) - 1,
            "componentType": FLOAT,
            "count": len(numbers),
            "type": WIDTHS[numbers.shape[1]],
        }
        if bounds:
            accessor |= {"min": numbers.min(axis=0).tolist(), "max": numbers.max(axis=0).tolist()}
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def animation(
        self, name: str, rate: float, translations: Mapping[int, Floats], rotations: Mapping[int, Floats]
    ) -> dict[str, Any]:
        """Adds the keys of an animation, and returns it.

        translations, rotations: the keys [F, 3] or [F, 4] of each node that moves; those of a node that stays are [1].
        """
        keys = [(node, "translation", path) for node, path in translations.items()]
        keys += [(node, "rotation", quaternion.one_hemisphere(turns)) for node, turns in rotations.items()]
        times: dict[int, int] = {}
        samplers, channels = list[dict[str, int]](), list[dict[str, Any]]()
        for node, path, values in keys:
            if (count := len(values)) not in times:
                times[count] = self.add(np.arange(count)[:, None] / rate, bounds=True)
            samplers.append({"input": times[count], "output": self.add(values)})
            channels.append({"sampler": len(channels), "target": {"node": node, "path": path}})
        return {"name": name, "samplers": samplers, "channels": channels}


def glb(document: Document, binary: bytes | bytearray) -> bytes:
    """Returns a document and its buffer as a GLB file."""
    text = _text(document)
    text += b" " * (-len(text) % 4)
    length = HEAD.size + 2 * CHUNK.size + len(text) + len(binary)
    head = HEAD.pack(MAGIC, VERSION, length)
    return head + CHUNK.pack(len(text), b"JSON") + text + CHUNK.pack(len(binary), b"BIN\0") + binary


def gltf(document: Document, binary: bytes | bytearray) -> bytes:
    """Returns a document as text, with its buffer in it as base64."""
    uri = f"data:application/octet-stream;base64,{base64.b64encode(binary).decode()}"
    (buffer,) = document["buffers"]
    return _text({**document, "buffers": [buffer | {"uri": uri}]})


def _text(document: Document) -> bytes:
    return json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
