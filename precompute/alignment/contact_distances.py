"""Which foot stands: a cue to the phase, beside where the knees are.

In a gait that is unlike the baseline's, as a side-step is unlike a walk, the knees pass each other at other moments of
the stride. The feet still touch down and lift off in turn.
"""

from __future__ import annotations

import numpy as np

from motionsplice.motion.quaternion import Floats

WEIGHT = 0.1  # leg lengths of root and knees that a foot is worth which stands in one of both only


def contact_distances(support: Floats, ring: Floats, leg: float) -> Floats:
    """Returns what the feet add to the distances of frames to the cells of a ring [n, cells], square metres.

    support: [n, 2] how firmly both feet stand, 0 to 1. ring: [cells, 2], likewise. leg: leg length, metres.
    """
    left, right = ((support[:, foot, None] - ring[:, foot]) ** 2 for foot in range(2))
    return np.asarray((WEIGHT * leg) ** 2 * (left + right))
