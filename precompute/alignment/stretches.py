"""The stretches of a clip that stands for a while and walks for a while.

In a standing stretch the legs hardly move, so the phase found there is noise. It is replaced by one that runs on
steadily, at the clip's own mean pace.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from motionsplice.motion.pointcloud import planar_distance
from motionsplice.motion.quaternion import Floats

SMOOTHING = 0.5  # seconds over which the swing is averaged
SHORTEST = 1.5  # seconds: a shorter stretch belongs to those around it


@dataclass(frozen=True)
class Stretch:
    """A part of a clip, in seconds, in which its legs stand or walk."""

    begin: float
    end: float
    stands: bool


def standing_frames(windows: Floats, half: int, least: float, rate: float) -> NDArray[np.bool_]:
    """Returns in which windows [n, p, 3] the legs hardly move, where this lasts for SHORTEST.

    Legs hardly move if a window and the one `half` a stride later, with this window in the middle of both, are closer
    than `least`: a root-mean-square distance in metres. `rate` is in windows per second.
    """
    count, points = len(windows), windows.shape[1]
    stands = np.zeros(count, np.bool_)
    if count <= half:
        return stands
    apart = planar_distance(windows[:-half], windows[half:]) / points
    padded = np.concatenate([np.repeat(apart[0], half // 2), apart, np.repeat(apart[-1], half - half // 2)])
    stands = uniform_filter1d(padded, round(SMOOTHING * rate), mode="nearest") < least**2
    for wanted in (True, False):  # a short step in place does not end a stretch, so these are filled first
        for begin, end in runs(stands):
            if stands[begin] != wanted and end - begin < SHORTEST * rate:
                stands[begin:end] = wanted
    return stands


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Returns the first index of each run of equal flags [n], and the first index after it."""
    edges = [0, *(np.flatnonzero(np.diff(flags)) + 1).tolist(), len(flags)]
    return list(pairwise(edges))


def steadied(cycles: Floats, stands: NDArray[np.bool_]) -> Floats:
    """Returns phases [n] that run on steadily where a clip stands; elsewhere their steps are as they were.

    The pace is the mean of all walking stretches, adapted so that a stretch between two of them takes as many cycles as
    before, give or take whole ones.
    """
    steps = np.diff(cycles)
    pace = steps[~(stands[1:] & stands[:-1])].mean()
    for begin, end in runs(stands):
        if stands[begin]:
            within = steps[begin : end - 1]
            change = pace * len(within) - within.sum()
            if begin > 0 and end < len(stands):
                change = np.round(change)
            within[:] = (within.sum() + change) / len(within)
    return np.concatenate([cycles[:1], cycles[0] + np.cumsum(steps)])


def stretches_of(stands: NDArray[np.bool_], seconds: float) -> tuple[Stretch, ...]:
    """Returns the stretches of a clip that lasts so many `seconds`; none if it only stands or only walks."""
    found, step = runs(stands), seconds / (len(stands) - 1)
    if len(found) == 1:
        return ()
    edges = [0.0, *(step * (begin - 0.5) for begin, _ in found[1:]), seconds]
    return tuple(
        Stretch(first, last, bool(stands[begin]))
        for (begin, _), (first, last) in zip(found, pairwise(edges), strict=True)
    )
