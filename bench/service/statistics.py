"""How even a stream is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def jitter(arrivals: Sequence[float], numbers: Sequence[int], rate: float) -> Floats:
    """How far each frame's arrival is from its place on the even grid that fits all of them best, milliseconds."""
    late = np.asarray(arrivals) - np.asarray(numbers) / rate
    return np.asarray(1e3 * np.abs(late - np.median(late)))


def intervals(arrivals: Sequence[float], rate: float) -> Floats:
    """How far the time between each two arrivals is from that between two frames, milliseconds."""
    return np.asarray(1e3 * np.abs(np.diff(np.asarray(arrivals)) - 1.0 / rate))


def lost(numbers: Sequence[int], ahead: int = 1) -> int:
    """Frames that are missing between the first and the last message, of `ahead` frames each."""
    steps = np.diff(np.asarray(numbers))
    return int(np.maximum(steps - ahead, 0).sum())


def percentiles(values: Floats) -> tuple[float, float]:
    """The median and the 99th percentile."""
    return float(np.percentile(values, 50)), float(np.percentile(values, 99))
