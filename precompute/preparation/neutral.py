"""The neutral of an action: the same gait without the action. Posture is relative to it (docs/method.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motionsplice.precompute.preparation.prepared import PreparedClip

TEMPO_WEIGHT = 0.1  # metres that a tempo ratio of e adds to the distance of two gaits
FEWEST_STRIDES = 1.5  # of a neutral: less shows no mean stride


def nearest_gait(action: PreparedClip, locomotions: Mapping[str, PreparedClip]) -> str:
    """Returns the name of the locomotion whose legs move most like the action's.

    Compares the mean lower clouds by phase, and the tempo. Of equals, the first by name. Locomotions of less than
    FEWEST_STRIDES that are no whole cycles, or whose legs do not move as in a gait, count only if there are no others.
    """
    tempo = _tempo(action)
    usable = {name: one for name, one in locomotions.items() if _shows_a_stride(one)}
    apart = {}
    for name, locomotion in (usable or locomotions).items():
        squares = np.sum((locomotion.gait - action.gait) ** 2, axis=-1)
        common = squares[np.isfinite(squares)]
        difference = np.sqrt(common.mean()) if len(common) else np.inf
        apart[name] = float(difference) + TEMPO_WEIGHT * abs(np.log(_tempo(locomotion) / tempo))
    return min(apart, key=lambda name: (apart[name], name))


def _shows_a_stride(clip: PreparedClip) -> bool:
    return clip.alignment.has_gait and (clip.period > 0 or clip.alignment.cycles >= FEWEST_STRIDES)


def _tempo(clip: PreparedClip) -> float:
    """Returns the clip's cycles per second."""
    return clip.alignment.cycles * clip.rate / (clip.frame_count - 1)
