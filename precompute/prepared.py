"""A clip made ready for the bank."""

from __future__ import annotations

from dataclasses import dataclass

from motion.clip import Clip
from motion.roles import Roles
from motion.skeleton import Skeleton
from precompute.baseline import Alignment, Baseline, align
from precompute.common_skeleton import onto_skeleton
from precompute.posture import Torso, measure_torso

FOREIGN_GAIT = 0.65  # of the cost at random phases: above it a clip does not look like locomotion


@dataclass(frozen=True, eq=False)
class PreparedClip:
    """A clip on the bank's skeleton, with all that was measured of it.

    kind is `locomotion` or `action`; neutral is the name of the clip that its posture is relative to; source is
    the digest of the file it came from.
    """

    clip: Clip
    alignment: Alignment
    torso: Torso
    kind: str = "locomotion"
    neutral: str = ""
    tags: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    source: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a person should know before using the clip."""
        if self.alignment.cost.mean() <= FOREIGN_GAIT * self.alignment.chance:
            return ()
        far = f"{100.0 * self.alignment.mean_mismatch:.0f} cm off the baseline's"
        return (f"does not look like locomotion: its legs are {far}, hardly nearer than at random phases",)


def prepare(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles, baseline: Baseline) -> PreparedClip:
    """Brings a clip onto the bank's skeleton, aligns it to the baseline and measures its torso.

    Raises SkeletonError or ClipError.
    """
    ours = onto_skeleton(clip, roles, skeleton, skeleton_roles)
    return PreparedClip(ours, align(ours, skeleton_roles, baseline), measure_torso(ours, skeleton_roles))
