"""Poses as the numbers that go over the wire: other axes and units, normalised integers. Nothing here allocates."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.simd.compiled import Array, kernel

LARGEST = 32767  # of a normalised int16


@kernel
def convert(ours: Array, order: Array, factors: Array, out: Array) -> None:
    """Rows [n, K] float32 -> [n, K] float32: component i is ours[order[i]] times factors[i]."""
    for row in range(len(ours)):
        for i in range(len(order)):
            out[row, i] = ours[row, order[i]] * factors[i]


@kernel
def shorten(ours: Array, out: Array) -> None:
    """Numbers [n] float32 from -1 to 1 -> [n] int16, glTF's normalised form: round(32767 q)."""
    largest, half = np.float32(LARGEST), np.float32(0.5)
    for i in range(len(ours)):
        value = np.floor(ours[i] * largest + half)
        out[i] = np.int16(min(max(value, -largest), largest))
