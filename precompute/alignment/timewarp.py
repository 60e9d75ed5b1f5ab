"""The papers' pairwise time alignment: a slope-limited path through the distance grid.

Heck et al. 2006, 3.1, with the dynamic programme of Kovar and Gleicher 2003. Its cost is quadratic in the clips'
length. The bank aligns clips to a ring instead (`precompute.alignment.ring`); this is the reference for the ring.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from motionsplice.motion.errors import ClipError
from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.pointcloud import planar_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.alignment.increasing_spline import fit_increasing

MEETING_WINDOW = 5  # frames
MOST_FLAT_STEPS = 3  # horizontal or vertical steps in a row: the path's slope stays between 1/4 and 4
KNOT_SPACING = 0.2  # seconds
EQUAL = 1e-9  # square metres: mean costs that differ by less are equal
MOST_CELLS = 30_000_000  # of the grid: three minutes by three at 30 Hz, in about 0.7 GB


@dataclass(frozen=True, eq=False)
class TimeWarp:
    """The time alignment lambda(t): locomotion frame -> action frame.

    path:       [steps, 2] cells (locomotion frame, action frame) of the uncropped grid.
    curve:      the increasing spline through the path: locomotion frame -> action frame.
    first:      number of frames cropped from the action's start.
    mean_cost:  mean squared distance along the path, square metres.
    """

    path: NDArray[np.int64]
    curve: BSpline[np.float64]
    first: int
    mean_cost: float


def align_pair(locomotion: Floats, action: Floats, rate: float) -> TimeWarp:
    """Aligns the lower clouds [frames, p, 3] of two clips, both at `rate` frames per second.

    The action is cropped where it first matches the locomotion's first frame. The path runs from that corner of the
    grid to the cell on the top or right edge that gives it the least mean cost. Raises ClipError for a grid of more
    than MOST_CELLS cells.
    """
    first = first_meeting(locomotion, action)
    if len(locomotion) * (len(action) - first) > MOST_CELLS:
        seconds = [frames / rate for frames in (len(locomotion), len(action) - first)]
        raise ClipError(
            f"clips of {seconds[0]:.0f} s and {seconds[1]:.0f} s are too long to compare all pairs of frames",
            mend="Use the bank's splice (--method splice), which takes clips of any length",
        )
    grid = planar_distances(locomotion, action[first:])
    path = _best_path(*cheapest_paths(grid, MOST_FLAT_STEPS))
    mean_cost = float(grid[path[:, 0], path[:, 1]].mean())
    curve = fit_increasing(path[:, 0], path[:, 1] + first, KNOT_SPACING * rate)
    return TimeWarp(path + np.array([0, first]), curve, first, mean_cost)


def first_meeting(locomotion: Floats, action: Floats) -> int:
    """Returns the first frame of the action that matches the locomotion's first frame.

    It is the first local minimum of the distance that is near the overall minimum. The papers compare single frames.
    A single frame with the knees side by side does not show which knee moves forward, so here MEETING_WINDOW frames are
    compared as one cloud.
    """
    start = windowed(locomotion[:MEETING_WINDOW], len(locomotion[:MEETING_WINDOW]))
    row = planar_distances(start, windowed(action, len(locomotion[:MEETING_WINDOW])))[0]
    near = row <= row.min() + 0.25 * (np.median(row) - row.min())
    padded = np.concatenate([[np.inf], row, [np.inf]])
    lowest = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:])
    return int(np.flatnonzero(near & lowest)[0])


@compiled(nogil=True)
def cheapest_paths(grid: Floats, most_flat: int) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Returns the least cost of a path from cell (0, 0) to each cell on the two far edges, and how to trace it back.

    A state says how a path came to a cell, with w = `most_flat`: state 0 by a diagonal step, states 1..w by that many
    steps in a row along the first axis, states w+1..2w along the second. Returns the costs by state in the last row
    [m, 2w+1] and the last column [n, 2w+1], inf for unreachable states, and the previous state of every state of every
    cell [n, m, 2w+1]. Only two rows of costs are held at a time.
    """
    rows, columns = grid.shape
    states = 2 * most_flat + 1
    in_row = np.full((2, columns, states), np.inf)
    last_column = np.empty((rows, states))
    came = np.zeros((rows, columns, states), np.int8)
    for i in range(rows):
        above, cost = in_row[(i + 1) % 2], in_row[i % 2]
        cost[:] = np.inf
        if i == 0:
            cost[0, 0] = grid[0, 0]
        for j in range(columns):
            here = grid[i, j]
            if i > 0 and j > 0:
                best = 0
                for state in range(1, states):
                    if above[j - 1, state] < above[j - 1, best]:
                        best = state
                cost[j, 0] = above[j - 1, best] + here
                came[i, j, 0] = best
            for axis in range(2):
                if (i if axis == 0 else j) == 0:
                    continue
                before = above[j] if axis == 0 else cost[j - 1]
                low = 1 + axis * most_flat
                turn = 0  # a first flat step may follow a diagonal step, or a flat step along the other axis
                other = 1 + (1 - axis) * most_flat
                for state in range(other, other + most_flat):
                    if before[state] < before[turn]:
                        turn = state
                cost[j, low] = before[turn] + here
                came[i, j, low] = turn
                for run in range(1, most_flat):
                    cost[j, low + run] = before[low + run - 1] + here
                    came[i, j, low + run] = low + run - 1
        last_column[i] = cost[columns - 1]
    return in_row[(rows - 1) % 2], last_column, came


def _best_path(last_row: Floats, last_column: Floats, came: NDArray[np.int8]) -> NDArray[np.int64]:
    """Returns the path [steps, 2] to the top or right edge with the least mean cost per cell."""
    rows, columns = len(last_column), len(last_row)
    best_mean, best_path = np.inf, np.zeros((1, 2), np.int64)
    edge = {(rows - 1, j): last_row[j] for j in range(1, columns)}
    edge |= {(i, columns - 1): last_column[i] for i in range(1, rows)}
    for i, j in sorted(edge, key=sum, reverse=True):  # longest first: a clip may end in still frames
        state = int(np.argmin(edge[i, j]))
        if np.isinf(edge[i, j][state]):
            continue
        path = trace(came, i, j, state)
        mean = float(edge[i, j][state]) / len(path)
        if mean < best_mean - EQUAL:
            best_mean, best_path = mean, path
    return best_path


@compiled(nogil=True)
def trace(came: NDArray[np.int8], i: int, j: int, state: int) -> NDArray[np.int64]:
    """Returns the cheapest path [steps, 2] from (0, 0) that arrives at (i, j) in this state."""
    most_flat = (came.shape[2] - 1) // 2
    path = np.empty((i + j + 1, 2), np.int64)
    steps = 0
    while True:
        path[steps, 0], path[steps, 1] = i, j
        steps += 1
        if i == 0 and j == 0:
            break
        before = int(came[i, j, state])
        if state == 0:
            i, j = i - 1, j - 1
        elif state <= most_flat:
            i -= 1
        else:
            j -= 1
        state = before
    return path[:steps][::-1].copy()
