"""The standing actions of a bank, and how each departs from its stance."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import MotionError, SettingsError
from motionsplice.motion.parts import MASKS, chains_to_limbs
from motionsplice.motion.retarget.rig import Rig
from motionsplice.precompute.job.readings import Clips
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
                    failed[name] = SettingsError(problem, file=one.files, place=f"clip {name!r}", mend=mend)


class StandingActions:
    """Measures the standing actions among the clips of a bank, one after the other."""

    def __init__(self, clips: Mapping[str, PreparedClip], rig: Rig) -> None:
        self._skeleton, self._roles = rig.skeleton, rig.roles
        # The next action by name often has the same idle. Its frames are not kept beyond that.
        self._frames_of = lru_cache(maxsize=1)(lambda name: self._motion(clips[name], seam=False))

    def measured(self, one: PreparedClip) -> Measured | None:
        """Returns how a clip departs from its stance; None if it does not stand."""
        if not one.stands:
            return None
        idle = None if one.neutral == one.name else self._frames_of(one.neutral)
        return measure_standing(self._motion(one), one.frame_count, idle, one.mask, self._roles, one.cut)

    def _motion(self, one: PreparedClip, *, seam: bool = True) -> Clip:
        """Returns a prepared clip, with its seam or without, in its editable form."""
        layout = Layout.of(self._skeleton, self._roles)
        clip = Clip(one.name, self._skeleton, one.rate, *layout.motion(one.fetch("lower"), one.fetch("upper")))
        return clip if seam else clip.frames(0, one.frame_count)
