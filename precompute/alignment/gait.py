"""A summary of how a clip's legs move: its mean lower cloud by phase."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.quaternion import Floats

PHASE_BINS = 12


def mean_gait(clouds: Floats, phase: Floats) -> Floats:
    """Returns the mean of lower clouds [F, 3, 3] by phase [PHASE_BINS, 3, 3], metres.

    clouds: of `facing`. NaN in bins that no `phase` [F] falls in.
    """
    bins = (np.mod(phase, 1.0) * PHASE_BINS).astype(np.int64) % PHASE_BINS
    counts = np.bincount(bins, minlength=PHASE_BINS)
    columns = [np.bincount(bins, column, PHASE_BINS) for column in clouds.reshape(-1, 9).T]  # faster than np.add.at
    sums = np.stack(columns, axis=1).reshape(-1, 3, 3)
    return np.where(counts[:, None, None] > 0, sums / np.maximum(counts, 1)[:, None, None], np.nan)
