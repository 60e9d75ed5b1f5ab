"""Accessors: typed, strided, normalised and sparse arrays in a glTF file's buffers (glTF 2.0, 3.6.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats.gltf.container import EXPORT, Container
from motionsplice.motion.quaternion import Floats

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
MOST_ZEROS = 1_000_000  # numbers of an accessor that has no data of its own


def read_accessor(container: Container, index: int) -> Floats:
    """Reads an accessor as floating-point numbers [count, width]. Raises FormatError.

    Matrices are in the file's column-major order.
    """
    accessor = _item(container.document, "accessors", index)
    kind, width, count = COMPONENTS[accessor["componentType"]], WIDTHS[accessor["type"]], int(accessor["count"])
    if "bufferView" in accessor:
        view, offset = int(accessor["bufferView"]), int(accessor.get("byteOffset", 0))
        values = _elements(container, view, offset, kind, width, count)
    elif 0 < count * width <= MOST_ZEROS:
        values = np.zeros((count, width), kind)
    else:
        raise FormatError(f"{count} numbers have no data", place=f"accessor {index}", mend=EXPORT)
    if "sparse" in accessor:
        values = _with_sparse(container, accessor["sparse"], values, kind)
    numbers = values.astype(np.float64)
    if accessor.get("normalized") and kind != "<f4":
        numbers = np.maximum(numbers / np.iinfo(kind).max, -1.0)
    if not np.isfinite(numbers).all():
        raise FormatError("a number is not finite", place=f"accessor {index}", mend=EXPORT)
    return numbers


def _with_sparse(container: Container, sparse: dict[str, Any], values: NDArray[Any], kind: str) -> NDArray[Any]:
    count, indices, replaced = int(sparse["count"]), sparse["indices"], sparse["values"]
    at = _elements(
        container,
        int(indices["bufferView"]),
        int(indices.get("byteOffset", 0)),
        COMPONENTS[indices["componentType"]],
        1,
        count,
    )
    new = _elements(
        container, int(replaced["bufferView"]), int(replaced.get("byteOffset", 0)), kind, values.shape[1], count
    )
    if at.size and at.max() >= len(values):
        raise FormatError(f"a sparse index {at.max()} is outside {len(values)} elements", mend=EXPORT)
    values = values.copy()
    values[at[:, 0].astype(np.int64)] = new
    return values


def _elements(container: Container, view: int, offset: int, kind: str, width: int, count: int) -> NDArray[Any]:
    """Returns a view [count, width] of the buffer, after checking that all of it is there."""
    whole = _item(container.document, "bufferViews", view)
    buffer = container.buffers[_natural(whole["buffer"])]
    begin, length = _natural(whole.get("byteOffset", 0)), _natural(whole["byteLength"])
    size = np.dtype(kind).itemsize * width
    stride = int(whole.get("byteStride", size))
    end = offset + (count - 1) * stride + size
    if not (count > 0 and stride >= size and offset >= 0 and end <= length and begin + length <= len(buffer)):
        problem = f"{count} elements of {size} bytes do not fit into a view of {length} bytes"
        raise FormatError(problem, place=f"buffer view {view}", mend=EXPORT)
    rows = np.ndarray((count, size), np.uint8, buffer, begin + offset, (stride, 1))
    return np.ascontiguousarray(rows).view(kind)


def _item(document: dict[str, Any], key: str, index: int) -> dict[str, Any]:
    item: dict[str, Any] = document[key][_natural(index)]
    return item


def _natural(value: Any) -> int:
    """Returns a whole number from 0 on: a negative one would count from the end. Raises IndexError."""
    number = int(value)
    if number < 0:
        raise IndexError(f"{number} is negative")
    return number
