from __future__ import annotations

import numba
import numpy as np
import pytest

from motionsplice.runtime.simd.compiled import Array
from motionsplice.runtime.simd.entry import entry_of


@numba.njit()  # noqa: TID251
def scaled_sum(numbers: Array, scale: float) -> float:
    """Returns the sum of numbers [n, m] times a scale, and erases the first number."""
    total = 0.0
    for row in range(numbers.shape[0]):
        for column in range(numbers.shape[1]):
            total += numbers[row, column]
    numbers[0, 0] = 0.0
    return scale * total


def test_an_entry_does_what_the_kernel_does_with_any_extents_and_numbers() -> None:
    entry = entry_of(scaled_sum, np.zeros((1, 1)), 0.0)
    for shape, scale in (((1, 1), 2.0), ((3, 4), 2), ((2, 5), np.float32(0.5))):
        numbers = np.arange(1.0, 1.0 + np.prod(shape)).reshape(shape)
        assert entry(numbers, scale) == scale * np.arange(1.0, 1.0 + np.prod(shape)).sum()
        assert numbers[0, 0] == 0.0  # the kernel has the array itself


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="Python takes any type")  # type: ignore[attr-defined]
def test_an_entry_refuses_numbers_of_another_size() -> None:
    with pytest.raises(TypeError):
        entry_of(scaled_sum, np.zeros((1, 1)), 0.0)(np.zeros((2, 2), np.float32), 1.0)
