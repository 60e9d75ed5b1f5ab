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
    found, around = [], np.zeros(len(standing) + 2, np.uint8)
    around[1:-1] = standing
    for foot, bit in FEET.items():
        stands = around & bit
        edges = np.flatnonzero(stands[1:] != stands[:-1])  # down, one after the last frame, down, and so on
        downs, ups = (edges[::2] / rate).tolist(), ((edges[1::2] - 1) / rate).tolist()
        found += [Contact(foot, down, up) for down, up in zip(downs, ups, strict=True)]
    return sorted(found, key=lambda one: (one.down, one.foot))
