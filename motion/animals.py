"""Recognises by the names of its joints a rig that is not a human body."""

from __future__ import annotations

from motionsplice.motion.role_names import HELPERS, words_of
from motionsplice.motion.skeleton import Skeleton

OF_LEGS = ("leg", "thigh", "shin", "calf", "foot", "paw", "hoof", "hock")
HUMAN_LEGS = 2


def not_human(skeleton: Skeleton) -> str:
    """Returns in what a rig differs from a human body, such as "it has 4 legs"; "" if its names do not show it."""
    names = [words_of(name)[0] for name in skeleton.names]
    ours = [not HELPERS.intersection(words) for words in names]
    legs = [mine and any(part in "".join(words) for part in OF_LEGS) for mine, words in zip(ours, names, strict=True)]
    # A leg is two joints or more: a lone foot may be a target.
    longer = {joint for joint in range(1, len(names)) if legs[joint] and legs[skeleton.parents[joint]]}
    uppermost = {int(skeleton.parents[joint]) for joint in longer} - longer
    if len(uppermost) > HUMAN_LEGS:
        return f"it has {len(uppermost)} legs ({', '.join(skeleton.names[joint] for joint in sorted(uppermost))})"
    if any("wing" in "".join(words) for words in names) and not any("arm" in "".join(words) for words in names):
        return "it has wings in place of arms"
    return ""
