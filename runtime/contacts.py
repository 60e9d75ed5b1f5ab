"""Feet and what they stand on, as banks, characters and their events tell of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEFT_FOOT, RIGHT_FOOT = 1, 2  # bits of the table `contacts`
FEET = {"left": LEFT_FOOT, "right": RIGHT_FOOT}


class Contact(NamedTuple):
    """A foot (`left` or `right`) that stands from `down` to `up`, seconds into its clip."""

    foot: str
    down: float
    up: float


def contacts_of(standing: NDArray[np.uint8], rate: float) -> list[Contact]:
    """The contacts of a clip, given which feet stand at each frame [F], in order of time."""
    found = []
    for foot, bit in FEET.items():
        edges = np.diff(np.concatenate([[0], (standing & bit) // bit, [0]]).astype(np.int8))
        downs, ups = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
        found += [Contact(foot, down / rate, (up - 1) / rate) for down, up in zip(downs, ups, strict=True)]
    return sorted(found, key=lambda one: (one.down, one.foot))
