"""Rows of numbers between frames."""

from __future__ import annotations

import numpy as np

from motionsplice.motion.kernel_cache import compiled
from motionsplice.motion.quaternion import Floats


def sampled_rows(rows: Floats, frames: Floats) -> Floats:
    """Returns rows [F, ...] at real-valued `frames` [n], as `quaternion.interpolated`, but faster for small arrays."""
    sampled = np.empty((len(frames), *rows.shape[1:]))
    sample_rows(np.ascontiguousarray(rows).reshape(len(rows), -1), frames, sampled.reshape(len(frames), -1))
    return sampled


@compiled(nogil=True, error_model="numpy")
def sample_rows(rows: Floats, frames: Floats, sampled: Floats) -> None:
    """Fills `sampled` [n, columns] from rows [F, columns]; see `sampled_rows`."""
    last = len(rows) - 1
    for k in range(len(frames)):
        at = min(max(frames[k], 0.0), float(last))
        before = min(int(at), max(last - 1, 0))
        after, t = min(before + 1, last), at - before
        for i in range(rows.shape[1]):
            sampled[k, i] = rows[before, i] + t * (rows[after, i] - rows[before, i])
