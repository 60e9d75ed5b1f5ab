"""The baseline: one stride of one locomotion, and how every clip is timed by it (thesis 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BaselineError, ClipError
from motionsplice.motion.kinematics import heading
from motionsplice.motion.pointcloud import planar_distance, planar_distances, planar_lag_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.increasing_spline import fit_increasing
from motionsplice.precompute.alignment.ring import wind
from motionsplice.precompute.body.contacts import left_strike
from motionsplice.precompute.body.joint_paths import joint_paths

WORKING_RATE = 30.0  # frames per second at which motions are compared
KNOT_SPACING = 0.1  # seconds
STIFFNESS = 1.0  # of the phase, against changes of its speed
STRIDES = (0.5, 1.8)  # shortest and longest stride looked for, seconds
LOOP_WINDOW = 5  # frames at the working rate
WORST_LOOP = 0.15  # how far the stride's ends may be apart, as a part of how far its middle is
LEAST_SWING = 0.05  # of the leg length, between the two halves of a stride
MOST_CANDIDATES = 16  # strides that are weighed against all others
SHORTEST_CLIP = 0.3  # seconds: below it a path round the ring means nothing


@dataclass(frozen=True, eq=False)
class Baseline:
    """One stride as a ring: lower clouds [cells, 3, 3] of a locomotion, evenly spaced in phase.

    start and end are seconds in the clip; loop is the distance of its ends over that of its halves; leg is the
    length of its legs, metres. zero is the real-valued cell at which the left foot comes down: whole phases are there.
    """

    name: str
    start: float
    end: float
    loop: float
    leg: float
    zero: float
    clouds: Floats


@dataclass(frozen=True, eq=False)
class Alignment:
    """When a clip is where in the baseline's stride.

    phase: [F] cycles, strictly increasing. cost: [working frames] squared distance to the ring, square metres;
    chance: what its mean would be at random phases. swing: how far root and knees are from themselves half a stride
    later, as a part of the leg.
    """

    phase: Floats
    cost: Floats
    chance: float
    swing: float

    @property
    def cycles(self) -> float:
        return float(self.phase[-1] - self.phase[0])

    @property
    def mean_mismatch(self) -> float:
        """Root-mean-square distance of root and knees to the baseline's, metres."""
        return float(np.sqrt(self.cost.mean() / 3.0))

    @property
    def worst_mismatch(self) -> float:
        return float(np.sqrt(self.cost.max() / 3.0))


def find_baseline(clip: Clip, roles: Roles) -> Baseline:
    """The stride of a clip that closes best on itself.

    A stride is a pair of moments whose surroundings are alike while the moment halfway between them is not:
    so neither standing still nor two strides at once pass for one. Raises BaselineError if there is none.
    """
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


def no_stride(name: str) -> BaselineError:
    return BaselineError(
        f"clip {name!r} has no stride of {STRIDES[0]} to {STRIDES[1]} s that ends as it began",
        mend="Name another clip with --baseline: a plain walk of a few steps is best",
    )


def most_typical(strides: Sequence[Baseline]) -> Baseline:
    """The stride that all `strides` come nearest to, among the MOST_CANDIDATES that close best.

    Each stride, taken twice over, is wound round each candidate's ring, so the cost is linear in their number. Summed
    are distances, not their squares: else one run among walks draws the choice to a stride between all, like neither.
    """

    twice = [level(np.tile(stride.clouds / stride.leg, (2, 1, 1))) for stride in strides]
    all_strides, ends = np.concatenate(twice), np.cumsum([len(clouds) for clouds in twice])

    def apart(candidate: Baseline) -> float:
        ring = level(candidate.clouds / candidate.leg)
        total = 0.0
        for distances in np.split(planar_distances(all_strides, ring), ends[:-1]):
            wound = wind(distances) % len(ring)
            total += float(np.sqrt(distances[np.arange(len(wound)), wound].mean()))
        return total

    candidates = sorted(strides, key=lambda stride: (stride.loop, stride.name))[:MOST_CANDIDATES]
    return min(candidates, key=lambda stride: (apart(stride), stride.name))


