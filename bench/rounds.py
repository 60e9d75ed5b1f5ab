"""Times pieces of work against each other, and summarises the times.

All pieces of one comparison run in interleaved rounds in one process, in a new random order each round. A ratio is the
median over rounds of the ratio within a round, because anything that slows the machine for a while slows all pieces.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motionsplice.motion.quaternion import Floats

Work = Callable[[int], object]  # receives an increasing number, so that each call can use other data
EVICTING = np.zeros(2**26, np.uint8)  # larger than the caches of most processors
TICK = 1.0 / 60.0  # seconds


@dataclass(frozen=True)
class Summary:
    """The times of one piece of work over its rounds, in seconds per character and frame. `worst` is the slowest.

    ratios: this work's time over that of other work in the same rounds, by the other work's name.
    """

    what: str
    characters: int
    rounds: int
    median: float
    p95: float
    p99: float
    worst: float
    ratios: Mapping[str, float]


@dataclass(frozen=True)
class Slope:
    """The slope of a straight line fitted to (x, y) by least squares, and the standard error of that slope.

    `relative` and `relative_error` are both divided by the median y.
    """

    slope: float
    error: float
    relative: float
    relative_error: float


def interleaved(
    work: Mapping[str, Work], rounds: int, calls: int = 1, before: Callable[[], object] | None = None
) -> dict[str, Floats]:
    """Returns the seconds [rounds * calls] of each piece of work, which is called `calls` times a round.

    Without `before`, an untimed call warms each piece up at the start of its turn. With `before`, that function runs
    untimed before each call instead.
    """
    seconds = {name: np.empty(rounds * calls) for name in work}
    names, draw, number = list(work), np.random.default_rng(0), 0
    for round_ in range(-1, rounds):  # round -1 is a warm-up: later rounds overwrite its times
        for at in draw.permutation(len(names)):
            run = work[names[at]]
            if before is None:
                run(number - 1)
            for call in range(calls):
                if before:
                    before()
                began = time.perf_counter()
                run(number + call)
                seconds[names[at]][round_ * calls + call] = time.perf_counter() - began
        number += calls + 1
    return seconds


def paced(work: Mapping[str, Work], ticks: int) -> dict[str, Floats]:
    """Returns the seconds [ticks] of each piece of work. One piece runs per 60 Hz tick, with sleep in between."""
    seconds = {name: np.empty(ticks) for name in work}
    for run in work.values():
        run(0)
    names, draw, due = list(work), np.random.default_rng(0), time.perf_counter()
    for number in range(ticks):
        for name in (names[at] for at in draw.permutation(len(names))):
            due = max(due + TICK, time.perf_counter())
            time.sleep(max(due - time.perf_counter(), 0.0))
            began = time.perf_counter()
            work[name](number)
            seconds[name][number] = time.perf_counter() - began
    return seconds


def evict_caches() -> None:
    """Empties the processor's caches by writing more memory than they hold."""
    np.add(EVICTING, 1, out=EVICTING)


def summaries(
    seconds: Mapping[str, Floats], characters: int, against: Sequence[str] = ("naive", "copy")
) -> list[Summary]:
    """Summarises seconds [rounds] per call of `characters` characters, with ratios to the work named in `against`."""
    rows = []
    for name, times in seconds.items():
        median, p95, p99, worst = (float(value) for value in np.percentile(times, [50, 95, 99, 100]) / characters)
        ratios = {other: paired_ratio(times, seconds[other]) for other in against}
        rows.append(Summary(name, characters, len(times), median, p95, p99, worst, ratios))
    return rows


def paired_ratio(a: Floats, b: Floats) -> float:
    """Returns the median over rounds of a / b, both [rounds]."""
    return float(np.median(a / b))


def fit_slope(x: Sequence[float] | Floats, y: Sequence[float] | Floats) -> Slope:
    """Fits a line to at least three points."""
    away = np.asarray(x, np.float64) - np.mean(x)
    spread, up = float(away @ away), np.asarray(y, np.float64) - np.mean(y)
    slope = float(away @ up) / spread
    error = float(np.sqrt(np.sum((up - slope * away) ** 2) / (len(away) - 2) / spread))
    middle = float(np.median(y))
    return Slope(slope, error, slope / middle, error / middle)
