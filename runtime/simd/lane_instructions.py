"""LLVM vectors of eight float32: their type in Numba, and the instructions for each function of `runtime.simd.lanes`.

Indices are not checked, and negative indices do not count from the end.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

from motionsplice.runtime.simd.compiled import FASTMATH
from motionsplice.runtime.simd.width import LANES

VECTOR = ir.VectorType(ir.FloatType(), LANES)
FLAGS = tuple(sorted(FASTMATH))
# lanes of two vectors, 8 and more of the second: their first halves and their last; of each half, the first pairs and
# the last; the same with the lanes of both in turns
HALVES = [0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]
PAIRS = [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]
TURNS = [0, 8, 1, 9, 4, 12, 5, 13], [2, 10, 3, 11, 6, 14, 7, 15]


class LanesType(types.Type):
    """The Numba type of eight float32."""

    def __init__(self) -> None:
        super().__init__("lanes")


lanes_type = LanesType()


@register_model(LanesType)
class LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, VECTOR)


def _define(operation, instruction):
    @type_callable(operation)
    def typed(_):
        return lambda a, b: lanes_type if lanes_type == a == b else None

    @lower_builtin(operation, lanes_type, lanes_type)
    def lowered(_, builder, __, arguments):
        return getattr(builder, instruction)(*arguments, flags=FLAGS)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _define(_operation, _instruction)


def _address(context, builder, kind, array, indices):
    """Returns the address of an element, without a check of its indices."""
    array = context.make_array(kind)(context, builder, array)
    offset = indices[0]
    for axis, index in enumerate(indices[1:], 1):
        offset = builder.add(builder.mul(offset, builder.extract_value(array.shape, axis)), index)
    return builder.bitcast(builder.gep(array.data, [offset]), VECTOR.as_pointer())


@intrinsic
def llvm_load(_, table, row, column):
    def generate(context, builder, signature, arguments):
        place = _address(context, builder, signature.args[0], arguments[0], arguments[1:])
        return builder.load(place, align=4)

    return lanes_type(table, row, column), generate


@intrinsic
def llvm_store(_, table, row, column, lanes):
    def generate(context, builder, signature, arguments):
        place = _address(context, builder, signature.args[0], arguments[0], arguments[1:3])
        builder.store(arguments[3], place, align=4)
        return context.get_dummy_value()

    return types.void(table, row, column, lanes), generate


@intrinsic
def llvm_spread(_, value):
    def generate(context, builder, signature, arguments):
        first = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), arguments[0], ir.Constant(ir.IntType(32), 0))
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(first, first, everywhere)

    return lanes_type(types.float32), generate


@intrinsic
def llvm_total(_, lanes):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.FloatType(), [ir.FloatType(), VECTOR])
        add = builder.module.declare_intrinsic(f"llvm.vector.reduce.fadd.v{LANES}f32", [], kind)
        return builder.call(add, [ir.Constant(ir.FloatType(), 0.0), arguments[0]], fastmath=FLAGS)

    return types.float32(lanes), generate


@intrinsic
def llvm_totals(_, a, b, c, d, e, f, g, h):
    def generate(context, builder, signature, arguments):
        def folded(one, other, near, far):
            near, far = (_shuffled(builder, one, other, order) for order in (near, far))
            return builder.fadd(near, far, flags=FLAGS)

        singles = [0, 2, 8, 10, 4, 6, 12, 14], [1, 3, 9, 11, 5, 7, 13, 15]
        a, b, c, d = (folded(arguments[i], arguments[i + 4], *HALVES) for i in range(4))
        return folded(folded(a, b, *PAIRS), folded(c, d, *PAIRS), *singles)

    return lanes_type(a, b, c, d, e, f, g, h), generate


@intrinsic
def llvm_store_down(_, out, at, step, lanes):
    def generate(context, builder, signature, arguments):
        out, at, step, lanes = arguments
        _store_down(context, builder, signature.args[0], out, at, step, lanes)
        return context.get_dummy_value()

    return types.void(out, at, step, lanes), generate


@intrinsic
def llvm_copy_down(_, table, place, out, at, step):
    def generate(context, builder, signature, arguments):
        table, place, out, at, step = arguments
        place = _address(context, builder, signature.args[0], table, [place])
        quad = builder.load(builder.bitcast(place, ir.VectorType(ir.FloatType(), 4).as_pointer()), align=4)
        _store_down(context, builder, signature.args[2], out, at, step, quad)
        return context.get_dummy_value()

    return types.void(table, place, out, at, step), generate


def _store_down(context, builder, kind, out, at, step, vector):
    """Stores numbers as float64, each `step` after the one before."""
    count = vector.type.count
    wide = builder.fpext(vector, ir.VectorType(ir.DoubleType(), count))
    first = context.make_array(kind)(context, builder, out).data
    for lane in range(count):
        number = builder.extract_element(wide, ir.Constant(ir.IntType(32), lane))
        builder.store(number, builder.gep(first, [builder.add(at, builder.mul(step, ir.Constant(step.type, lane)))]))


@intrinsic
def llvm_root(_, lanes):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(VECTOR, [VECTOR])
        take = builder.module.declare_intrinsic(f"llvm.sqrt.v{LANES}f32", [], kind)
        return builder.call(take, arguments, fastmath=FLAGS)

    return lanes_type(lanes), generate


@intrinsic
def llvm_signed(_, size, like):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(VECTOR, [VECTOR, VECTOR])
        copy = builder.module.declare_intrinsic(f"llvm.copysign.v{LANES}f32", [], kind)
        return builder.call(copy, arguments)

    return lanes_type(size, like), generate


@intrinsic
def llvm_interleave(_, out, at, x, y, z, w):
    def generate(context, builder, signature, arguments):
        x, y, z, w = arguments[2:]
        xy, zw = ([_shuffled(builder, a, b, order) for order in TURNS] for a, b in ((x, y), (z, w)))
        joints = [_shuffled(builder, xy[half], zw[half], order) for half in (0, 1) for order in PAIRS]
        rows = [_shuffled(builder, joints[pair], joints[pair + 1], order) for order in HALVES for pair in (0, 2)]
        place = _address(context, builder, signature.args[0], arguments[0], arguments[1:2])
        for number, row in enumerate(rows):
            builder.store(row, builder.gep(place, [ir.Constant(ir.IntType(64), number)]), align=4)
        return context.get_dummy_value()

    return types.void(out, at, x, y, z, w), generate


def _rows(builder, first, last):
    """Yields eight rows from `first` on, clamped to `last`."""
    for number in range(LANES):
        row = builder.add(first, ir.Constant(first.type, number))
        yield builder.select(builder.icmp_signed("<", row, last), row, last)


def _shuffled(builder, a, b, order):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(order)), order))


def _transposed(builder, quads):
    """Transposes eight vectors of four numbers into four vectors of eight."""
    pairs = [_shuffled(builder, quads[i], quads[i + 4], list(range(8))) for i in range(4)]  # rows i and i + 4
    mixed = [_shuffled(builder, pairs[i], pairs[i + 1], order) for i in (0, 2) for order in TURNS]
    x, y = (_shuffled(builder, mixed[0], mixed[2], order) for order in PAIRS)
    z, w = (_shuffled(builder, mixed[1], mixed[3], order) for order in PAIRS)
    return x, y, z, w


@intrinsic
def llvm_separate(_, table, at):
    def generate(context, builder, signature, arguments):
        kind = ir.VectorType(ir.FloatType(), 4)
        place = _address(context, builder, signature.args[0], arguments[0], arguments[1:])
        place = builder.bitcast(place, kind.as_pointer())
        places = [builder.gep(place, [ir.Constant(ir.IntType(64), number)]) for number in range(LANES)]
        quads = [builder.load(one, align=4) for one in places]
        return context.make_tuple(builder, signature.return_type, _transposed(builder, quads))

    return types.UniTuple(lanes_type, 4)(table, at), generate


@intrinsic
def llvm_gather(_, table, first, last, column):
    def generate(context, builder, signature, arguments):
        table, first, last, column = arguments
        kind = ir.VectorType(ir.FloatType(), 4)
        quads = []
        for row in _rows(builder, first, last):
            place = _address(context, builder, signature.args[0], table, (row, column))
            quads.append(builder.load(builder.bitcast(place, kind.as_pointer()), align=4))
        return context.make_tuple(builder, signature.return_type, _transposed(builder, quads))

    return types.UniTuple(lanes_type, 4)(table, first, last, column), generate


@intrinsic
def llvm_scatter(_, table, first, last, column, x, y, z):
    def generate(context, builder, signature, arguments):
        table, first, last, column, *columns = arguments
        for lane, row in enumerate(_rows(builder, first, last)):
            place = _address(context, builder, signature.args[0], table, (row, column))
            place = builder.bitcast(place, ir.FloatType().as_pointer())
            for number, lanes in enumerate(columns):
                value = builder.extract_element(lanes, ir.Constant(ir.IntType(32), lane))
                builder.store(value, builder.gep(place, [ir.Constant(ir.IntType(64), number)]), align=4)
        return context.get_dummy_value()

    return types.void(table, first, last, column, x, y, z), generate
