"""Phases of a ring's cells such that the mirror image of a stride is at the same place half a cycle later.

A captured stride's two steps are not equally long. In evenly spaced phases, a step to the left would lie up to a few
hundredths of a cycle off the step to the right of a mirror image. Let m(x) be the place on the ring that the mirror
image of place x is most like. Its own mirror image is x again, one cycle later. So g(x) = x + (m(x) - x - 1/2) / 2 has
g(m(x)) = g(x) + 1/2.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.pointcloud import planar_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.twins import MIRROR
from motionsplice.precompute.alignment.ring import between_cells, wind

WINDOW = 5  # cells: a single cloud is also like the one half a stride later, turned around
SMOOTHING = 2.0  # cells: standard deviation of the filter of m(x) - x
UNLIKE = 0.1  # of the mean distance: a stride whose mirror image is farther from it, as in a curve, keeps even phases


def symmetric_phases(clouds: Floats) -> Floats:
    """Returns the phases [cells + 1] of a ring's cells, and of its first cell one cycle later; rising, from 0.

    clouds: [cells, 3, 3] of root, left and right knee, about their mean height. Phases are even if the stride is unlike
    its mirror image.
    """
    cells = len(clouds)
    ring, image = (_windows(points) for points in (clouds, clouds[:, [0, 2, 1]] * MIRROR))
    distances = planar_distances(np.tile(image, (3, 1, 1)), ring)
    wound = wind(distances)
    lap = np.arange(cells, 2 * cells)  # between two others, so that its ends are no ends of the path
    even = np.arange(cells + 1) / cells
    if distances[lap, wound[lap] % cells].mean() > UNLIKE * distances.mean():
        return even
    ahead = (between_cells(distances, wound)[lap] - lap) / cells - 0.5
    ahead -= np.round(ahead.mean())
    moved = even + 0.5 * np.resize(gaussian_filter1d(ahead, SMOOTHING, mode="wrap"), cells + 1)
    return np.asarray(moved - moved[0])


def _windows(clouds: Floats) -> Floats:
    """Returns the clouds [cells, 3 WINDOW, 3] of WINDOW cells around each cell of a ring."""
    half = WINDOW // 2
    return windowed(np.concatenate([clouds[-half:], clouds, clouds[:half]]), WINDOW)
