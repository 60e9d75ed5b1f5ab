"""Plain dynamic time warping of hands, for comparison, with several features."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.hands.sequences import RATE, Sequence
from motionsplice.motion.quaternion import Floats, about, rotate
from motionsplice.precompute.hands.align import BANDS
from motionsplice.precompute.hands.banded_warp import Band, cheapest_path, medians, straight_band
from motionsplice.precompute.hands.phases import derivatives
from motionsplice.precompute.hands.points import HandMotion


def from_trunk(hand: HandMotion) -> Floats:
    """Returns the points [F, 4, 3] of a hand, turned by the trunk's heading."""
    assert hand.trunk is not None
    return rotate(about([0.0, 1.0, 0.0], -hand.trunk)[:, None], hand.points)


def differences(hand: HandMotion) -> Floats:
    """Returns first and second derivatives [F, 8, 3], relative to the trunk, by differences of neighbouring frames."""
    velocity = np.gradient(from_trunk(hand), 1.0 / RATE, axis=0)
    return np.concatenate([velocity, np.gradient(velocity, 1.0 / RATE, axis=0)], axis=1)


def filtered(hand: HandMotion) -> Floats:
    """Returns the same derivatives through a bell-shaped filter, as our method does; m/s, and m/s per 0.1 s."""
    found = derivatives(from_trunk(hand), RATE)
    return np.concatenate([found.velocity, 0.1 * found.acceleration], axis=1)


def scaled_by_spread(values: Floats) -> Floats:
    """Divides first and second derivatives each by their standard deviation over the clip."""
    return np.concatenate([part / np.std(part) for part in np.split(values, 2, axis=1)], axis=1)


def warped(one: Sequence, feature: Callable[[HandMotion], Floats]) -> Floats:
    """Returns the frame of the hands clip for each frame [F] of the body.

    Uses plain dynamic time warping of the features [F, n, 3] of both hands, in the band of our first pass.
    """
    ours, theirs = (
        np.concatenate([feature(hand).reshape(len(hand.points), -1) for hand in side], axis=1)
        for side in (one.body, one.hands)
    )
    band = straight_band(len(ours), len(theirs), BANDS[0], [])
    return medians(cheapest_path(distances(ours, theirs, band), band.low, band.high), len(ours))


def distances(ours: Floats, theirs: Floats, band: Band) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    """Returns the squared distances [F, width] of features inside the band."""
    costs = np.zeros((len(ours), band.width), np.float32)
    for row, low, high, feature in zip(costs, band.low, band.high, ours, strict=True):
        row[: high - low + 1] = np.sum((theirs[low : high + 1] - feature) ** 2, axis=1)
    return costs
