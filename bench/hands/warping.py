"""Plain dynamic time warping of hands, by the features that are compared with ours."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.hands.sequences import RATE, Sequence
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.precompute.hands.align import BANDS
from motionsplice.precompute.hands.banded_warp import Band, cheapest_path, medians, straight_band
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion


def seen(hand: HandMotion) -> Floats:
    """Points [F, 4, 3] as seen from the trunk."""
    assert hand.trunk is not None
    return rotate(about([0.0, 1.0, 0.0], -hand.trunk)[:, None], hand.points)


def differences(hand: HandMotion) -> Floats:
    """First and second derivatives [F, 8, 3] as seen from the trunk, from neighbouring frames."""
    velocity = np.gradient(seen(hand), 1.0 / RATE, axis=0)
    return np.concatenate([velocity, np.gradient(velocity, 1.0 / RATE, axis=0)], axis=1)


def filtered(hand: HandMotion) -> Floats:
    """The same from a bell of frames, as our own are; metres per second, and per second in 0.1 s."""
    found = derivatives(seen(hand), RATE)
    return np.concatenate([found.velocity, 0.1 * found.acceleration], axis=1)


def evened(values: Floats) -> Floats:
    """Derivatives as a part of what each usually is in its clip."""
    return np.concatenate([one / np.std(one) for one in np.split(values, 2, axis=1)], axis=1)


def warped(one: Sequence, feature: Callable[[HandMotion], Floats]) -> Floats:
    """Plain dynamic time warping [F] by the features [F, n, 3] of both hands, in the band of the first pass."""
    ours, theirs = (
        np.concatenate([feature(hand).reshape(len(hand.points), -1) for hand in side], axis=1)
        for side in (one.body, one.hands)
    )
    band = straight_band(len(ours), len(theirs), BANDS[0], [])
    return medians(cheapest_path(distances(ours, theirs, band), band.low, band.high), len(ours))


def distances(ours: Floats, theirs: Floats, band: Band) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    costs = np.zeros((len(ours), band.width), np.float32)
    for row, low, high, one in zip(costs, band.low, band.high, ours, strict=True):
        row[: high - low + 1] = np.sum((theirs[low : high + 1] - one) ** 2, axis=1)
    return costs
