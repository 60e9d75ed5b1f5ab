"""The papers' pairwise time alignment: a slope-limited path through the distance grid.

Heck et al. 2006, 3.1, with the dynamic programme of Kovar and Gleicher 2003. It is quadratic in the clips'
length; the bank aligns to a ring instead (`precompute.ring`), and this is what the ring is judged against.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from motion.pointcloud import planar_distances, windowed
from motion.quaternion import Floats
from precompute.increasing_spline import fit_increasing

MEETING_WINDOW = 5  # frames
MOST_FLAT_STEPS = 3  # in a row, horizontal or vertical: the path's slope stays within 1/4 and 4
KNOT_SPACING = 0.2  # seconds
EQUAL = 1e-9  # square metres of mean cost


@dataclass(frozen=True, eq=False)
class TimeWarp:
    """lambda(t): which frame of the action goes with which frame of the locomotion.

    path:       [steps, 2] cells (locomotion frame, action frame) of the uncropped grid.
    curve:      the increasing spline through the path: locomotion frame -> action frame.
    first:      frames cropped from the action's start.
    mean_cost:  mean squared distance along the path, square metres.
    """

    path: NDArray[np.int64]
    curve: BSpline[np.float64]
    first: int
    mean_cost: float


def align_pair(locomotion: Floats, action: Floats, rate: float) -> TimeWarp:
    """The time alignment curve of two clips' lower clouds [frames, p, 3], both at `rate` frames per second.

    The action is cropped where it first meets the locomotion's first frame; the path then runs from that corner
    to the top or right edge, whichever cell on them ends the path of least mean.
    """
    first = first_meeting(locomotion, action)
    grid = planar_distances(locomotion, action[first:])
    cost, came = cheapest_paths(grid, MOST_FLAT_STEPS)
    path = _best_path(cost, came)
    mean_cost = float(grid[path[:, 0], path[:, 1]].mean())
    curve = fit_increasing(path[:, 0], path[:, 1] + first, KNOT_SPACING * rate)
    return TimeWarp(path + np.array([0, first]), curve, first, mean_cost)


def first_meeting(locomotion: Floats, action: Floats) -> int:
    """The action's first frame that is like the locomotion's first: a local minimum near the least distance of all.

    A single frame with the knees side by side does not show which one is going forward, so a few frames are
    compared as one cloud, where the papers compare one.
    """
    start = windowed(locomotion[:MEETING_WINDOW], len(locomotion[:MEETING_WINDOW]))
    row = planar_distances(start, windowed(action, len(locomotion[:MEETING_WINDOW])))[0]
    near = row <= row.min() + 0.25 * (np.median(row) - row.min())
    padded = np.concatenate([[np.inf], row, [np.inf]])
    lowest = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:])
    return int(np.flatnonzero(near & lowest)[0])


@njit(cache=True, nogil=True)
def cheapest_paths(grid: Floats, most_flat: int) -> tuple[Floats, NDArray[np.int8]]:
    """Least cost of a path from cell (0, 0) to every cell, by state, and the state before each.

    State 0 came diagonally; 1..w came by that many steps along the first axis in a row, w+1..2w along the
    second. Returns costs [n, m, 2w+1] (inf where no path leads) and previous states of the same shape.
    """
    rows, columns = grid.shape
    states = 2 * most_flat + 1
    cost = np.full((rows, columns, states), np.inf)
    came = np.zeros((rows, columns, states), np.int8)
    cost[0, 0, 0] = grid[0, 0]
    for i in range(rows):
        for j in range(columns):
            if i == 0 and j == 0:
                continue
            here = grid[i, j]
            if i > 0 and j > 0:
                best = 0
                for state in range(1, states):
                    if cost[i - 1, j - 1, state] < cost[i - 1, j - 1, best]:
                        best = state
                cost[i, j, 0] = cost[i - 1, j - 1, best] + here
                came[i, j, 0] = best
            for axis in range(2):
                if (i if axis == 0 else j) == 0:
                    continue
                before = cost[i - 1, j] if axis == 0 else cost[i, j - 1]
                low = 1 + axis * most_flat
                turn = 0  # a first flat step may follow a diagonal one or a flat one along the other axis
                other = 1 + (1 - axis) * most_flat
                for state in range(other, other + most_flat):
                    if before[state] < before[turn]:
                        turn = state
                cost[i, j, low] = before[turn] + here
                came[i, j, low] = turn
                for run in range(1, most_flat):
                    cost[i, j, low + run] = before[low + run - 1] + here
                    came[i, j, low + run] = low + run - 1
    return cost, came


def _best_path(cost: Floats, came: NDArray[np.int8]) -> NDArray[np.int64]:
    """The path [steps, 2] that ends on the top or right edge with the least mean cost per cell."""
    rows, columns, _ = cost.shape
    best_mean, best_path = np.inf, np.zeros((1, 2), np.int64)
    edge = {(rows - 1, j) for j in range(1, columns)} | {(i, columns - 1) for i in range(1, rows)}
    for i, j in sorted(edge, key=sum, reverse=True):  # of equals the longest, for a clip may end in still frames
        if np.isinf(cost[i, j].min()):
            continue
        path = trace(cost, came, i, j)
        mean = float(cost[i, j].min()) / len(path)
        if mean < best_mean - EQUAL:
            best_mean, best_path = mean, path
    return best_path


@njit(cache=True, nogil=True)
def trace(cost: Floats, came: NDArray[np.int8], i: int, j: int) -> NDArray[np.int64]:
    """The cheapest path [steps, 2] from (0, 0) to (i, j)."""
    most_flat = (cost.shape[2] - 1) // 2
    path = np.empty((i + j + 1, 2), np.int64)
    state = int(np.argmin(cost[i, j]))
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
