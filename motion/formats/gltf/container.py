"""The container of a glTF file: its JSON document and its buffers (glTF 2.0, 3.6 and 4)."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

from motionsplice.motion.errors import FormatError

MAGIC, VERSION = b"glTF", 2
HEAD, CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
EXPORT = "Export it again as glTF 2.0"
READABLE = {  # extensions that change nothing about nodes and animations
    "KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization", "KHR_texture_basisu", "VRMC_vrm",
    "VRMC_vrm_animation", "VRMC_springBone", "VRMC_materials_mtoon", "VRMC_node_constraint", "EXT_texture_webp",
    "KHR_materials_pbrSpecularGlossiness", "KHR_lights_punctual",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Container:
    """A glTF file's JSON document, its buffers, and the bytes that they have together: buffers may share some."""

    document: dict[str, Any]
    buffers: tuple[memoryview, ...]
    size: int


def read_document(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Reads the JSON document and the binary chunk, which is empty in a `.gltf` file. Raises FormatError."""
    text, binary = _chunks(data) if data[:4] == MAGIC else (data, b"")
    try:
        document = json.loads(text.decode("utf-8-sig"))
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise FormatError(f"its JSON cannot be read: {str(error)[:80]}", mend=EXPORT) from None
    if not isinstance(document, dict) or not str(document.get("asset", {}).get("version", "")).startswith("2."):
        raise FormatError("this is not a glTF 2.0 file", mend=EXPORT)
    return document, binary


def open_container(data: bytes, read_beside: Callable[[str], bytes]) -> Container:
    """Reads a document with its buffers; `read_beside` reads a file in the same folder. Raises FormatError."""
    document, binary = read_document(data)
    if required := set(document.get("extensionsRequired", ())) - READABLE:
        mend = "Export without compression"
        raise FormatError(f"it requires extensions that cannot be read: {', '.join(sorted(required))}", mend=mend)
    buffers, contents = list[memoryview](), dict[str | None, bytes]()
    for buffer in document.get("buffers", ()):
        uri, length = buffer.get("uri"), int(buffer["byteLength"])
        if uri not in contents:
            contents[uri] = binary if uri is None else _content(uri, read_beside)
        if not 0 <= length <= len(contents[uri]):
            problem = f"a buffer should have {length} bytes, found {len(contents[uri])}"
            raise FormatError(problem, mend="Copy its .bin file again")
        buffers.append(memoryview(contents[uri])[:length])
    return Container(document, tuple(buffers), sum(map(len, contents.values())))


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """Returns the JSON chunk and the binary chunk of a GLB file."""
    if len(data) < HEAD.size + CHUNK.size:
        raise FormatError(f"the file ends after {len(data)} bytes, inside its header", mend=EXPORT)
    _, version, length = HEAD.unpack_from(data)
    if version != VERSION:
        raise FormatError(f"it has version {version} of the GLB container, expected {VERSION}", mend=EXPORT)
    if length > len(data):
        raise FormatError(f"its header says {length} bytes, found {len(data)}", mend="Copy or export the file again")
    found: dict[bytes, bytes] = {}
    at = HEAD.size
    while at + CHUNK.size <= length:
        size, kind = CHUNK.unpack_from(data, at)
        if at + CHUNK.size + size > length:
            place = f"byte {at}"
            raise FormatError(f"a chunk of {size} bytes does not fit into the file", place=place, mend=EXPORT)
        found.setdefault(kind, data[at + CHUNK.size : at + CHUNK.size + size])
        at += CHUNK.size + size
    if b"JSON" not in found:
        raise FormatError("the file has no JSON chunk", mend=EXPORT)
    return found[b"JSON"], found.get(b"BIN\0", b"")


def _content(uri: str, read_beside: Callable[[str], bytes]) -> bytes:
    return base64.b64decode(uri.partition(",")[2]) if uri.startswith("data:") else read_beside(unquote(uri))
