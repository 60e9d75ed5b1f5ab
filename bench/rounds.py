"""Times of pieces of work, taken in turns, and what is told of them.

The pieces of one comparison run in interleaved rounds in one process, in a new order each round, and a ratio is the
median over rounds of the ratio within a round: whatever slows the machine for a while slows all of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motionsplice.motion.quaternion import Floats

Work = Callable[[int], object]  # told a number that goes up, so that no two calls need ask the same
EVICTING = np.zeros(2**26, np.uint8)  # larger than the caches of most processors
TICK = 1.0 / 60.0  # seconds


@dataclass(frozen=True)
class Summary:
    """What is told of a piece of work: seconds per character-frame, over its rounds; `worst` is the slowest.

    ratios: to other work of the same rounds, by its name.
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
    """A straight line through (x, y), fitted by least squares: its slope and that slope's standard error.

    `relative` and `relative_error` are the same as parts of the median y.
    """

    slope: float
    error: float
    relative: float
    relative_error: float


def interleaved(
    work: Mapping[str, Work], rounds: int, calls: int = 1, before: Callable[[], object] | None = None
) -> dict[str, Floats]:
    """Seconds [rounds * calls] of each piece of work, so many calls a round.

    A call before them that is not timed makes them warm; unless `before` is given, which runs ahead of each, untimed.
    """
    seconds = {name: np.empty(rounds * calls) for name in work}
    names, draw, number = list(work), np.random.default_rng(0), 0
    for round_ in range(-1, rounds):  # one round more, which is not counted
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
    """Seconds [ticks] of each piece of work, when one of them, in turns, runs per 60 Hz tick, asleep in between."""
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
    """Writes more memory than the caches hold, so that what they held is gone."""
    np.add(EVICTING, 1, out=EVICTING)


def summaries(
    seconds: Mapping[str, Floats], characters: int, against: Sequence[str] = ("naive", "copy")
) -> list[Summary]:
    """What is told of times [rounds] that were taken in turns, each of as many characters; ratios are to `against`."""
    told = []
    for name, one in seconds.items():
        median, p95, p99, worst = (float(value) for value in np.percentile(one, [50, 95, 99, 100]) / characters)
        ratios = {other: paired_ratio(one, seconds[other]) for other in against}
        told.append(Summary(name, characters, len(one), median, p95, p99, worst, ratios))
    return told


def paired_ratio(a: Floats, b: Floats) -> float:
    """The median over rounds of a [rounds] over b [rounds]."""
    return float(np.median(a / b))


def fit_slope(x: Sequence[float] | Floats, y: Sequence[float] | Floats) -> Slope:
    """The line through at least three points."""
    away = np.asarray(x, np.float64) - np.mean(x)
    spread, up = float(away @ away), np.asarray(y, np.float64) - np.mean(y)
    slope = float(away @ up) / spread
    error = float(np.sqrt(np.sum((up - slope * away) ** 2) / (len(away) - 2) / spread))
    middle = float(np.median(y))
    return Slope(slope, error, slope / middle, error / middle)
