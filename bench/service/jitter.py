"""How regularly frames come, and which do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from motion.quaternion import Floats


@dataclass
class Arrivals:
    """When the messages of one connection came, seconds, and of each the number of its first frame and how many."""

    times: list[float] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Jitter:
    """Of all connections together: seconds, medians and 99th percentiles; `worst` is the largest `off_grid`."""

    messages: int
    lost: int
    off_grid: float
    off_grid_p99: float
    worst: float
    off_interval: float
    off_interval_p99: float


def jitter(connections: Sequence[Arrivals], rate: float) -> Jitter:
    """What is told of connections that have two messages at least, at so many frames per second."""
    grid = np.concatenate([off_grid(one.times, one.frames, rate) for one in connections])
    between = np.concatenate([off_interval(one.times, one.frames, rate) for one in connections])
    return Jitter(
        messages=len(grid),
        lost=sum(lost(one.frames, one.counts) for one in connections),
        off_grid=float(np.median(grid)),
        off_grid_p99=float(np.percentile(grid, 99)),
        worst=float(grid.max()),
        off_interval=float(np.median(between)),
        off_interval_p99=float(np.percentile(between, 99)),
    )


def off_grid(times: ArrayLike, frames: ArrayLike, rate: float) -> Floats:
    """How far each arrival is from when its frame should be there, seconds [n].

    The grid goes through the median arrival: through the first, one that came late would make all others early.
    """
    late = np.asarray(times, np.float64) - np.asarray(frames, np.float64) / rate
    return np.abs(late - np.median(late))


def off_interval(times: ArrayLike, frames: ArrayLike, rate: float) -> Floats:
    """How much longer or shorter the time between two arrivals is than that between their frames, seconds [n - 1]."""
    late = np.asarray(times, np.float64) - np.asarray(frames, np.float64) / rate
    return np.abs(np.diff(late))


def lost(frames: Sequence[int], counts: Sequence[int]) -> int:
    """Frames that are missing between messages, which begin with `frames` and have `counts`.

    Those that were sent anew after a command are not missing, though they make numbers go back.
    """
    return sum(max(0, after - before - count) for before, count, after in zip(frames, counts, frames[1:], strict=False))
