"""A clip prepared for the bank."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import Roles
from motionsplice.precompute.alignment.alignment import Alignment
from motionsplice.precompute.alignment.baseline import LEAST_SWING, Baseline
from motionsplice.precompute.alignment.gait import mean_gait
from motionsplice.precompute.body.contacts import foot_contacts, support
from motionsplice.precompute.body.facing import facing, facing_joints
from motionsplice.precompute.body.joint_paths import Followed, joint_paths
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.preparation.cuts import Cut
from motionsplice.precompute.preparation.feet import standing_feet
from motionsplice.precompute.preparation.looped import Looped, loop
from motionsplice.precompute.preparation.repetition import stride_to_stride
from motionsplice.precompute.preparation.root_path import root_path
from motionsplice.precompute.preparation.torso_offset import MeanStride
from motionsplice.runtime.format.packed_rows import packed
from motionsplice.runtime.format.rows import Layout, TorsoRows


@dataclass(frozen=True, eq=False)
class PreparedClip:
    """A clip as a bank holds it, except for its torso offsets, which depend on another clip.

    Its rows are its own `frame_count` frames at `rate` frames per second, then the seam, which leads back by `strides`
    strides (0: no seam). period: frames of its cycle, 0 if it is not a whole cycle.

    phase: [rows] cycles. posture: [2, 3] metres. path: [rows, 4] of `root_path`. contacts: [rows] which feet stand.
    feet: [rows, 6] of `standing_feet`. gait: [bins, 3, 3] mean lower cloud by phase, metres. stride: mean torso by
    phase. repetition: of `stride_to_stride`, metres. fetch: returns a large array by name: the clip's rows in the
    tables `lower` and `upper`, or `upright`, its torso clouds [rows, P, 3] in metres. kind: `locomotion` or `action`.
    neutral: name of the clip that its posture is relative to. stands: whether it is an action without a gait, laid on
    locomotions as what it adds to a stance. mask: the parts that it then poses; None to measure them. cut: the stretch
    of a hybrid clip that it is, or None. stretches: the names of its stretches, if it is a hybrid action. notes: from
    reading and moving it. file_warnings: from reading its file. source: digest of that file.
    """

    name: str
    rate: float
    frame_count: int
    strides: int
    period: int
    alignment: Alignment
    phase: Floats
    posture: Floats
    path: Floats
    contacts: NDArray[np.uint8]
    feet: Floats
    gait: Floats
    stride: MeanStride
    repetition: float
    fetch: Callable[[str], NDArray[Any]]
    kind: str = "locomotion"
    neutral: str = ""
    stands: bool = False
    mask: str | None = None
    cut: Cut | None = None
    stretches: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    file_warnings: tuple[str, ...] = ()
    source: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for the user of the clip."""
        warnings = list(self.file_warnings)
        if self.stands or self.stretches:
            return tuple(warnings)
        if self.mask is not None and self.cut is None:
            warnings.append("its mask is not used: it is no action without a gait")
        if self.alignment.swing < LEAST_SWING:
            warnings.append(f"does not look like locomotion: its legs hardly move{self._mend}")
        elif not self.alignment.has_gait:
            centimetres = f"{100.0 * self.alignment.mean_mismatch:.0f} cm"
            warnings.append(
                f"does not look like locomotion: its legs are {centimetres} from the baseline's, "
                f"hardly nearer than at random phases{self._mend}"
            )
        goes_on = self.cut is not None and self.cut.leaves < self.frame_count - 1.0
        if self.kind == "action" and self.strides == 0 and not goes_on:
            warnings.append("cannot loop: no earlier stride is enough like its end, so as an action it plays once")
        return tuple(warnings)

    @property
    def _mend(self) -> str:
        return "" if self.kind == "action" else '. If it is an action, give it `kind = "action"` in clips.toml'


def prepare(
    clip: Clip, roles: Roles, rig: Rig, baseline: Baseline, *, retargeting: bool = True, cut: Cut | None = None
) -> PreparedClip:
    """Moves a clip onto the bank's rig, aligns it to the baseline, adds its seam and measures it.

    retargeting: as in `onto_rig`. cut: the stretch that the clip is, or None; gait and posture are then measured where
    it is settled. Raises SkeletonError if the rigs do not match, ClipError if the clip cannot be aligned or measured.
    """
    fitted = onto_rig(clip, roles, rig, retargeting=retargeting)
    ours, skeleton_roles = fitted.clip, rig.roles
    looped, clouds = _looped(ours, skeleton_roles, baseline)
    alignment, seamed, rows = looped.alignment, looped.seamed, looped.rows
    shown = Followed.of(seamed.clip, skeleton_roles)
    played, phase = looped.played if looped.period else (shown, seamed.phase)
    path = root_path(played, phase, seamed.strides, skeleton_roles, alignment.has_gait)[rows]
    contacts = foot_contacts(played, skeleton_roles)
    torso, count = measure_torso(shown, skeleton_roles), ours.frame_count
    settled = slice(0, count) if cut is None else cut.settled(clip.rate)
    no_offsets = np.broadcast_to(quaternion.IDENTITY, torso.frames.shape)
    layout = Layout.of(rig.skeleton, skeleton_roles)
    large: dict[str, NDArray[Any]] = {
        **packed(layout, shown.root_positions, shown.rotations, TorsoRows(torso.clouds, torso.frames, no_offsets)),
        "upright": torso.upright,
    }
    return PreparedClip(
        name=clip.name,
        rate=float(clip.rate),
        frame_count=count,
        strides=seamed.strides,
        period=looped.period,
        alignment=alignment,
        phase=seamed.phase,
        posture=torso.upright[settled, -2:].mean(axis=0),
        path=path,
        contacts=contacts[rows],
        feet=standing_feet(shown, path, support(contacts, clip.rate)[rows], skeleton_roles),
        gait=mean_gait(clouds[settled], alignment.phase[settled]),
        stride=MeanStride.of(torso.upright[settled], alignment.phase[settled]),
        repetition=stride_to_stride(ours, torso.clouds, alignment.phase, skeleton_roles) if alignment.has_gait else 0.0,
        fetch=large.__getitem__,
        cut=cut,
        notes=fitted.notes,
    )


def _looped(clip: Clip, roles: Roles, baseline: Baseline) -> tuple[Looped, Floats]:
    """Aligns a clip and adds its seam. Returns its lower clouds [F, 3, 3] too, and forgets all other paths."""
    followed = Followed.of(clip, roles)
    return loop(followed, roles, baseline), facing(joint_paths(followed, facing_joints(roles)))
