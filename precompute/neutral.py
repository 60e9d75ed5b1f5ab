"""The neutral of an action: the same gait without the action, to which its posture is relative (docs/method.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motion.kinematics import joint_positions
from motion.quaternion import Floats
from motion.roles import Roles
from precompute.baseline import facing
from precompute.prepared import PreparedClip

PHASE_BINS = 12
TEMPO_WEIGHT = 0.1  # metres of difference for a tempo that differs by a factor of e


def nearest_gait(action: PreparedClip, locomotions: Mapping[str, PreparedClip], roles: Roles) -> str:
    """The name of the one among `locomotions` whose legs move most like the action's.

    Compared are the mean lower clouds by phase, and the tempo.
    """
    profile, tempo = _profile(action, roles), _tempo(action)
    apart = {}
    for name, one in locomotions.items():
        squares = np.sum((_profile(one, roles) - profile) ** 2, axis=-1)
        common = squares[np.isfinite(squares)]
        difference = np.sqrt(common.mean()) if len(common) else np.inf
        apart[name] = float(difference) + TEMPO_WEIGHT * abs(np.log(_tempo(one) / tempo))
    return min(apart, key=lambda name: (apart[name], name))


def _profile(one: PreparedClip, roles: Roles) -> Floats:
    """Mean lower cloud by phase [PHASE_BINS, 3, 3]; NaN where the clip never is."""
    clouds = facing(joint_positions(one.clip), roles)
    bins = (np.mod(one.alignment.phase, 1.0) * PHASE_BINS).astype(np.int64) % PHASE_BINS
    return np.array(
        [
            clouds[bins == one_bin].mean(axis=0) if np.any(bins == one_bin) else np.full((3, 3), np.nan)
            for one_bin in range(PHASE_BINS)
        ]
    )


def _tempo(one: PreparedClip) -> float:
    """Cycles per second."""
    return one.alignment.cycles / one.clip.duration
