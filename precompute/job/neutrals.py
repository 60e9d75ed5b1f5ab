"""The neutral of each clip: the clip that its posture is relative to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from motionsplice.motion.errors import MotionError, SettingsError, did_you_mean
from motionsplice.precompute.job.readings import Clips
from motionsplice.precompute.preparation.neutral import ShownGait, nearest_gaits
from motionsplice.precompute.preparation.prepared import PreparedClip


def fail_without_neutral(clips: Clips, failed: dict[str, MotionError]) -> None:
    """Fails clips whose named neutral is not in the bank, and then the clips whose neutral has failed."""
    neutrals = {name: one.source.settings.neutral for name, one in clips.items() if name not in failed}
    while missing := {name: neutral for name, neutral in neutrals.items() if neutral and neutral not in neutrals}:
        for name, neutral in missing.items():
            problem = f"its neutral {neutral!r} is not in the bank"
            mend = did_you_mean(neutral, neutrals)
            failed[name] = SettingsError(problem, file=clips[name].files, place=f"clip {name!r}", mend=mend)
            del neutrals[name]


@dataclass(frozen=True, slots=True)
class Label:
    """The role of a clip in its bank: its neutral, and whether it is a standing action. warning: empty if none."""

    neutral: str
    stands: bool = False
    warning: str = ""

    def on(self, one: PreparedClip) -> PreparedClip:
        """Returns the clip with this label."""
        warnings = (*one.file_warnings, self.warning) if self.warning else one.file_warnings
        return replace(one, neutral=self.neutral, stands=self.stands, file_warnings=warnings)


def labels_of(clips: Mapping[str, PreparedClip], baseline: str) -> dict[str, Label]:
    """Returns the label of each clip. Looks at each once.

    The neutral is the clip that its settings name. Without one, a locomotion is its own neutral, and an action's is the
    locomotion nearest in gait, or the baseline if there are no locomotions. An action stands if it has no gait, or if
    its named neutral has none. Its neutral is a clip without a gait, or itself: then its own frames at rest count.
    A hybrid does not stand itself. Its stretches have its neutral, those of them that stand or walk as this does.
    """
    seen = {name: _Seen.of(one) for name, one in clips.items()}
    labels = {name: _label(name, seen) for name in seen}
    locomotions = [one.shown for one in seen.values() if one.locomotion] or [seen[baseline].shown]
    without = [name for name, label in labels.items() if not label.neutral]
    nearest = nearest_gaits([seen[name].shown for name in without], locomotions)
    return labels | {name: Label(neutral) for name, neutral in zip(without, nearest, strict=True)}


@dataclass(frozen=True, slots=True)
class _Seen:
    """The facts about a clip on which labels depend. neutral: from its settings, empty without one."""

    shown: ShownGait
    neutral: str
    locomotion: bool
    walks: bool
    stretch: bool
    hybrid: bool

    @classmethod
    def of(cls, one: PreparedClip) -> _Seen:
        walks, stretch, hybrid = one.alignment.has_gait, one.cut is not None, bool(one.stretches)
        return cls(ShownGait.of(one), one.neutral, one.kind == "locomotion", walks, stretch, hybrid)


def _label(name: str, seen: Mapping[str, _Seen]) -> Label:
    """Returns the label of a clip, with an empty neutral if it is the nearest locomotion."""
    one = seen[name]
    neutral = seen.get(one.neutral)
    if neutral is not None and one.stretch and neutral.walks != one.walks:
        neutral = None
    named = "" if neutral is None else one.neutral
    if one.locomotion:
        return Label(named or name)
    if one.hybrid or (one.walks and (neutral is None or neutral.walks)):
        return Label(named)
    if neutral is not None and neutral.walks:
        warning = f"stands, so {named!r}, which walks, cannot be its neutral; its own frames at rest are used"
        return Label(name, stands=True, warning=warning)
    return Label(named or name, stands=True)
