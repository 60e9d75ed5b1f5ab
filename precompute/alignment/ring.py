"""Alignment of a clip to one cycle, a ring of phase cells, in time linear in the clip's length.

This is the bank's form of time alignment (Heck's thesis, 4.3: align each motion to a baseline locomotion). The
baseline is one stride. A path may go round the ring any number of times, so clips may have any length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats

MOST_ADVANCE = 4  # cells per frame
MOST_ZERO_STEPS = 3  # frames in a row that stay in one cell
STEADINESS = 0.05  # of the mean distance: what a frame costs whose step is one cell off the clip's mean step


def wind_steadily(distances: Floats) -> NDArray[np.int64]:
    """Returns the cheapest path round the ring, as `wind` does, but one that hurries and waits less.

    Legs that are like no frame of the baseline, in a run around a walk's ring or in a side-step, hold the path in the
    few cells that are a little nearer than others. Against that, each frame also pays for the square of how far its
    step is off the mean step. So that the ends do not drift off their stride for it, the path goes on for a stride
    beyond both, past the distances of the first and the last stride once more.
    """
    frames, cells = distances.shape
    wound = wind(distances)
    pace = float(wound[-1] - wound[0]) / (frames - 1)
    stride = min(round(cells / max(pace, cells / frames)), frames)
    longer = np.concatenate([distances[:stride], distances, distances[-stride:]])
    steadiness = STEADINESS * float(distances.mean())
    steady = walk_ring(longer, pace, steadiness)[stride : stride + frames]
    return np.asarray(steady - steady[0] // cells * cells)


def wind(distances: Floats) -> NDArray[np.int64]:
    """Returns the cheapest path round the ring: the cell of each frame [frames], counted on through every lap.

    `distances` [frames, cells] are in square metres, from each frame at the working rate to each cell. The path may
    start and end anywhere. It advances 0 to MOST_ADVANCE cells per frame; a frame that advances several cells costs
    the mean of their distances.
    """
    passes = np.ascontiguousarray(distances)
    return walk_ring(passes, 0.0, 0.0)


def between_cells(distances: Floats, wound: NDArray[np.int64]) -> Floats:
    """Returns the places [frames] on the ring of a path `wound` round it, each at the minimum of a parabola.

    The parabola goes through the distances of the path's cell and both of its neighbours.
    """
    frames, cells = np.arange(len(wound)), distances.shape[1]
    at, before, after = (distances[frames, (wound + shift) % cells] for shift in (0, -1, 1))
    bend = before - 2.0 * at + after
    return np.asarray(wound + np.clip(0.5 * (before - after) / np.where(bend > 0.0, bend, np.inf), -0.5, 0.5))


@compiled(nogil=True, error_model="numpy")
def walk_ring(distances: Floats, pace: float, steadiness: float) -> NDArray[np.int64]:
    """Runs the dynamic programme of `wind`, over states (cell, number of zero steps in a row).

    A frame also costs `steadiness` times the square of its step less `pace`, in cells.
    """
    frames, cells = distances.shape
    cost = np.full((cells, MOST_ZERO_STEPS + 1), np.inf)
    cost[:, 0] = distances[0]
    following = np.empty_like(cost)
    least, unsteady = np.empty(cells), np.empty(MOST_ADVANCE + 1)  # of a cell's states; of a step
    for step in range(MOST_ADVANCE + 1):
        unsteady[step] = steadiness * (step - pace) ** 2
    advance = np.zeros((frames, cells), np.int8)  # into state (cell, 0): by how many cells,
    zeros = np.zeros((frames, cells), np.int8)  # and after how many zero steps
    for frame in range(1, frames):
        for cell in range(cells):
            least[cell] = cost[cell, 0]
            for run in range(1, MOST_ZERO_STEPS + 1):
                if cost[cell, run] < least[cell]:
                    least[cell] = cost[cell, run]
        for cell in range(cells):
            lowest, price, passed, source = np.inf, 0.0, 0.0, cell
            origin = -1
            for step in range(1, MOST_ADVANCE + 1):
                passed += distances[frame, source]
                source = source - 1 if source > 0 else cells - 1
                extra = passed / step + unsteady[step]
                if least[source] + extra < lowest:
                    lowest, price, origin = least[source] + extra, extra, source
                    advance[frame, cell] = step
            following[cell, 0] = lowest
            run = 0
            while origin >= 0 and cost[origin, run] + price > lowest:
                run += 1
            zeros[frame, cell] = run
            for run in range(1, MOST_ZERO_STEPS + 1):
                following[cell, run] = cost[cell, run - 1] + distances[frame, cell] + unsteady[0]
        cost, following = following, cost
    best = int(np.argmin(cost))
    cell, run = best // (MOST_ZERO_STEPS + 1), best % (MOST_ZERO_STEPS + 1)
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
