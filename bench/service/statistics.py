"""Statistics of how even a stream is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def jitter(arrivals: Sequence[float], numbers: Sequence[int], rate: float) -> Floats:
    """Returns how far each arrival is from its place on the regular grid that fits all best, in milliseconds."""
    late = np.asarray(arrivals) - np.asarray(numbers) / rate
    return np.asarray(1e3 * np.abs(late - np.median(late)))


def intervals(arrivals: Sequence[float], rate: float) -> Floats:
    """Returns how far each interval between arrivals is from 1 / rate, in milliseconds."""
    return np.asarray(1e3 * np.abs(np.diff(np.asarray(arrivals)) - 1.0 / rate))


def lost(numbers: Sequence[int]) -> int:
    """Returns the number of frames missing between the first and the last."""
    return int(np.maximum(np.diff(np.asarray(numbers)) - 1, 0).sum())


def percentiles(values: Floats) -> tuple[float, float]:
    """Returns the median and the 99th percentile."""
    return float(np.percentile(values, 50)), float(np.percentile(values, 99))
