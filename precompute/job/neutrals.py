"""The neutral of each clip: the clip that its posture is relative to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from motionsplice.motion.errors import MotionError, SettingsError, did_you_mean
from motionsplice.precompute.job.clip_work import Clips
from motionsplice.precompute.preparation.neutral import ShownGait, nearest_gaits
from motionsplice.precompute.preparation.prepared import PreparedClip


def fail_without_neutral(clips: Clips, failed: dict[str, MotionError]) -> None:
    """Fails clips whose named neutral is not in the bank, and then the clips whose neutral has failed."""
    neutrals = {name: one.source.settings.neutral for name, one in clips.items() if name not in failed}
    while missing := {name: neutral for name, neutral in neutrals.items() if neutral and neutral not in neutrals}:
        for name, neutral in missing.items():
            problem = f"its neutral {neutral!r} is not in the bank"
            failed[name] = SettingsError(problem, place=f"clip {name!r}", mend=did_you_mean(neutral, neutrals))
            del neutrals[name]


@dataclass(frozen=True, slots=True)
class Label:
    """What a clip is in its bank: its neutral, and whether it is a standing action. warning: empty if there is none."""

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
    walks: dict[str, bool] = {}
    named: dict[str, str] = {}
    cuts, hybrids, actions = set[str](), set[str](), dict[str, ShownGait]()
    locomotions, only = list[ShownGait](), list[ShownGait]()
    for name, one in clips.items():
        walks[name], named[name] = one.alignment.has_gait, one.neutral
        cuts |= {name} if one.cut is not None else set()
        hybrids |= {name} if one.stretches else set()
        if one.kind == "locomotion":
            locomotions.append(ShownGait.of(one))
        else:
            actions[name] = ShownGait.of(one)
            only += [actions[name]] if name == baseline else []
    labels: dict[str, Label] = {}
    nearest: list[str] = []
    for name, neutral in named.items():
        if name in cuts and walks.get(neutral) != walks[name]:
            neutral = ""
        if name not in actions or name in hybrids or (walks[name] and walks.get(neutral, True)):
            labels[name] = Label(neutral or name)
            nearest += [name] if not neutral and name in actions else []
        elif neutral and walks[neutral]:
            warning = f"stands, so {neutral!r}, which walks, cannot be its neutral; its own frames at rest are used"
            labels[name] = Label(name, stands=True, warning=warning)
        else:
            labels[name] = Label(neutral or name, stands=True)
    found = nearest_gaits([actions[name] for name in nearest], locomotions or only)
    return labels | {name: Label(neutral) for name, neutral in zip(nearest, found, strict=True)}
