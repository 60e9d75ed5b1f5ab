"""A summary of how a clip's legs move: its mean lower cloud by phase."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.precompute.body.facing import facing, facing_joints
from motionsplice.precompute.body.joint_paths import joint_paths

PHASE_BINS = 12


def mean_gait(clip: Clip, phase: Floats, roles: Roles) -> Floats:
    """Returns the mean lower cloud by phase [PHASE_BINS, 3, 3], metres; NaN in bins that no `phase` [F] falls in."""
    clouds = facing(joint_paths(clip, facing_joints(roles)))
    bins = (np.mod(phase, 1.0) * PHASE_BINS).astype(np.int64) % PHASE_BINS
    counts = np.bincount(bins, minlength=PHASE_BINS)
    columns = [np.bincount(bins, column, PHASE_BINS) for column in clouds.reshape(-1, 9).T]  # faster than np.add.at
    sums = np.stack(columns, axis=1).reshape(-1, 3, 3)
    return np.where(counts[:, None, None] > 0, sums / np.maximum(counts, 1)[:, None, None], np.nan)