def align(clip: Clip, roles: Roles, baseline: Baseline) -> Alignment:
    """Winds a clip round the baseline's ring. The clip must be on the baseline's skeleton.

    Raises ClipError if the clip is too short to show a gait.
    """
    if clip.duration < SHORTEST_CLIP:
        raise ClipError(
            f"it lasts {clip.duration:.3f} s, too short to see a gait in",
            place=f"clip {clip.name!r}",
            mend=f"Give at least {SHORTEST_CLIP} s, better two strides or more",
        )
    clouds = _at_working_rate(clip, roles.lower_cloud)
    distances = planar_distances(level(clouds), level(baseline.clouds))
    wound = wind(distances)
    cells = distances.shape[1]
    frames = np.arange(len(wound))
    at, before, after = (distances[frames, (wound + shift) % cells] for shift in (0, -1, 1))
    bend = before - 2.0 * at + after
    between = np.clip(0.5 * (before - after) / np.where(bend > 0.0, bend, np.inf), -0.5, 0.5)
    seconds = np.linspace(0.0, clip.duration, len(wound))
    curve = fit_increasing(seconds, (wound + between - baseline.zero) / cells, KNOT_SPACING, STIFFNESS)
    half_later = np.interp(curve(seconds) + 0.5, curve(seconds), frames).astype(np.int64)
    swing = float(np.sqrt(planar_distance(clouds, clouds[half_later]).mean() / 3.0)) / baseline.leg
    phase = np.asarray(curve(np.linspace(0.0, clip.duration, clip.frame_count)))
    return Alignment(phase - np.floor(phase[0]), at, float(distances.mean()), swing)


def level(clouds: Floats) -> Floats:
    """Clouds [n, p, 3] about their own height, so that a step of a stair is compared with a step on the floor.

    The papers shift over the floor only. Up a stair of three steps that leaves the legs 40 cm apart from the
    baseline's, this 4 cm; on level ground it changes nothing to speak of.
    """
    return clouds - clouds.mean(axis=1, keepdims=True) * np.array([0.0, 1.0, 0.0])


def _at_working_rate(clip: Clip, joints: tuple[int, ...]) -> Floats:
    """Joints [n, p, 3] in the world, at about the working rate, from the first frame to the last."""
    positions = joint_paths(clip, joints)
    count = max(2, round(clip.duration * WORKING_RATE) + 1)
    at = np.linspace(0.0, clip.frame_count - 1, count)
    before = np.minimum(at.astype(np.int64), clip.frame_count - 2)
    t = (at - before)[:, None, None]
    return np.asarray((1.0 - t) * positions[before] + t * positions[before + 1])


def _ring(clip: Clip, roles: Roles, stride: slice) -> Floats:
    """The lower clouds [cells, 3, 3] of one stride, its end drawn onto its start by an even drift."""
    clouds = facing(_at_working_rate(clip, facing_joints(roles)))[stride]
    along = np.linspace(0.0, 1.0, len(clouds))[:, None, None]
    return np.asarray((clouds - along * (clouds[-1] - clouds[0]))[:-1])


def facing_joints(roles: Roles) -> tuple[int, ...]:
    """The joints that `facing` needs: the lower cloud's and both hips."""
    return (*roles.lower_cloud, roles.left_hip, roles.right_hip)


def facing(positions: Floats) -> Floats:
    """Lower clouds [n, 3, 3] over the floor's origin with the hips along x, so that they can be mixed.

    positions [n, 5, 3] in the world are those of the `facing_joints`.
    """
    turn = quaternion.about([0.0, 1.0, 0.0], -heading(positions[:, 3] - positions[:, 4]))
    clouds = positions[:, :3]
    return quaternion.rotate(turn[:, None], clouds - clouds[:, :1] * np.array([1.0, 0.0, 1.0]))
