"""The baseline, one stride of one locomotion, and the alignment of every clip to it (Heck's thesis, 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError, ClipError
from motionsplice.motion.pointcloud import planar_distances, planar_lag_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.arm_swing import arm_joints, arm_swing, swing_distances
from motionsplice.precompute.alignment.half_cycle import symmetric_phases
from motionsplice.precompute.alignment.increasing_spline import fit_increasing
from motionsplice.precompute.alignment.ring import between_cells, wind, wind_steadily
from motionsplice.precompute.alignment.stretches import Stretch, runs, standing_frames, steadied, stretches_of
from motionsplice.precompute.alignment.whole_cycle import STRIDES, find_period, played_on
from motionsplice.precompute.body.contacts import left_strike
from motionsplice.precompute.body.facing import facing, facing_joints
from motionsplice.precompute.body.joint_paths import joint_paths

WORKING_RATE = 30.0  # frames per second at which motions are compared
KNOT_SPACING = 0.1  # seconds
STIFFNESS = 1.0  # of the phase curve, against changes of its slope
SLOWEST = 0.5  # of the clip's mean slope: the least slope of its phase curve
LOOP_WINDOW = 5  # frames at the working rate
WORST_LOOP = 0.15  # largest distance of a stride's ends, divided by the distance of its halves
LEAST_SWING = 0.05  # leg lengths: the least distance between the two halves of a stride
LEAST_STEPS = 0.04  # leg lengths, in the same way: small steps on the spot still have a phase
FOREIGN_GAIT = 0.65  # of the cost at random phases: a clip with a higher cost does not look like locomotion
OTHER_GAIT = 0.15  # leg lengths between strides: those farther apart are other gaits, however far
MOST_CANDIDATES = 16  # strides that are compared with all others
SHORTEST_CLIP = 0.3  # seconds: shorter clips have too few frames to align


@dataclass(frozen=True, eq=False)
class Baseline:
    """One stride of a locomotion as a ring of cells, evenly spaced in time.

    start, end: seconds in the clip. loop: distance of the stride's ends divided by the distance of its halves.
    leg: leg length, metres. zero: the real-valued cell at which the left foot touches down; there phases are whole
    numbers. clouds: [cells, 3, 3] lower clouds, metres.
    """

    name: str
    start: float
    end: float
    loop: float
    leg: float
    zero: float
    clouds: Floats

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


@dataclass(frozen=True, eq=False)
class Alignment:
    """The phase of each frame of a clip in the baseline's stride, and how well the clip fits there.

    phase: [F] cycles, strictly increasing. cost: [working frames] squared distance to the ring, square metres.
    chance: mean of that cost at random phases, square metres. swing: root-mean-square distance of root and knees, as
    seen from the hips, from where they are half a stride later, in leg lengths. stretches: those in which it stands and
    walks; none if it does only one of both.
    """

    phase: Floats
    cost: Floats
    chance: float
    swing: float
    stretches: tuple[Stretch, ...] = ()

    @property
    def cycles(self) -> float:
        return float(self.phase[-1] - self.phase[0])

    @property
    def has_gait(self) -> bool:
        """Whether the clip's legs move like the baseline's. If not, its phase is meaningless."""
        return bool(self.swing >= LEAST_SWING and self.cost.mean() <= FOREIGN_GAIT * self.chance)

    @property
    def mean_mismatch(self) -> float:
        """Root-mean-square distance of root and knees to the baseline's, metres."""
        return float(np.sqrt(self.cost.mean() / 3.0))

    @property
    def worst_mismatch(self) -> float:
        return float(np.sqrt(self.cost.max() / 3.0))


def find_baseline(clip: Clip, roles: Roles) -> Baseline:
    """Returns the stride of a clip whose end is most like its start.

    A stride is a pair of moments with similar surroundings, while the moment halfway between them differs. This
    excludes standing still, and two strides at once. A clip that is one whole cycle is a stride itself. Raises
    BaselineError if the clip has no stride.
    """
    return _whole_cycle(clip, roles) or _best_stride(clip, roles)


def _best_stride(clip: Clip, roles: Roles) -> Baseline:
    """Returns the stride within a clip whose ends match best. Raises BaselineError if none match."""
    windows = windowed(_at_working_rate(clip, roles.lower_cloud), LOOP_WINDOW)
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
    strike = left_strike(clip, roles, start, end)
    zero = 0.0 if strike is None else (strike - start) / step
    ring = _ring(clip, roles, slice(first, first + length + 1))
    return Baseline(clip.name, start, end, loop_distance, leg, zero, ring)


