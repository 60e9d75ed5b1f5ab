"""Alignment of a clip to one cycle, a ring of phase cells, in time linear in the clip's length.

This is the bank's form of time alignment (Heck's thesis, 4.3: align each motion to a baseline locomotion). The
baseline is one stride. A path may go round the ring any number of times, so clips may have any length.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.quaternion import Floats

MOST_ADVANCE = 4  # cells per frame
MOST_ZERO_STEPS = 3  # frames in a row that stay in one cell
STEADINESS = 0.1  # of the mean distance: what a frame costs whose step is one cell off the pace around it
PACE_WINDOW = 10  # frames: standard deviation of the window over which that pace is the mean


def wind_steadily(distances: Floats) -> NDArray[np.int64]:
    """Returns the cheapest path round the ring, as `wind` does, but one that hurries and waits less.

    Legs that are like no frame of the baseline, in a run over a walk's ring or in a side-step, hold the path in the few
    cells that are a little nearer than others. Against that, each frame also pays for the square of how far its step is
    off the mean step around it, on the path without this cost.
    """
    passes = np.ascontiguousarray(distances)
    pace = gaussian_filter1d(np.gradient(wind(passes).astype(np.float64)), PACE_WINDOW, mode="nearest")
    return walk_ring(passes, pace, STEADINESS * float(passes.mean()), MOST_ADVANCE, MOST_ZERO_STEPS)


def wind(distances: Floats) -> NDArray[np.int64]:
    """Returns the cheapest path round the ring: the cell of each frame [frames], counted on through every lap.

    `distances` [frames, cells] are in square metres, from each frame at the working rate to each cell. The path may
    start and end anywhere. It advances 0 to MOST_ADVANCE cells per frame; a frame that advances several cells costs
    the mean of their distances.
    """
    passes = np.ascontiguousarray(distances)
    return walk_ring(passes, np.zeros(len(passes)), 0.0, MOST_ADVANCE, MOST_ZERO_STEPS)


@njit(cache=True, nogil=True)
def walk_ring(
    distances: Floats, pace: Floats, steadiness: float, most_advance: int, most_zero: int
) -> NDArray[np.int64]:
    """Runs the dynamic programme of `wind`, over states (cell, number of zero steps in a row).

    A frame also costs `steadiness` times the square of its step less its `pace` [frames], in cells.
    """
    frames, cells = distances.shape
    cost = np.full((cells, most_zero + 1), np.inf)
    cost[:, 0] = distances[0]
    following = np.empty_like(cost)
    advance = np.zeros((frames, cells), np.int8)  # into state (cell, 0): by how many cells,
    zeros = np.zeros((frames, cells), np.int8)  # and after how many zero steps
    for frame in range(1, frames):
        waiting = steadiness * pace[frame] ** 2
        for cell in range(cells):
            following[cell, 0] = np.inf
            passed = 0.0
            for step in range(1, most_advance + 1):
                passed += distances[frame, (cell - step + 1) % cells]
                source = (cell - step) % cells
                price = passed / step + steadiness * (step - pace[frame]) ** 2
                for run in range(most_zero + 1):
                    total = cost[source, run] + price
                    if total < following[cell, 0]:
                        following[cell, 0] = total
                        advance[frame, cell] = step
                        zeros[frame, cell] = run
            for run in range(1, most_zero + 1):
                following[cell, run] = cost[cell, run - 1] + distances[frame, cell] + waiting
        cost, following = following, cost
    best = int(np.argmin(cost))
    cell, run = best // (most_zero + 1), best % (most_zero + 1)
    wound = np.empty(frames, np.int64)
    position = 0
    for frame in range(frames - 1, -1, -1):
        wound[frame] = position
        if run > 0:
            run -= 1
        elif frame > 0:
            step = int(advance[frame, cell])
            run = int(zeros[frame, cell])
            cell = (cell - step) % cells
            position -= step
    return wound - wound[0] + cell
