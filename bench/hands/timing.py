"""The time that the alignment of a hand takes."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np

from bench.findings import Findings
from bench.hands.sequences import RATE, hands_of, noisy
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.precompute.hands.align import BANDS, align_hands


def timing() -> Findings:
    """Measures the seconds of an alignment, warm, the median of 20, and how it grows with the number of frames."""
    findings = Findings("Seconds to align one hand, warm")
    seconds = {}
    for frames in (569, 1138, 2276):
        pair = gesture_pair(5, gestures=frames // 40, seconds=(frames - 1) / RATE, hand="right")
        draw = np.random.default_rng(0)
        body, hands = noisy(hands_of(pair.body), draw)[1:], noisy(hands_of(pair.hands), draw)[1:]
        bands = BANDS[0] * 569 / frames, BANDS[1] * 569 / frames  # equally many frames wide at each length
        seconds[frames] = median_seconds(partial(align_hands, body, hands, RATE, bands=bands))
    findings.add("569 frames (the paper: 10.95)", seconds[569], "{:.4f}", most=0.1)
    for shorter, longer in pairwise(seconds):
        findings.add(
            f"{longer} frames / {shorter} frames, bands of equal width", seconds[longer] / seconds[shorter], "{:.2f}"
        )
    return findings


def median_seconds(work: Callable[[], object]) -> float:
    """Runs work 21 times and returns the median seconds of all runs but the first, which warms up."""
    seconds = []
    for _ in range(21):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return float(np.median(seconds[1:]))
