"""The processor's prefetch instruction, which Numba does not offer."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from motionsplice.runtime.simd.compiled import Array, Index

READ, KEEP, DATA = 0, 3, 1  # LLVM's numbers


def prefetch(table: Array, row: Index, column: Index) -> None:
    """Prefetches the cache line of an element of a C-contiguous table; does nothing in plain Python."""


def prefetch_at(numbers: Array, at: Index) -> None:
    """Prefetches the cache line of an element of a flat array; does nothing in plain Python."""


@intrinsic
def _prefetch_at(_, numbers, at):
    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        _fetch(builder, builder.gep(array.data, [arguments[1]]))
        return context.get_dummy_value()

    return types.void(numbers, at), generate


@intrinsic
def _prefetch(_, table, row, column):
    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        place = builder.mul(arguments[1], builder.extract_value(array.shape, 1))
        _fetch(builder, builder.gep(array.data, [builder.add(place, arguments[2])]))
        return context.get_dummy_value()

    return types.void(table, row, column), generate


def _fetch(builder, place):
    byte, word = ir.IntType(8).as_pointer(), ir.IntType(32)
    fetching = ir.FunctionType(ir.VoidType(), [byte, word, word, word])
    fetch = builder.module.declare_intrinsic("llvm.prefetch", [byte], fetching)
    builder.call(fetch, [builder.bitcast(place, byte), word(READ), word(KEEP), word(DATA)])


@overload(prefetch_at, inline="always")
def _compiled_prefetch_at(numbers, at):
    return lambda numbers, at: _prefetch_at(numbers, at)


@overload(prefetch, inline="always")
def _compiled_prefetch(table, row, column):
    return lambda table, row, column: _prefetch(table, row, column)
