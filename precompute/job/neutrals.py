"""The neutral of each clip: the clip that its posture is relative to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motionsplice.motion.errors import MotionError, SettingsError, did_you_mean
from motionsplice.precompute.job.clip_work import Clips
from motionsplice.precompute.preparation.neutral import nearest_gait
from motionsplice.precompute.preparation.prepared import PreparedClip


def fail_without_neutral(clips: Clips, failed: dict[str, MotionError]) -> None:
    """Fails clips whose named neutral is not in the bank, and then the clips whose neutral has failed."""
    neutrals = {name: one.source.settings.neutral for name, one in clips.items() if name not in failed}
    while missing := {name: neutral for name, neutral in neutrals.items() if neutral and neutral not in neutrals}:
        for name, neutral in missing.items():
            problem = f"its neutral {neutral!r} is not in the bank"
            failed[name] = SettingsError(problem, place=f"clip {name!r}", mend=did_you_mean(neutral, neutrals))
            del neutrals[name]


def with_neutrals(prepared: Sequence[PreparedClip], baseline: str) -> list[PreparedClip]:
    """Returns each clip with its neutral, and whether it is a standing action.

    The neutral is the clip that its settings name. Without one, a locomotion is its own neutral, and an action's is the
    locomotion nearest in gait, or the baseline if there are no locomotions. An action stands if it has no gait, or if
    its named neutral has none. Its neutral is a clip without a gait, or itself: then its own frames at rest count.
    A hybrid does not stand itself. Its stretches have its neutral, those of them that stand or walk as this does.
    """
    gaits = {one.name: one.alignment.has_gait for one in prepared}
    locomotions = {one.name: one for one in prepared if one.kind == "locomotion"}
    candidates = locomotions or {one.name: one for one in prepared if one.name == baseline}

    def neutral_of(one: PreparedClip) -> str:
        return one.neutral or (one.name if one.kind == "locomotion" else nearest_gait(one, candidates))

    def labelled(one: PreparedClip) -> PreparedClip:
        if one.cut is not None and gaits.get(one.neutral) != gaits[one.name]:
            one = replace(one, neutral="")
        if one.kind == "locomotion" or one.stretches or (gaits[one.name] and gaits.get(one.neutral, True)):
            return replace(one, neutral=neutral_of(one))
        if one.neutral and gaits[one.neutral]:
            warning = f"stands, so {one.neutral!r}, which walks, cannot be its neutral; its own frames at rest are used"
            return replace(one, neutral=one.name, stands=True, file_warnings=(*one.file_warnings, warning))
        return replace(one, neutral=one.neutral or one.name, stands=True)

    return [labelled(one) for one in prepared]
