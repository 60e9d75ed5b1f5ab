"""At which moment of their clips characters are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.characters import state as col

Floats = NDArray[np.float64]


def phases(state: Floats) -> Floats:
    """Returns the phase [n] of the newest locomotion of rows [n, COLUMNS], in strides of the baseline."""
    return _of_newest(state, col.LOCOMOTIONS, col.FIRST_LOCOMOTION, col.LOCOMOTION_COLUMNS, col.PHASE)


def action_times(state: Floats, rates: Floats, begins: Floats) -> Floats:
    """Returns how many seconds [n] into the newest action rows [n, COLUMNS] are; NaN without one.

    Times past the clip's last frame are in its seam (docs/bank.md). `rates` are those of the bank's clips, `begins` the
    seconds into a hybrid at which its stretches begin, 0 for other clips.
    """
    slots = col.ACTIONS, col.FIRST_ACTION, col.ACTION_COLUMNS
    kinds, clips, frames = (_of_newest(state, *slots, column) for column in (col.KIND, col.CLIP, col.FRAME))
    plays = (state[:, col.ACTIONS] > 0.0) & (kinds != col.OWN)
    played = np.where(plays, clips, 0).astype(np.int64)
    return np.where(plays, begins[played] + frames / rates[played], np.nan)


def _of_newest(state: Floats, count: int, first: int, width: int, column: int) -> Floats:
    """Returns a column [n] of each row's newest slot: the last of the `count` slots that begin at `first`."""
    newest = np.maximum(state[:, count] - 1.0, 0.0).astype(np.int64)
    return state[np.arange(len(state)), first + width * newest + column]
