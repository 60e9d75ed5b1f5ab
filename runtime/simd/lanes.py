"""Vector arithmetic on eight float32, in kernels and in plain Python.

Numba vectorises a loop only if it can prove that arrays do not overlap, which costs more than the loop over a row of a
few dozen joints. So kernels vectorise explicitly: `load` eight numbers, compute, `store`. In plain Python, lanes are
NumPy arrays of eight numbers, and the same code runs.
"""

from __future__ import annotations

import numpy as np
from numba.extending import overload

from motionsplice.runtime.simd.compiled import Array, Index, Real
from motionsplice.runtime.simd.lane_instructions import (
    llvm_copy_down,
    llvm_gather,
    llvm_interleave,
    llvm_load,
    llvm_root,
    llvm_scatter,
    llvm_separate,
    llvm_signed,
    llvm_spread,
    llvm_store,
    llvm_store_down,
    llvm_total,
    llvm_totals,
)
from motionsplice.runtime.simd.width import LANES


def load(table: Array, row: Index, column: Index) -> Array:
    """Loads eight neighbouring numbers of a row, from a column on."""
    return table[row, column : column + LANES]


def store(table: Array, row: Index, column: Index, lanes: Array) -> None:
    """Stores eight numbers in a row, from a column on."""
    table[row, column : column + LANES] = lanes


def spread(value: Real) -> Array:
    """Returns the same number in all lanes."""
    return np.full(LANES, value, np.float32)


def total(lanes: Array) -> Real:
    """Returns the sum of all lanes."""
    return lanes.sum()


def totals(a: Array, b: Array, c: Array, d: Array, e: Array, f: Array, g: Array, h: Array) -> Array:
    """Returns the sums of all lanes of eight vectors, in fewer instructions than eight calls of `total`."""
    return np.stack([a, b, c, d, e, f, g, h]).sum(axis=1)


def store_down(out: Array, at: Index, step: Index, lanes: Array) -> None:
    """Stores eight numbers as float64, each `step` after the one before."""
    out[at : at + LANES * step : step] = lanes


def copy_down(table: Array, place: Index, out: Array, at: Index, step: Index) -> None:
    """Copies four neighbouring numbers as float64, each `step` after the one before."""
    out[at : at + 4 * step : step] = table[place : place + 4]


def root(lanes: Array) -> Array:
    """Returns the square root of each lane."""
    return np.sqrt(lanes)


def signed(size: Array, like: Array) -> Array:
    """Returns the magnitudes of `size` with the signs of `like`."""
    return np.copysign(size, like)


def interleave(out: Array, at: Index, x: Array, y: Array, z: Array, w: Array) -> None:
    """Stores x, y, z, w of the first lane, then of the second, and so on."""
    out[at : at + 4 * LANES] = np.stack([x, y, z, w], axis=-1).ravel()


def separate(table: Array, at: Index) -> tuple[Array, Array, Array, Array]:
    """Loads x, y, z, w as `interleave` stores them."""
    x, y, z, w = table[at : at + 4 * LANES].reshape(LANES, 4).T
    return x, y, z, w


def gather(table: Array, first: Index, last: Index, column: Index) -> tuple[Array, Array, Array, Array]:
    """Loads four neighbouring columns of eight rows from `first` on, clamped to `last`."""
    rows = np.minimum(np.arange(first, first + LANES), last)
    return tuple(table[rows, column + i] for i in range(4))


def scatter(table: Array, first: Index, last: Index, column: Index, x: Array, y: Array, z: Array) -> None:
    """Stores three neighbouring columns of eight rows from `first` on, clamped to `last`."""
    rows = np.minimum(np.arange(first, first + LANES), last)
    for i, lanes in enumerate((x, y, z)):
        table[rows, column + i] = lanes


@overload(load, inline="always")
def _(table, row, column):
    return lambda table, row, column: llvm_load(table, row, column)


@overload(store, inline="always")
def _(table, row, column, lanes):
    return lambda table, row, column, lanes: llvm_store(table, row, column, lanes)


@overload(spread, inline="always")
def _(value):
    return lambda value: llvm_spread(value)


@overload(total, inline="always")
def _(lanes):
    return lambda lanes: llvm_total(lanes)


@overload(totals, inline="always")
def _(a, b, c, d, e, f, g, h):
    return lambda a, b, c, d, e, f, g, h: llvm_totals(a, b, c, d, e, f, g, h)


@overload(store_down, inline="always")
def _(out, at, step, lanes):
    return lambda out, at, step, lanes: llvm_store_down(out, at, step, lanes)


@overload(copy_down, inline="always")
def _(table, place, out, at, step):
    return lambda table, place, out, at, step: llvm_copy_down(table, place, out, at, step)


@overload(root, inline="always")
def _(lanes):
    return lambda lanes: llvm_root(lanes)


@overload(signed, inline="always")
def _(size, like):
    return lambda size, like: llvm_signed(size, like)


@overload(separate, inline="always")
def _(table, at):
    return lambda table, at: llvm_separate(table, at)


@overload(interleave, inline="always")
def _(out, at, x, y, z, w):
    return lambda out, at, x, y, z, w: llvm_interleave(out, at, x, y, z, w)


@overload(gather, inline="always")
def _(table, first, last, column):
    return lambda table, first, last, column: llvm_gather(table, first, last, column)


@overload(scatter, inline="always")
def _(table, first, last, column, x, y, z):
    return lambda table, first, last, column, x, y, z: llvm_scatter(table, first, last, column, x, y, z)
