"""The instructions that read a record from its handle, for `runtime.simd.handle`."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numba.np.numpy_support import from_dtype


@cache
def fields_of(kind: Any) -> dict[str, Any]:
    """Returns what each field of a kind of record declares."""
    hints = get_type_hints(kind, include_extras=True)
    return {field: hints[field] for field in kind._fields}


@intrinsic
def llvm_record(_, handle, kind):
    record = _type_of(kind.instance_class)

    def generate(context, builder, signature, arguments):
        numbers = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return _read(context, builder, record, _loads(builder, numbers))

    return record(handle, kind), generate


def _type_of(declared):
    """Returns the Numba type of a field. All arrays are writable, because kernels are compiled anew for others."""
    if declared is float:
        return types.float64
    if get_origin(declared) is Annotated:
        _, kind, dimensions = get_args(declared)
        return types.Array(from_dtype(np.dtype(kind)), dimensions, "C")
    return types.BaseTuple.from_types([_type_of(inner) for inner in fields_of(declared).values()], declared)


def _loads(builder, numbers):
    """Yields the numbers of a handle, each as an instruction that loads it."""
    at = 0
    while True:
        yield builder.load(cgutils.gep_inbounds(builder, numbers, at))
        at += 1


def _read(context, builder, kind, numbers):
    """Returns the value of a field, from the next of its record's numbers."""
    if isinstance(kind, types.BaseTuple):
        values = [_read(context, builder, inner, numbers) for inner in tuple(kind)]  # type: ignore[var-annotated, arg-type]
        return context.make_tuple(builder, kind, values)
    if kind is types.float64:
        return builder.bitcast(next(numbers), context.get_value_type(kind))
    array = context.make_array(kind)(context, builder)
    data = builder.inttoptr(next(numbers), array.data.type)
    shape = [next(numbers) for _ in range(kind.ndim)]
    size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides = [stride := size]
    for extent in reversed(shape[1:]):
        strides.append(stride := builder.mul(stride, extent))
    populate_array(array, data=data, shape=shape, strides=strides[::-1], itemsize=size, meminfo=None)
    return array._getvalue()
