"""How long the alignment of a hand takes."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from bench.findings import Findings
from bench.hands.sequences import RATE, hands_of, noisy
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.precompute.hands.align import BANDS, align_hands


def timing() -> Findings:
    """Seconds that an alignment takes, warm, the median of 20, and how that grows."""
    told = Findings("Seconds for one hand, warm")
    taken = {}
    for frames in (569, 1138, 2276):
        pair = gesture_pair(5, gestures=frames // 40, seconds=(frames - 1) / RATE, hand="right")
        draw = np.random.default_rng(0)
        body, hands = noisy(hands_of(pair.body), draw)[1:], noisy(hands_of(pair.hands), draw)[1:]
        bands = BANDS[0] * 569 / frames, BANDS[1] * 569 / frames  # as many frames wide
        taken[frames] = clocked(lambda body=body, hands=hands, bands=bands: align_hands(body, hands, RATE, bands=bands))  # type: ignore[misc]
    told.add("569 frames (the paper: 10.95)", taken[569], "{:.4f}", most=0.1)
    for shorter, longer in pairwise(taken):
        told.add(f"{longer} frames over {shorter}, bands as many frames wide", taken[longer] / taken[shorter], "{:.2f}")
    return told


def clocked(work: Callable[[], object]) -> float:
    seconds = []
    for _ in range(21):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return float(np.median(seconds[1:]))
