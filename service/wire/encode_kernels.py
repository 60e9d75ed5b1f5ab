"""Kernels that convert poses to other axes and units, and to normalised integers. They do not allocate."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.simd.compiled import Array, kernel

LARGEST = 32767  # of a normalised int16


@kernel
def convert(ours: Array, order: Array, factors: Array, out: Array) -> None:
    """Converts rows [n, K] float32: component i of `out` is component order[i] of `ours` times factors[i]."""
    for row in range(len(ours)):
        for i in range(len(order)):
            out[row, i] = ours[row, order[i]] * factors[i]


@kernel
def shorten(ours: Array, out: Array) -> None:
    """Converts numbers [n] float32 from -1 to 1 to int16 [n] in glTF's normalised form: round(32767 q)."""
    largest, half = np.float32(LARGEST), np.float32(0.5)
    for i in range(len(ours)):
        value = np.floor(ours[i] * largest + half)
        out[i] = np.int16(min(max(value, -largest), largest))
