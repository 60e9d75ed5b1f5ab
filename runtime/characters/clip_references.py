"""Which clips and hands the rows of characters name, and where in a row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.characters import state as col

States = NDArray[np.float64]
Numbers = NDArray[np.int64]
Places = tuple[Numbers, ...]


def clip_references(state: States) -> tuple[Places, Numbers]:
    """Where in rows [n, COLUMNS] there are numbers of clips that are played or wait to be, and these."""
    mixed = col.NEXT_CLIPS + np.arange(col.MOST_MIXED)
    legs = col.FIRST_LOCOMOTION + col.CLIP + col.LOCOMOTION_COLUMNS * np.arange(col.MOST_LOCOMOTIONS)
    layers = col.FIRST_ACTION + col.CLIP + col.ACTION_COLUMNS * np.arange(col.MOST_ACTIONS)
    counted = ((legs, col.LOCOMOTIONS), (layers, col.ACTIONS), (mixed, col.NEXT_COUNT))
    used = np.zeros(state.shape, np.bool_)
    for columns, count in counted:
        used[:, columns] = np.arange(len(columns)) < state[:, [count]]
    used[:, layers] &= state[:, layers + col.KIND - col.CLIP] != col.OWN
    waits, is_own = state[:, col.WHEN] > 0, state[:, col.NEXT_ACTION + col.KIND] == col.OWN
    used[:, col.NEXT_ACTION + col.CLIP] = waits & ~is_own
    at = np.nonzero(used)
    return at, state[at].astype(np.int64)


def hands_references(state: States) -> tuple[Places, Numbers]:
    """Where in rows there are numbers of hands that are worn or wait to be, and these."""
    slots = col.FIRST_HANDS + col.HANDS_COLUMNS * np.arange(col.MOST_HANDS + 1) + col.CLIP  # the last one waits
    used = state[:, slots] != col.BARE
    used[:, :-1] &= np.arange(col.MOST_HANDS) < state[:, [col.HANDS]]
    used[:, -1] &= state[:, col.HANDS_WAIT] > 0.0
    rows, number = np.nonzero(used)
    at = rows, slots[number]
    return at, state[at].astype(np.int64)


def invalid_rows(state: States, clips: int, hands: int) -> Numbers:
    """The rows [n, COLUMNS] that do not fit a bank of so many clips and hands, as those of another bank may not.

    What is looked at would lead a kernel out of its tables: how many slots there are, and what they name.
    """
    sound = np.ones(len(state), np.bool_)
    for column, least, most in (
        (col.LOCOMOTIONS, 1, col.MOST_LOCOMOTIONS),
        (col.FIRST_LOCOMOTION + col.HEAD, 1, col.MOST_MIXED),
        (col.ACTIONS, 0, col.MOST_ACTIONS),
        (col.HANDS, 0, col.MOST_HANDS),
        (col.NEXT_COUNT, 0, col.MOST_MIXED),
    ):
        sound &= np.isin(state[:, column], np.arange(least, most + 1))
    with np.errstate(invalid="ignore"):  # NaN is no number of a clip
        for (at, numbers), count in ((clip_references(state), clips), (hands_references(state), hands)):
            sound[at[0][(numbers < 0) | (numbers >= count)]] = False
    return np.flatnonzero(~sound)


def newest_mix(s: States) -> tuple[list[int], Numbers]:
    """The clips of the group that waits in a row, or else of the newest, and where in the row their weights are set."""
    if s[col.NEXT_COUNT]:
        numbers = np.arange(int(s[col.NEXT_COUNT]))
        return s[col.NEXT_CLIPS + numbers].astype(int).tolist(), col.NEXT_WEIGHTS + numbers
    slots = col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS * np.arange(int(s[col.LOCOMOTIONS]))
    newest = slots[np.flatnonzero(s[slots + col.HEAD])[-1] :]
    return s[newest + col.CLIP].astype(int).tolist(), newest + col.GOAL
