"""The processor's prefetch instruction, which Numba does not offer."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from motionsplice.runtime.simd.compiled import Array, Index

READ, KEEP, DATA = 0, 3, 1  # LLVM's numbers


def prefetch(table: Array, row: Index, column: Index) -> None:
    """Prefetches the cache line of an element of a C-contiguous table; does nothing in plain Python."""


@intrinsic
def _prefetch(_, table, row, column):
    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        place = builder.mul(arguments[1], builder.extract_value(array.shape, 1))
        place = builder.gep(array.data, [builder.add(place, arguments[2])])
        byte, word = ir.IntType(8).as_pointer(), ir.IntType(32)
        fetching = ir.FunctionType(ir.VoidType(), [byte, word, word, word])
        fetch = builder.module.declare_intrinsic("llvm.prefetch", [byte], fetching)
        builder.call(fetch, [builder.bitcast(place, byte), word(READ), word(KEEP), word(DATA)])
        return context.get_dummy_value()

    return types.void(table, row, column), generate


@overload(prefetch, inline="always")
def _compiled_prefetch(table, row, column):
    return lambda table, row, column: _prefetch(table, row, column)
