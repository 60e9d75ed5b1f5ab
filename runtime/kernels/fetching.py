"""Prefetches the rows of later characters, a few lines at a time while those of earlier ones are sampled.

A core waits for about a dozen lines at once, and holds up what comes after further prefetches. So they are spread
among the arithmetic.
"""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.format.rows import LINE
from motionsplice.runtime.simd.compiled import Array, Index, inlined
from motionsplice.runtime.simd.prefetch import prefetch

ONE, FOUR, TO_NEXT_LINE = np.uint64(1), np.uint64(4), np.uint64(LINE)


@inlined
def fetch_rows(table: Array, row: Index) -> None:
    """Prefetches a row of a table and the next one."""
    for column in range(0, 2 * table.shape[1], LINE):
        prefetch(table, row, column)


@inlined
def fetch_rotations(table: Array, row: Index, first: Index, lane: Index) -> None:
    """Prefetches a part of the rotations of a row and the next one, whose columns begin at `first`.

    The parts at lanes 0, 8, 16 and so on are all of them, apart from the last line where `first` is within a line.
    """
    column = first + FOUR * lane
    prefetch(table, row, column)
    prefetch(table, row + ONE, column)
    prefetch(table, row, column + TO_NEXT_LINE)
    prefetch(table, row + ONE, column + TO_NEXT_LINE)


@inlined
def fetch_cloud(table: Array, row: Index, first: Index) -> None:
    """Prefetches what a row and the next one have besides rotations, whose columns begin at `first`."""
    for column in range(np.uint64(0), first, TO_NEXT_LINE):
        prefetch(table, row, column)
        prefetch(table, row + ONE, column)
