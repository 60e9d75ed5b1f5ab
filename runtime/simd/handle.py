"""One handle for many arrays: Numba unpacks each array that a call passes, and records of arrays slowly.

A record is a NamedTuple of arrays, numbers and other records. Each field declares what it holds:

    class Scratch(NamedTuple):
        lanes: Annotated[Array, np.float32, 2]  # type and number of dimensions
        share: float

Python passes `handle_of(record)` to a kernel, which reads the record again by `record_at(handle, Scratch)`. A handle is
a read-only array with the address and the extents of each array. NumPy keeps the bytes of a handle as long as the
handle, and these keep the record, so a handle keeps all that it points to. In plain Python a handle is the record
itself, so bounds are checked.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin

import numba
import numpy as np
from numba.extending import overload

from motionsplice.runtime.simd.handle_instructions import fields_of, llvm_record

Handle = Any  # opaque: of a record
Record = TypeVar("Record", bound=NamedTuple)


class Addresses(bytes):
    """The numbers of a handle, and the record whose arrays they point to."""

    record: object


def handle_of(record: Record) -> Handle:
    """Returns the handle of a record. Raises TypeError if a field does not hold what it declares."""
    numbers = list(_numbers(record, type(record)))
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return record
    addresses = Addresses(np.array(numbers, np.int64).tobytes())
    addresses.record = record
    return np.frombuffer(addresses, np.int64)


def record_at(handle: Handle, kind: type[Record]) -> Record:
    """Returns the record of a handle. Nothing checks that it is of this kind."""
    return handle


@overload(record_at, inline="always")
def _compiled_record_at(handle, kind):
    return lambda handle, kind: llvm_record(handle, kind)


def _numbers(value: Any, declared: Any) -> Iterator[int]:
    """Yields the numbers of a field, in the order in which `llvm_record` reads them."""
    if declared is float:
        yield int(np.float64(value).view(np.int64))
    elif get_origin(declared) is Annotated:
        _, kind, dimensions = get_args(declared)
        if value.dtype != kind or value.ndim != dimensions or not (value.flags.c_contiguous and value.flags.aligned):
            raise TypeError(f"expected {dimensions} dimensions of {np.dtype(kind)}, found {value.dtype}{value.shape}")
        yield from (value.ctypes.data, *value.shape)
    else:
        for field, inner in fields_of(declared).items():
            yield from _numbers(getattr(value, field), inner)
