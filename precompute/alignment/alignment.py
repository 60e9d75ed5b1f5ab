"""The alignment of every clip to the baseline (Heck's thesis, 4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import ClipError
from motionsplice.motion.pointcloud import level, planar_distances, windowed
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.arm_swing import arm_joints, arm_swing, swing_distances
from motionsplice.precompute.alignment.baseline import LEAST_SWING, LOOP_WINDOW, Baseline
from motionsplice.precompute.alignment.contact_distances import contact_distances
from motionsplice.precompute.alignment.increasing_spline import fit_increasing
from motionsplice.precompute.alignment.ring import between_cells, wind_steadily
from motionsplice.precompute.alignment.stretches import Stretch, runs, standing_frames, steadied, stretches_of
from motionsplice.precompute.alignment.working_rate import (
    WORKING_RATE,
    paths_at_working_rate,
    support_at_working_rate,
)
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.precompute.body.facing import facing, facing_joints

KNOT_SPACING = 0.16  # seconds
STIFFNESS = 4.0  # of the phase curve, against changes of its slope
SLOWEST = 0.5  # of the clip's mean slope: the least slope of its phase curve
LEAST_STEPS = 0.04  # leg lengths, in the same way: small steps on the spot still have a phase
FOREIGN_GAIT = 0.65  # of the cost at random phases: a clip with a higher cost does not look like locomotion
SHORTEST_CLIP = 0.3  # seconds: shorter clips have too few frames to align


@dataclass(frozen=True, eq=False)
class Alignment:
    """The phase of each frame of a clip in the baseline's stride, and how well the clip fits there.

    phase: [F] cycles, strictly increasing. cost: [working frames] squared distance to the ring, square metres.
    foreign: that cost, with the feet's, divided by its mean at random phases. swing: root-mean-square distance of root
    and knees, as seen from the hips, from where they are half a stride later, in leg lengths. stretches: those in which
    it stands and walks; none if it does only one of both.
    """

    phase: Floats
    cost: Floats
    foreign: float
    swing: float
    stretches: tuple[Stretch, ...] = ()

    @property
    def cycles(self) -> float:
        return float(self.phase[-1] - self.phase[0])

    @property
    def has_gait(self) -> bool:
        """Whether the clip's legs move like the baseline's. If not, its phase is meaningless."""
        return bool(self.swing >= LEAST_SWING and self.foreign <= FOREIGN_GAIT)

    @property
    def mean_mismatch(self) -> float:
        """Root-mean-square distance of root and knees to the baseline's, metres."""
        return float(np.sqrt(self.cost.mean() / 3.0))

    @property
    def worst_mismatch(self) -> float:
        return float(np.sqrt(self.cost.max() / 3.0))


def align(clip: Clip, roles: Roles, baseline: Baseline, standing: NDArray[np.uint8] | None = None) -> Alignment:
    """Aligns a clip to the baseline by winding it round the ring: by its legs and feet, then by its arms as well.

    The clip must have the baseline's skeleton. standing: its `foot_contacts` [F], if they are known. Raises ClipError
    if it is shorter than SHORTEST_CLIP.
    """
    if clip.duration < SHORTEST_CLIP:
        raise ClipError(
            f"it lasts {clip.duration:.3f} s, too short to find its gait",
            place=f"clip {clip.name!r}",
            mend=f"Use at least {SHORTEST_CLIP} s, better two strides or more",
        )
    paths = paths_at_working_rate(clip, facing_joints(roles))
    knees = planar_distances(level(paths[:, :3]), level(baseline.clouds))
    standing = foot_contacts(clip, roles) if standing is None else standing
    below = knees + contact_distances(support_at_working_rate(clip, standing), baseline.support, baseline.leg)
    cells, frames = below.shape[1], np.arange(len(paths))
    swing = arm_swing(paths_at_working_rate(clip, arm_joints(roles)))
    distances = below + swing_distances(swing, wind_steadily(below) / cells, cells, baseline.leg)
    wound = wind_steadily(distances)
    cost, at = below[frames, wound % cells], np.linspace(0.0, clip.duration, len(frames))
    stands = _stands(windowed(paths[:, :3], LOOP_WINDOW), cost, below, baseline)
    stretches = stretches_of(stands, clip.duration)
    cycles = baseline.phase_at(between_cells(distances, wound))
    curve = fit_increasing(at, steadied(cycles, stands) if stretches else cycles, KNOT_SPACING, STIFFNESS, SLOWEST)
    phase = np.asarray(curve(np.linspace(0.0, clip.duration, clip.frame_count)))
    return Alignment(
        phase=phase - np.floor(phase[0]),
        cost=knees[frames, wound % cells],
        foreign=float(cost.mean() / below.mean()),
        swing=_swing(level(facing(paths)), curve(at)) / baseline.leg,
        stretches=stretches,
    )


def _swing(seen: Floats, cycles: Floats) -> float:
    """Returns the distance, root-mean-square in metres, of root and knees from where they are half a stride later.

    seen: their clouds [n, 3, 3] from the hips. Turned freely, a symmetric walk half a stride later would be itself.
    cycles: [n], rising.
    """
    half_later = np.interp(cycles + 0.5, cycles, np.arange(len(cycles))).astype(np.int64)
    return float(np.sqrt(np.sum((seen[half_later] - seen) ** 2, axis=2).mean()))


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
