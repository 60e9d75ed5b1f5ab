from __future__ import annotations

import gc
import weakref
from typing import Annotated, NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.runtime.simd.compiled import Array
from motionsplice.runtime.simd.handle import Handle, handle_of, record_at

PAIR = np.dtype([("number", np.int32), ("share", np.float64)], align=True)
compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="a handle is the record")  # type: ignore[attr-defined]


class Tables(NamedTuple):
    rows: Annotated[Array, np.float32, 2]
    marks: Annotated[Array, np.uint8, 1]


class Work(NamedTuple):
    tables: Tables
    reach: float
    points: Annotated[Array, np.float64, 3]
    pairs: Annotated[Array, PAIR, 1]


@numba.njit()  # noqa: TID251
def copy_all(handle: Handle, rows: Array, marks: Array, points: Array, pairs: Array) -> float:
    """Copies all arrays of a Work, erases its points, and returns its number."""
    work = record_at(handle, Work)
    rows[:], marks[:] = work.tables.rows, work.tables.marks
    points[:] = work.points
    work.points[:] = -1.0
    for at in range(len(work.pairs)):
        pairs[at]["number"], pairs[at]["share"] = work.pairs[at]["number"], work.pairs[at]["share"]
    return work.reach


def drawn(shape: tuple[int, int, int], seed: int) -> Work:
    draw = np.random.default_rng(seed)
    pairs = np.zeros(shape[2], PAIR)
    pairs["number"], pairs["share"] = draw.integers(-9, 9, shape[2]), draw.random(shape[2])
    tables = Tables(draw.random(shape[:2], np.float32), draw.integers(0, 255, shape[1], np.uint8))
    return Work(tables, float(draw.random()), draw.random(shape), pairs)


@given(shape=st.tuples(*[st.integers(0, 4)] * 3), seed=st.integers(0, 2**32 - 1))
def test_a_kernel_finds_in_a_handle_what_the_record_holds(shape: tuple[int, int, int], seed: int) -> None:
    work, expected = drawn(shape, seed), drawn(shape, seed)
    copies = [np.zeros_like(array) for array in (*work.tables, work.points, work.pairs)]
    assert copy_all(handle_of(work), *copies) == expected.reach
    for copied, array in zip(copies, (*expected.tables, expected.points, expected.pairs), strict=True):
        np.testing.assert_array_equal(copied, array)
    assert np.all(work.points == -1.0)  # the kernel has the arrays themselves


def test_a_handle_keeps_the_arrays() -> None:
    work = drawn((2, 3, 4), 0)
    array, handle = weakref.ref(work.points), handle_of(work)
    part = handle[:] if isinstance(handle, np.ndarray) else handle  # and so does a view of it
    del work, handle
    gc.collect()
    assert array() is not None
    del part
    gc.collect()
    assert array() is None


@compiled_only
def test_a_handle_cannot_be_written() -> None:
    handle = handle_of(drawn((1, 1, 1), 0))
    with pytest.raises(ValueError, match="read-only"):
        handle[0] = 0
    with pytest.raises(ValueError, match="WRITEABLE"):
        handle.flags.writeable = True


@pytest.mark.parametrize(
    "points",
    [np.zeros((2, 2, 2), np.float32), np.zeros((2, 2)), np.zeros((2, 2, 4))[:, :, ::2], np.zeros((2, 2, 2)).T[::-1]],
)
def test_an_array_of_another_form_is_refused(points: Array) -> None:
    with pytest.raises(TypeError, match="expected 3 dimensions of float64"):
        handle_of(drawn((1, 1, 1), 0)._replace(points=points))
