"""Built-in motions cut to one whole cycle, as game engines loop them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.procedural.library import make

RATE, FIRST = 240.0, 60  # frames per second, and the first frame of cycles, of the motions that are cut
SHORTEST, LONGEST = 150, 400  # frames of a cycle


@cache
def motion_of(locomotion: str, action: str | None = None) -> Clip:
    return make(locomotion, action, seed=1, seconds=7.0, rate=RATE)


@cache
def seconds_of(locomotion: str) -> float:
    """Returns the seconds of a cycle of a built-in locomotion: where its joints are first as they were."""
    rotations = motion_of(locomotion).rotations[:, 1:]
    lags = np.arange(SHORTEST, LONGEST)
    gaps = np.array([np.sqrt(np.mean(quaternion.angle(rotations[300], rotations[300 + lag]) ** 2)) for lag in lags])
    at = next(i for i in range(1, len(gaps)) if gaps[i] < 0.02 and gaps[i] <= gaps[i - 1 : i + 2].min())
    before, here, after = gaps[at - 1 : at + 2]
    return float(lags[at] + 0.5 * (before - after) / (before - 2.0 * here + after)) / RATE


def cut(
    locomotion: str,
    action: str | None = None,
    *,
    rate: float = 30.0,
    start: float = 0.0,
    cycles: float = 1.0,
    open_end: bool = False,
    in_place: bool = False,
) -> Clip:
    """Returns cycles of a built-in motion, from `start` in cycles, a whole number of frames long.

    With `open_end`, the clip ends one frame before the pose that it begins with. The tempo is changed by up to half a
    frame.
    """
    clip, seconds = motion_of(locomotion, action), seconds_of(locomotion)
    period = round(cycles * seconds * rate)
    along = np.arange(period + (not open_end)) / period
    first, length = FIRST + start * seconds * RATE, cycles * seconds * RATE
    positions, rotations = clip.sampled(first + along * length)
    if in_place:
        ends = clip.sampled([first, first + length])[0]
        positions = positions - along[:, None] * (ends[1] - ends[0]) * [1.0, 0.0, 1.0]
    return replace(clip, name="loop", rate=rate, root_positions=positions, rotations=rotations)
