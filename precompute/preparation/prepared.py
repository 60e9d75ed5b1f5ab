"""A clip made ready for the bank."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.baseline import LEAST_SWING, Alignment, Baseline, align
from motionsplice.precompute.alignment.gait import mean_gait
from motionsplice.precompute.body.common_skeleton import onto_skeleton
from motionsplice.precompute.body.contacts import foot_contacts
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.preparation.root_path import root_path
from motionsplice.precompute.preparation.seam import add_seam
from motionsplice.precompute.preparation.torso_offset import MeanStride
from motionsplice.runtime.format.rows import Layout, TorsoRows

FOREIGN_GAIT = 0.65  # of the cost at random phases: above it a clip does not look like locomotion


@dataclass(frozen=True, eq=False)
class PreparedClip:
    """A clip as a bank holds it, but for its torso offsets, which depend on another clip.

    Its frame_count frames at `rate`, and then those that lead back by `strides`, are at `phase` [rows]; `posture` is
    [2, 3], `path` [rows, 4] the way it goes, `contacts` [rows] which feet stand, `gait` its mean lower cloud by phase
    [bins, 3, 3], and `stride` its mean torso. What is large is fetched by name: its rows in each table (`lower`,
    `upper`), and `upright`, its torso clouds [rows, P, 3].

    kind is `locomotion` or `action`; neutral is the name of the clip that its posture is relative to; notes and
    file_warnings are what the reading of its file said; source is the digest of that file.
    """

    name: str
    rate: float
    frame_count: int
    strides: int
    alignment: Alignment
    phase: Floats
    posture: Floats
    path: Floats
    contacts: NDArray[np.uint8]
    gait: Floats
    stride: MeanStride
    fetch: Callable[[str], NDArray[Any]]
    kind: str = "locomotion"
    neutral: str = ""
    tags: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    file_warnings: tuple[str, ...] = ()
    source: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a person should know before using the clip."""
        said = list(self.file_warnings)
        if self.alignment.swing < LEAST_SWING:
            said.append("does not look like locomotion: its legs hardly move")
        elif not has_gait(self.alignment):
            far = f"{100.0 * self.alignment.mean_mismatch:.0f} cm off the baseline's"
            said.append(f"does not look like locomotion: its legs are {far}, hardly nearer than at random phases")
        if self.kind == "action" and self.strides == 0:
            said.append("has no two strides alike enough to go on from its end: as an action it is played once")
        return tuple(said)


def has_gait(alignment: Alignment) -> bool:
    """Whether a clip's legs go as the baseline's do, so that its phase means anything."""
    return bool(alignment.swing >= LEAST_SWING and alignment.cost.mean() <= FOREIGN_GAIT * alignment.chance)


def prepare(clip: Clip, roles: Roles, skeleton: Skeleton, skeleton_roles: Roles, baseline: Baseline) -> PreparedClip:
    """Brings a clip onto the bank's skeleton, aligns it to the baseline and measures its torso.

    Raises SkeletonError or ClipError.
    """
    ours = onto_skeleton(clip, roles, skeleton, skeleton_roles)
    alignment = align(ours, skeleton_roles, baseline)
    seamed = add_seam(ours, alignment.phase, skeleton_roles)
    torso, count = measure_torso(seamed.clip, skeleton_roles), ours.frame_count
    no_offsets = np.broadcast_to(quaternion.IDENTITY, torso.frames.shape)
    large: dict[str, NDArray[Any]] = {
        **Layout.of(skeleton, skeleton_roles).pack(
            seamed.clip.root_positions, seamed.clip.rotations, TorsoRows(torso.clouds, torso.frames, no_offsets)
        ),
        "upright": torso.upright,
    }
    return PreparedClip(
        name=clip.name,
        rate=float(clip.rate),
        frame_count=count,
        strides=seamed.strides,
        alignment=alignment,
        phase=seamed.phase,
        posture=torso.upright[:count, -2:].mean(axis=0),
        path=root_path(seamed.clip, seamed.phase, seamed.strides, skeleton_roles, has_gait(alignment)),
        contacts=foot_contacts(seamed.clip, skeleton_roles),
        gait=mean_gait(ours, alignment.phase, skeleton_roles),
        stride=MeanStride.of(torso.upright[:count], alignment.phase),
        fetch=large.__getitem__,
    )
