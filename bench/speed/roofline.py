"""How fast a splice could be at most: its bytes and operations, against the bandwidth and arithmetic of this machine.

Bytes are those that any implementation must read and write. Operations are additions, multiplications, divisions and
square roots of float32, counted by hand from the method (docs/bank.md), without the padding of vectors.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.rows import FIRST_JOINT
from motionsplice.runtime.requests import REQUEST
from motionsplice.runtime.simd.compiled import kernel

LINE = 64  # bytes
LOOK_UPS = 3 * 2 + 5 * 1  # cache lines: of two clips' entries, and of phases and cells
SLERP = 8 + 2 * 12 + 12 + 14  # dot product, two series of four terms, blend, normalisation
POINT = 6 * 3 + 9 * 2 + 12  # of both clouds: interpolation, correlation matrix, and its bound
HORN = 92 + 8 * 19 + 36 + 50 + 20  # quartic, eight steps to its root, eigenvector
PRODUCTS, LOOKING_UP = 6 * 28 + 11, 80
MOVED = 2**28  # bytes of a copy that is larger than all caches
RESIDENT = 2**17  # bytes of a copy that fits into the second-level cache
DEGREE, LANES = 64, 2**11  # degree and number of the polynomials that time the arithmetic


@dataclass(frozen=True)
class Roofline:
    """Bytes and operations per character and frame, and the speed of the machine.

    memory, cache: bytes per second of a copy, read plus written, from memory and within the cache. arithmetic:
    operations per second. The properties are the seconds per character and frame that follow.
    """

    bytes: int
    operations: int
    memory: float
    cache: float
    arithmetic: float

    @property
    def from_memory(self) -> float:
        return self.bytes / self.memory

    @property
    def from_cache(self) -> float:
        return self.bytes / self.cache

    @property
    def computing(self) -> float:
        return self.operations / self.arithmetic


def measure(bank: Bank) -> Roofline:
    """Measures the roofline of a splice of a bank's clips on one core of this machine."""
    return Roofline(splice_bytes(bank), splice_operations(bank), copied(MOVED, 5), copied(RESIDENT, 2000), computed())


def splice_bytes(bank: Bank) -> int:
    """Returns the bytes read and written by a splice: two rows of each table, look-ups, the request and the pose."""
    rows = sum(2 * 4 * half.columns for half in bank.layout.halves.values())
    return rows + LOOK_UPS * LINE + REQUEST.itemsize + 4 * (3 + 4 * bank.skeleton.joint_count)


def splice_operations(bank: Bank) -> int:
    """Returns the operations of a splice with posture `relative`."""
    lanes = sum(FIRST_JOINT + len(half.joints) for half in bank.layout.halves.values())
    return lanes * SLERP + bank.layout.points * POINT + HORN + PRODUCTS + LOOKING_UP


def copied(size: int, times: int) -> float:
    """Returns the bytes per second, read plus written, of a copy of `size` bytes; the median of `times` copies."""
    source, target = np.ones((2, size), np.uint8)
    return 2.0 * size / _median_seconds(lambda: np.copyto(target, source), times)


def computed() -> float:
    """Returns the operations per second of polynomials, whose arithmetic runs at the machine's best speed."""
    x, out = np.linspace(0.0, 1.0, LANES, dtype=np.float32), np.empty(LANES, np.float32)
    polynomial = kernel(_polynomial)
    polynomial(x, out)
    return 2.0 * DEGREE * LANES / _median_seconds(lambda: polynomial(x, out), 500)


def _polynomial(x: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    for i in range(len(x)):
        value = x[i]
        for _ in range(DEGREE):
            value = value * x[i] + np.float32(0.5)
        out[i] = value


def _median_seconds(work: Callable[[], object], times: int) -> float:
    seconds = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - began)
    return float(np.median(seconds))
