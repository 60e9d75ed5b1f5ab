"""The baseline, one stride of one locomotion, to which every clip is aligned (Heck's thesis, 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError
from motionsplice.motion.pointcloud import level, planar_distances, planar_lag_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.half_cycle import symmetric_phases
from motionsplice.precompute.alignment.ring import wind
from motionsplice.precompute.alignment.whole_cycle import STRIDES, find_period, played_on
from motionsplice.precompute.alignment.working_rate import (
    WORKING_RATE,
    paths_at_working_rate,
    support_at_working_rate,
)
from motionsplice.precompute.body.contacts import foot_contacts, left_strike
from motionsplice.precompute.body.facing import facing, facing_joints

LOOP_WINDOW = 5  # frames at the working rate
WORST_LOOP = 0.15  # largest distance of a stride's ends, divided by the distance of its halves
LEAST_SWING = 0.05  # leg lengths: the least distance between the two halves of a stride
OTHER_GAIT = 0.15  # leg lengths between strides: those farther apart are other gaits, however far
MOST_CANDIDATES = 16  # strides that are compared with all others
AT_A_TIME = 256  # strides: their distances from a candidate take 20 kB each


@dataclass(frozen=True, eq=False)
class Baseline:
    """One stride of a locomotion as a ring of cells, evenly spaced in time.

    start, end: seconds in the clip. loop: distance of the stride's ends divided by the distance of its halves.
    leg: leg length, metres. zero: the real-valued cell at which the left foot touches down; there phases are whole
    numbers. clouds: [cells, 3, 3] lower clouds, metres. support: [cells, 2] how firmly both feet stand, 0 to 1.
    """

    name: str
    start: float
    end: float
    loop: float
    leg: float
    zero: float
    clouds: Floats
    support: Floats

    @cached_property
    def _phases(self) -> Floats:
        return symmetric_phases(level(self.clouds))

    def phase_at(self, place: ArrayLike) -> Floats:
        """Returns the phase, in cycles, at places on the ring, real-valued cells counted on through every lap.

        Half a cycle later is where the stride's mirror image is. At `zero` the phase is a whole number.
        """
        lap, cell = np.divmod(np.append(place, self.zero), len(self.clouds))
        phase = lap + np.interp(cell, np.arange(len(self._phases)), self._phases)
        return np.asarray(phase[:-1] - phase[-1])


def find_baseline(clip: Clip, roles: Roles) -> Baseline:
    """Returns the stride of a clip whose end is most like its start.

    A stride is a pair of moments with similar surroundings, while the moment halfway between them differs. This
    excludes standing still, and two strides at once. A clip that is one whole cycle is a stride itself. Raises
    BaselineError if the clip has no stride.
    """
    return _whole_cycle(clip, roles) or _best_stride(clip, roles)


def _best_stride(clip: Clip, roles: Roles) -> Baseline:
    """Returns the stride within a clip whose ends match best. Raises BaselineError if none match."""
    windows = windowed(paths_at_working_rate(clip, roles.lower_cloud), LOOP_WINDOW)
    leg = roles.leg_length(clip.skeleton)
    best = (np.inf, 0, 0)
    shortest, longest = (round(seconds * WORKING_RATE) for seconds in STRIDES)
    lengths = range(shortest, min(longest, len(windows) - 1) + 1)
    apart = planar_lag_distances(windows, {*lengths, *(length // 2 for length in lengths)})
    for length in lengths:
        loops = apart[length]
        swing = apart[length // 2][: len(loops)]
        moving = swing > LOOP_WINDOW * 3 * (LEAST_SWING * leg) ** 2
        loop = np.where(moving, loops / np.where(moving, swing, 1.0), np.inf)
        frame = int(np.argmin(loop))
        best = min(best, (float(loop[frame]), frame + LOOP_WINDOW // 2, length))
    loop_distance, first, length = best
    if loop_distance > WORST_LOOP:
        raise no_stride(clip.name)
    step = clip.duration / (len(windows) + LOOP_WINDOW - 2)
    start, end = first * step, (first + length) * step
    standing = foot_contacts(clip, roles)
    strike = left_strike(standing, clip.rate, start, end)
    zero = 0.0 if strike is None else (strike - start) / step
    ring = _ring(clip, roles, standing, slice(first, first + length + 1))
    return Baseline(clip.name, start, end, loop_distance, leg, zero, *ring)


def _whole_cycle(clip: Clip, roles: Roles) -> Baseline | None:
    """Returns a clip that is one whole cycle of a gait as a stride; None if it is not a cycle, or several."""
    period = find_period(clip, roles)
    if period is None:
        return None
    played, leg = played_on(clip, period, roles), roles.leg_length(clip.skeleton)
    lap = played.frames(period, 2 * period + 1)
    ring = _ring(lap, roles, foot_contacts(lap, roles), slice(None))
    windows = windowed(paths_at_working_rate(played, roles.lower_cloud), LOOP_WINDOW)
    cells, moving = len(ring[0]), LOOP_WINDOW * 3 * (LEAST_SWING * leg) ** 2
    apart = planar_lag_distances(windows, (round(cells / 2), round(cells / 3)))  # small in two or three strides
    swings = [float(distances.mean()) for distances in apart.values()]
    if min(swings) <= max(moving, WORST_LOOP * max(swings)):
        return None
    seconds = period / clip.rate
    strike = left_strike(foot_contacts(played, roles), clip.rate, seconds, 2.0 * seconds)
    zero = 0.0 if strike is None else (strike / seconds - 1.0) * cells
    return Baseline(clip.name, 0.0, seconds, 0.0, leg, zero, *ring)


def no_stride(name: str) -> BaselineError:
    """Returns the error for a clip without a stride."""
    return BaselineError(
        f"clip {name!r} has no stride of {STRIDES[0]} to {STRIDES[1]} s whose end matches its start",
        mend="Name another clip with --baseline; a plain walk of a few steps is best",
    )


def most_typical(strides: Sequence[Baseline]) -> Baseline:
    """Returns the stride nearest to all `strides`, among the MOST_CANDIDATES whose ends match best.

    Two laps of each stride are wound round each candidate's ring, so the cost is linear in the number of strides. The
    sum is over distances, not their squares, and each counts at most OTHER_GAIT. Otherwise one run among walks would
    favour a stride halfway between walk and run, which is like neither, and jumps and dances would count most.
    """
    candidates = sorted(strides, key=lambda stride: (stride.loop, stride.name))[:MOST_CANDIDATES]
    rings = [level(candidate.clouds / candidate.leg) for candidate in candidates]
    apart = [0.0] * len(rings)
    for first in range(0, len(strides), AT_A_TIME):
        twice = [level(np.tile(one.clouds / one.leg, (2, 1, 1))) for one in strides[first : first + AT_A_TIME]]
        together, ends = np.concatenate(twice), np.cumsum([len(clouds) for clouds in twice])
        for number, ring in enumerate(rings):
            for distances in np.split(planar_distances(together, ring), ends[:-1]):
                wound = wind(distances) % len(ring)
                apart[number] += min(float(np.sqrt(distances[np.arange(len(wound)), wound].mean())), OTHER_GAIT)
    return min(zip(apart, candidates, strict=True), key=lambda pair: (pair[0], pair[1].name))[1]


def _ring(clip: Clip, roles: Roles, standing: NDArray[np.uint8], stride: slice) -> tuple[Floats, Floats]:
    """Returns the lower clouds [cells, 3, 3] and the support [cells, 2] of one stride.

    An even drift is added to the clouds, so that the stride ends at its start.
    """
    clouds = facing(paths_at_working_rate(clip, facing_joints(roles)))[stride]
    along = np.linspace(0.0, 1.0, len(clouds))[:, None, None]
    closed = (clouds - along * (clouds[-1] - clouds[0]))[:-1]
    return closed, support_at_working_rate(clip, standing)[stride][:-1]
