"""A clip made ready for the bank."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motion.clip import Clip
from motion.quaternion import Floats
from motion.roles import Roles
from motion.skeleton import Skeleton
from precompute.baseline import LEAST_SWING, Alignment, Baseline, align
from precompute.common_skeleton import onto_skeleton
from precompute.gait import mean_gait
from precompute.posture import Torso, measure_torso
from precompute.seam import Seamed, add_seam

FOREIGN_GAIT = 0.65  # of the cost at random phases: above it a clip does not look like locomotion


@dataclass(frozen=True, eq=False)
class PreparedClip:
    """A clip on the bank's skeleton, with all that was measured of it.

    `seamed` is the clip with the frames that lead back to an earlier stride, and `torso` that of all its rows; `gait`
    is its mean lower cloud by phase [bins, 3, 3]. kind is `locomotion` or `action`; neutral is the name of the clip
    that its posture is relative to; notes and file_warnings are what the reading of its file said; source is the digest
    of that file.
    """

    alignment: Alignment
    seamed: Seamed
    torso: Torso
    gait: Floats
    kind: str = "locomotion"
    neutral: str = ""
    tags: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    file_warnings: tuple[str, ...] = ()
    source: str = ""

    @cached_property
    def clip(self) -> Clip:
        """The clip's own frames."""
        return self.seamed.clip.frames(0, len(self.alignment.phase))

    @property
    def posture(self) -> Floats:
        """The clip's posture [2, 3]: the mean of both shoulders over its own frames."""
        return np.asarray(self.torso.upright[: self.clip.frame_count, -2:].mean(axis=0))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a person should know before using the clip."""
        said = list(self.file_warnings)
        if self.alignment.swing < LEAST_SWING:
            said.append("does not look like locomotion: its legs hardly move")
        elif self.alignment.cost.mean() > FOREIGN_GAIT * self.alignment.chance:
            far = f"{100.0 * self.alignment.mean_mismatch:.0f} cm off the baseline's"
            said.append(f"does not look like locomotion: its legs are {far}, hardly nearer than at random phases")
        if self.kind == "action" and self.seamed.strides == 0:
            said.append("has no two strides alike enough to go on from its end: as an action it is played once")
        return tuple(said)


def prepare(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles, baseline: Baseline) -> PreparedClip:
    """Brings a clip onto the bank's skeleton, aligns it to the baseline and measures its torso.

    Raises SkeletonError or ClipError.
    """
    ours = onto_skeleton(clip, roles, skeleton, skeleton_roles)
    alignment = align(ours, skeleton_roles, baseline)
    seamed = add_seam(ours, alignment.phase, skeleton_roles)
    torso = measure_torso(seamed.clip, skeleton_roles)
    return PreparedClip(alignment, seamed, torso, mean_gait(ours, alignment.phase, skeleton_roles))
