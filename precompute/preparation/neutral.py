"""The neutral of an action: the same gait without the action, to which its posture is relative (docs/method.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motionsplice.precompute.preparation.prepared import PreparedClip

TEMPO_WEIGHT = 0.1  # metres of difference for a tempo that differs by a factor of e


def nearest_gait(action: PreparedClip, locomotions: Mapping[str, PreparedClip]) -> str:
    """The name of the one among `locomotions` whose legs move most like the action's.

    Compared are the mean lower clouds by phase, and the tempo.
    """
    tempo = _tempo(action)
    apart = {}
    for name, one in locomotions.items():
        squares = np.sum((one.gait - action.gait) ** 2, axis=-1)
        common = squares[np.isfinite(squares)]
        difference = np.sqrt(common.mean()) if len(common) else np.inf
        apart[name] = float(difference) + TEMPO_WEIGHT * abs(np.log(_tempo(one) / tempo))
    return min(apart, key=lambda name: (apart[name], name))


def _tempo(one: PreparedClip) -> float:
    """Cycles per second."""
    return one.alignment.cycles * one.rate / (one.frame_count - 1)
