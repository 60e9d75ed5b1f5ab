"""How a clip goes on after its end.

A whole cycle goes on with its own start, and so does a clip without a gait that ends as it begins. Any other clip goes
on by a seam to an earlier stride.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.alignment import Alignment, align
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.alignment.whole_cycle import find_period, played_on
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.precompute.preparation.seam import SEAM, Seamed, add_seam, add_seam_to_start, bent_onto, settled

UNEVEN = 0.1  # strides: how far a cycle may be from a whole number of strides


@dataclass(frozen=True, eq=False)
class Looped:
    """A clip aligned to the baseline, with its seam.

    played: the motion in which its path and contacts are measured, and the phase of each frame. period: frames of the
    clip's cycle, 0 if it is not a whole cycle; `played` has as many frames before the clip.
    """

    alignment: Alignment
    seamed: Seamed
    played: tuple[Clip, Floats]
    period: int

    @property
    def rows(self) -> slice:
        """The frames of `played` that belong to the clip and its seam."""
        return slice(self.period, self.period + self.seamed.clip.frame_count)


def loop(clip: Clip, roles: Roles, baseline: Baseline) -> Looped:
    """Aligns a clip and adds its seam. Raises ClipError if it is too short to be aligned."""
    period = find_period(clip, roles)
    whole = None if period is None else _with_itself(clip, period, roles, baseline)
    if whole is not None:
        return whole
    standing = foot_contacts(clip, roles)
    alignment = align(clip, roles, baseline, standing)
    seamed = None if alignment.has_gait else add_seam_to_start(clip, baseline.end - baseline.start, roles, standing)
    if seamed is None:
        seamed = add_seam(clip, alignment.phase, roles, standing)
    alignment = replace(alignment, phase=seamed.phase[: clip.frame_count])
    return Looped(alignment, seamed, (seamed.clip, seamed.phase), 0)


def _with_itself(clip: Clip, period: int, roles: Roles, baseline: Baseline) -> Looped | None:
    """Aligns a whole cycle, whose seam repeats its first frames. Returns None if it takes a fraction of a stride."""
    played, count = played_on(clip, period, roles), clip.frame_count
    alignment = align(played, roles, baseline)
    lap = alignment.phase[period : 2 * period + 1]
    cycles = lap[-1] - lap[0]
    strides = round(cycles)
    if strides == 0 or abs(cycles - strides) > UNEVEN:
        return None
    frames = np.arange(played.frame_count)
    even = lap[:-1] - np.floor(lap[0]) + (strides - cycles) * np.arange(period) / period
    phase = even[frames % period] + strides * (frames // period - 1)
    rows = slice(period, period + count + max(2, round(SEAM * clip.rate)))
    seamed = Seamed(_joined(clip, played.frames(period + count - 1, rows.stop)), phase[rows], strides)
    return Looped(replace(alignment, phase=phase[rows][:count]), seamed, (played, phase), period)


def _joined(clip: Clip, again: Clip) -> Clip:
    """Returns a clip and its repetition. `again` begins at the clip's last frame; their difference fades out."""
    last, count = clip.frames(clip.frame_count - 1, clip.frame_count), again.frame_count - 1
    shift = settled(np.tile(last.root_positions - again.root_positions[0], (2, 1)), count)
    rotations = bent_onto(np.tile(last.rotations, (2, 1, 1)), again.rotations[[0, *range(count + 1)]])
    return clip.followed_by(again.root_positions[1:] + shift, rotations)
