"""The standing actions of a bank: which clips they are, and how each departs from its stance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import MotionError, SettingsError
from motionsplice.motion.parts import MASKS, chains_to_limbs
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.job.clip_work import Clips
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.precompute.preparation.standing import Measured, measure_standing
from motionsplice.runtime.format.rows import Layout


def fail_with_missing_limbs(clips: Clips, rig: Rig, failed: dict[str, MotionError]) -> None:
    """Fails clips whose mask names limbs that the bank's rig does not have."""
    for name, one in clips.items():
        mask = one.source.settings.mask
        if mask is not None and mask != "upper_body":
            for part, chain in chains_to_limbs(rig.skeleton, rig.roles).items():
                if MASKS[mask] & part and not chain and name not in failed:
                    problem = f"mask {mask!r} does not fit the bank's rig: its roles do not name these limbs"
                    mend = "Name the joints of the limbs as roles, or leave the mask out"
                    failed[name] = SettingsError(problem, place=f"clip {name!r}", mend=mend)


def standing_of(clips: Sequence[PreparedClip], skeleton: Skeleton, roles: Roles) -> dict[str, Measured]:
    """Measures the standing actions among all clips of a bank. Returns them by name, in the order of the clips."""
    by_name = {one.name: one for one in clips}
    return {one.name: _measured(one, by_name, skeleton, roles) for one in clips if one.stands}


def _measured(one: PreparedClip, clips: Mapping[str, PreparedClip], skeleton: Skeleton, roles: Roles) -> Measured:
    idle = None if one.neutral == one.name else clips[one.neutral]
    shown = None if idle is None else _motion(idle, skeleton, roles).frames(0, idle.frame_count)
    return measure_standing(_motion(one, skeleton, roles), one.frame_count, shown, one.mask, roles, one.cut)


def _motion(one: PreparedClip, skeleton: Skeleton, roles: Roles) -> Clip:
    """Returns a prepared clip and its seam in their editable form."""
    roots, rotations = Layout.of(skeleton, roles).motion(one.fetch("lower"), one.fetch("upper"))
    return Clip(one.name, skeleton, one.rate, roots, rotations)
