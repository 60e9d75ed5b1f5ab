"""The clips and hands that rows of characters refer to: where in a row, checked, listed and renumbered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col

States = NDArray[np.float64]
Numbers = NDArray[np.int64]
Places = tuple[Numbers, ...]


def clip_references(state: States) -> tuple[Places, Numbers]:
    """Returns the places in rows [n, COLUMNS] that hold numbers of clips, played or waiting, and these numbers."""
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
    """Returns the places in rows [n, COLUMNS] that hold numbers of hands, worn or waiting, and these numbers."""
    slots = col.FIRST_HANDS + col.HANDS_COLUMNS * np.arange(col.MOST_HANDS + 1) + col.CLIP  # the last slot waits
    used = state[:, slots] != col.BARE
    used[:, :-1] &= np.arange(col.MOST_HANDS) < state[:, [col.HANDS]]
    used[:, -1] &= state[:, col.HANDS_WAIT] > 0.0
    rows, number = np.nonzero(used)
    at = rows, slots[number]
    return at, state[at].astype(np.int64)


def missing_names(state: States, bank: Bank, other: Bank) -> set[str]:
    """Returns the names of clips and hands that rows refer to and that the bank `other` does not have."""
    clips = {bank.numbered[number].name for number in np.unique(clip_references(state)[1]).tolist()}
    hands = {bank.hand_clips[number] for number in np.unique(hands_references(state)[1]).tolist()}
    return (clips - {clip.name for clip in other.numbered}) | (hands - set(other.hand_clips))


def renumbered(state: States, bank: Bank, other: Bank) -> States:
    """Returns a copy of rows with the numbers that their clips and hands have in the bank `other`."""
    at, played = clip_references(state)
    numbers = np.zeros(len(bank.numbered))
    for number in np.unique(played).tolist():
        numbers[number] = other.number(bank.numbered[number].name)
    result = state.copy()
    result[at] = numbers[played]
    at, worn = hands_references(state)
    result[at] = [other.hand_number(bank.hand_clips[number]) for number in worn]
    return result


def newest_mix(s: States) -> tuple[list[int], Numbers]:
    """Returns the clips of a row's waiting group, else of its newest group, and the columns of their weights."""
    if s[col.NEXT_COUNT]:
        numbers = np.arange(int(s[col.NEXT_COUNT]))
        return s[col.NEXT_CLIPS + numbers].astype(int).tolist(), col.NEXT_WEIGHTS + numbers
    slots = col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS * np.arange(int(s[col.LOCOMOTIONS]))
    newest = slots[np.flatnonzero(s[slots + col.HEAD])[-1] :]
    return s[newest + col.CLIP].astype(int).tolist(), newest + col.GOAL


def newest_action(s: States) -> int | None:
    """Returns the first column of a row's waiting action, else of its newest action; None if it has no action."""
    if s[col.WHEN]:
        return col.NEXT_ACTION
    return col.FIRST_ACTION + (int(s[col.ACTIONS]) - 1) * col.ACTION_COLUMNS if s[col.ACTIONS] else None
