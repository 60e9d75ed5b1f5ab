"""The neutral of an action: the same gait without the action. Posture is relative to it (docs/method.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motionsplice.precompute.preparation.prepared import PreparedClip

TEMPO_WEIGHT = 0.1  # metres that a tempo ratio of e adds to the distance of two gaits


def nearest_gait(action: PreparedClip, locomotions: Mapping[str, PreparedClip]) -> str:
    """Returns the name of the locomotion whose legs move most like the action's.

    Compares the mean lower clouds by phase, and the tempo. Of equals, the first by name.
    """
    tempo = _tempo(action)
    apart = {}
    for name, locomotion in locomotions.items():
        squares = np.sum((locomotion.gait - action.gait) ** 2, axis=-1)
        common = squares[np.isfinite(squares)]
        difference = np.sqrt(common.mean()) if len(common) else np.inf
        apart[name] = float(difference) + TEMPO_WEIGHT * abs(np.log(_tempo(locomotion) / tempo))
    return min(apart, key=lambda name: (apart[name], name))


def _tempo(clip: PreparedClip) -> float:
    """Returns the clip's cycles per second."""
    return clip.alignment.cycles * clip.rate / (clip.frame_count - 1)
