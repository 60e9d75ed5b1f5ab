"""Compiled lanes agree with their twins, the NumPy forms in `motionsplice.runtime.simd.lanes`."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.runtime.simd.compiled import Array, Real, kernel
from motionsplice.runtime.simd.lanes import (
    copy_down,
    gather,
    interleave,
    load,
    root,
    scatter,
    separate,
    signed,
    spread,
    store,
    store_down,
    total,
    totals,
)
from motionsplice.runtime.simd.width import LANES

seeds = st.integers(0, 2**32 - 1)


@kernel
def move(table: Array, row: int, column: int, factor: Real, out: Array) -> Real:
    a, b = load(table, row, column), load(table, row + 1, column + 3)
    mixed = signed(a * spread(factor) / root(spread(np.float32(1.0)) + b * b), b) + b - a
    store(out, row, column, mixed)
    return total(mixed)


@kernel
def transpose(table: Array, first: int, last: int, column: int, rows: Array, flat: Array) -> None:
    x, y, z, w = gather(table, first, last, column)
    interleave(flat, 5, x, y, z, w)
    x, y, z, w = separate(flat, 5)
    scatter(rows, first, last, column, y, z, w)


@kernel
def sum_rows(table: Array, flat: Array, place: int, out: Array, at: int, step: int) -> None:
    a, b, c, d = load(table, 0, 1), load(table, 1, 1), load(table, 2, 1), load(table, 3, 1)
    e, f, g, h = load(table, 4, 1), load(table, 5, 1), load(table, 6, 1), load(table, 7, 1)
    store_down(out, at, step, totals(a, b, c, d, e, f, g, h))
    copy_down(flat, place, out, at + LANES * step, step)


@given(seeds, st.integers(0, 6), st.integers(0, 5), st.integers(1, 9))
def test_sums_of_eight_vectors_and_four_neighbours_are_stored_a_step_apart(
    seed: int, place: int, at: int, step: int
) -> None:
    draw = np.random.default_rng(seed)
    table = draw.normal(size=(LANES, LANES + 2)).astype(np.float32)
    flat = draw.normal(size=place + 4).astype(np.float32)
    for form in (sum_rows, getattr(sum_rows, "py_func", sum_rows)):
        out = np.full(at + step * (LANES + 4), np.nan)
        form(table, flat, place, out, at, step)
        stored = out[at::step]
        np.testing.assert_allclose(stored[:LANES], table[:, 1 : 1 + LANES].sum(axis=1, dtype=np.float64), atol=1e-5)
        np.testing.assert_array_equal(stored[LANES:], flat[place:].astype(np.float64))
        assert np.count_nonzero(~np.isnan(out)) == LANES + 4  # nothing in between


@given(seeds, st.integers(0, 2), st.integers(0, 9))
def test_lane_arithmetic_agrees_with_numpy(seed: int, row: int, column: int) -> None:
    draw = np.random.default_rng(seed)
    table, factor = draw.normal(size=(4, 20)).astype(np.float32), np.float32(draw.normal())
    compiled, plain = np.zeros((2, 4, 20), np.float32)
    found = move(table, row, column, factor, compiled)
    expected = getattr(move, "py_func", move)(table, row, column, factor, plain)
    np.testing.assert_allclose(compiled, plain, atol=1e-5)
    np.testing.assert_allclose(found, expected, atol=1e-4)
    np.testing.assert_allclose(found, compiled.sum(), atol=1e-4)


@given(seeds, st.integers(1, 20), st.integers(0, 8))
def test_gather_and_scatter_transpose_rows_and_lanes(seed: int, count: int, column: int) -> None:
    draw = np.random.default_rng(seed)
    first = int(draw.integers(0, count))
    table = draw.normal(size=(count, 12)).astype(np.float32)
    results = []
    for form in (transpose, getattr(transpose, "py_func", transpose)):
        rows, flat = np.zeros((count, 12), np.float32), np.zeros(5 + 4 * LANES, np.float32)
        form(table, first, count - 1, column, rows, flat)
        results.append((rows, flat))
    for compiled, plain in zip(*results, strict=True):
        np.testing.assert_array_equal(compiled, plain)
    here = min(LANES, count - first)
    quads = table[first : first + here, column : column + 4]
    np.testing.assert_array_equal(results[0][1][5 : 5 + 4 * here], quads.ravel())