def _whole_cycle(clip: Clip, roles: Roles) -> Baseline | None:
    """Returns a clip that is one whole cycle of a gait as a stride; None if it is not a cycle, or several."""
    period = find_period(clip, roles)
    if period is None:
        return None
    played, leg = played_on(clip, period, roles), roles.leg_length(clip.skeleton)
    ring = _ring(played.frames(period, 2 * period + 1), roles, slice(None))
    windows = windowed(_at_working_rate(played, roles.lower_cloud), LOOP_WINDOW)
    cells, moving = len(ring), LOOP_WINDOW * 3 * (LEAST_SWING * leg) ** 2
    apart = planar_lag_distances(windows, (round(cells / 2), round(cells / 3)))  # small in two or three strides
    swings = [float(distances.mean()) for distances in apart.values()]
    if min(swings) <= max(moving, WORST_LOOP * max(swings)):
        return None
    seconds = period / clip.rate
    strike = left_strike(played, roles, seconds, 2.0 * seconds)
    zero = 0.0 if strike is None else (strike / seconds - 1.0) * cells
    return Baseline(clip.name, 0.0, seconds, 0.0, leg, zero, ring)


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

    twice = [level(np.tile(stride.clouds / stride.leg, (2, 1, 1))) for stride in strides]
    all_strides, ends = np.concatenate(twice), np.cumsum([len(clouds) for clouds in twice])

    def apart(candidate: Baseline) -> float:
        ring = level(candidate.clouds / candidate.leg)
        total = 0.0
        for distances in np.split(planar_distances(all_strides, ring), ends[:-1]):
            wound = wind(distances) % len(ring)
            total += min(float(np.sqrt(distances[np.arange(len(wound)), wound].mean())), OTHER_GAIT)
        return total

    candidates = sorted(strides, key=lambda stride: (stride.loop, stride.name))[:MOST_CANDIDATES]
    return min(candidates, key=lambda stride: (apart(stride), stride.name))


def align(clip: Clip, roles: Roles, baseline: Baseline) -> Alignment:
    """Aligns a clip to the baseline by winding it round the baseline's ring: first by its legs, then also by its arms.

    The clip must have the baseline's skeleton. Raises ClipError if it is shorter than SHORTEST_CLIP.
    """
    if clip.duration < SHORTEST_CLIP:
        raise ClipError(
            f"it lasts {clip.duration:.3f} s, too short to find its gait",
            place=f"clip {clip.name!r}",
            mend=f"Use at least {SHORTEST_CLIP} s, better two strides or more",
        )
    paths = _at_working_rate(clip, facing_joints(roles))
    apart = planar_distances(level(paths[:, :3]), level(baseline.clouds))
    cells, frames = apart.shape[1], np.arange(len(paths))
    swing = arm_swing(_at_working_rate(clip, arm_joints(roles)))
    distances = apart + swing_distances(swing, wind_steadily(apart) / cells, cells, baseline.leg)
    wound = wind_steadily(distances)
    cost = apart[frames, wound % cells]
    seconds, cycles = np.linspace(0.0, clip.duration, len(wound)), baseline.phase_at(between_cells(distances, wound))
    stands = _stands(windowed(paths[:, :3], LOOP_WINDOW), cost, apart, baseline)
    stretches = stretches_of(stands, clip.duration)
    if stretches:
        cycles = steadied(cycles, stands)
    curve = fit_increasing(seconds, cycles, KNOT_SPACING, STIFFNESS, SLOWEST)
    seen = level(facing(paths))  # not turned freely: half a stride later a symmetric walk is itself, turned
    half_later = np.interp(curve(seconds) + 0.5, curve(seconds), frames).astype(np.int64)
    moved = float(np.sqrt(np.sum((seen[half_later] - seen) ** 2, axis=2).mean())) / baseline.leg
    phase = np.asarray(curve(np.linspace(0.0, clip.duration, clip.frame_count)))
    return Alignment(phase - np.floor(phase[0]), cost, float(apart.mean()), moved, stretches)


def _stands(windows: Floats, cost: Floats, distances: Floats, baseline: Baseline) -> NDArray[np.bool_]:
    """Returns in which working frames [F] a clip has no gait: its legs hardly move, or not as the baseline's do.

    `cost` [F] is that of the winding, `distances` [F, cells] those to the whole ring.
    """
    half, margin = round(0.5 * (baseline.end - baseline.start) * WORKING_RATE), LOOP_WINDOW // 2
    still = standing_frames(windows, half, LEAST_STEPS * baseline.leg, WORKING_RATE)
    stands = np.pad(still, (margin, len(cost) - len(still) - margin), mode="edge")
    for begin, end in runs(stands):
        foreign = cost[begin:end].mean() > FOREIGN_GAIT * distances[begin:end].mean()
        stands[begin:end] |= foreign and len(stands) > end - begin
    return stands


def level(clouds: Floats) -> Floats:
    """Returns clouds [n, p, 3] about their mean height, so that steps on a stair compare with steps on the floor.

    The papers shift clouds over the floor only. Up a stair of three steps this leaves the legs 40 cm from the
    baseline's; levelling leaves 4 cm. On level ground the difference is negligible.
    """
    return clouds - clouds.mean(axis=1, keepdims=True) * np.array([0.0, 1.0, 0.0])


def _at_working_rate(clip: Clip, joints: tuple[int, ...]) -> Floats:
    """Returns world positions [n, p, 3] of p joints at about the working rate, from the first frame to the last."""
    positions = joint_paths(clip, joints)
    count = max(2, round(clip.duration * WORKING_RATE) + 1)
    at = np.linspace(0.0, clip.frame_count - 1, count)
    before = np.minimum(at.astype(np.int64), clip.frame_count - 2)
    t = (at - before)[:, None, None]
    return np.asarray((1.0 - t) * positions[before] + t * positions[before + 1])


def _ring(clip: Clip, roles: Roles, stride: slice) -> Floats:
    """Returns the lower clouds [cells, 3, 3] of one stride, with an even drift added so that it ends at its start."""
    clouds = facing(_at_working_rate(clip, facing_joints(roles)))[stride]
    along = np.linspace(0.0, 1.0, len(clouds))[:, None, None]
    return np.asarray((clouds - along * (clouds[-1] - clouds[0]))[:-1])
