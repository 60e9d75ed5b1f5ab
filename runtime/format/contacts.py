"""Foot contacts: bits of the table `contacts`, and times at which feet are on the ground."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEFT_FOOT, RIGHT_FOOT = 1, 2  # bits of the table `contacts`
FEET = {"left": LEFT_FOOT, "right": RIGHT_FOOT}


class Contact(NamedTuple):
    """A period during which a foot is on the ground.

    Attributes:
        foot: `left` or `right`.
        down: Seconds into the clip at which the foot touches down.
        up: Seconds into the clip at which it lifts off.
    """

    foot: str
    down: float
    up: float


def which_stand(standing: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Returns whether the left and the right foot stand [..., 2], from bits of standing feet [...]."""
    return np.stack([standing & bit > 0 for bit in FEET.values()], axis=-1)


def contacts_of(standing: NDArray[np.uint8], rate: float) -> list[Contact]:
    """Returns the contacts of a clip in order of time, from the bits of standing feet at each frame [F]."""
    found, around = [], np.zeros(len(standing) + 2, np.uint8)
    around[1:-1] = standing
    for foot, bit in FEET.items():
        stands = around & bit
        edges = np.flatnonzero(stands[1:] != stands[:-1])  # first frame down, first frame up, and so on
        downs, ups = (edges[::2] / rate).tolist(), ((edges[1::2] - 1) / rate).tolist()
        found += [Contact(foot, down, up) for down, up in zip(downs, ups, strict=True)]
    return sorted(found, key=lambda one: (one.down, one.foot))
