"""GLB files with other documents, for tests."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.writer import dump_glb


def edited(data: bytes, edit: Callable[[dict[str, Any]], None], binary: bytes | None = None) -> bytes:
    """Returns the file with an edited document, and perhaps with another binary chunk."""
    document, own = read_document(data)
    edit(document)
    text, chunk = json.dumps(document).encode(), own if binary is None else binary
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(chunk), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(chunk), b"BIN\0") + chunk


def with_animation(data: bytes, clip: Clip) -> bytes:
    """Returns the file with one more animation, of a clip of the same skeleton."""
    theirs, more = read_document(dump_glb(clip))
    _, own = read_document(data)

    def edit(document: dict[str, Any]) -> None:
        views, accessors = len(document["bufferViews"]), len(document["accessors"])
        document["bufferViews"] += [one | {"byteOffset": one["byteOffset"] + len(own)} for one in theirs["bufferViews"]]
        document["accessors"] += [one | {"bufferView": one["bufferView"] + views} for one in theirs["accessors"]]
        (animation,) = theirs["animations"]
        for sampler in animation["samplers"]:
            sampler["input"] += accessors
            sampler["output"] += accessors
        document["animations"].append(animation)
        document["buffers"][0]["byteLength"] = len(own) + theirs["buffers"][0]["byteLength"]

    return edited(data, edit, own + more)
