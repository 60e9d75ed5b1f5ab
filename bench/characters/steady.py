"""Steady playback: plays what a character plays in a transition, but without the transition.

Each group of locomotions is played alone, and then under no action, the lowest action, the two lowest, and so on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from bench.characters.joint_speeds import RATE, Watch, character_positions
from motionsplice.runtime.character import Characters
from motionsplice.runtime.character_rows import States
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aim import PARTS
from motionsplice.runtime.stage import Stage

FRAMES = 240  # of steady playback
AT_ONCE = 2000  # characters, to limit memory
WANTED = np.array([col.WANTED_WEIGHT, col.WANTED_SPINE, col.WANTED_STEADY])
LEGS = col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS * np.arange(col.MOST_LOCOMOTIONS)
LAYERS = col.FIRST_ACTION + col.ACTION_COLUMNS * np.arange(col.MOST_ACTIONS)


def slot_contents(state: States) -> NDArray[np.float64]:
    """Returns the columns of each state row [n] that identify its slots and their clips; -1 in unused slots."""
    legs, layers = (
        state[:, LEGS[:, None] + [col.CLIP, col.HEAD]],
        state[:, LAYERS[:, None] + [col.CLIP, col.KIND, col.MASK]],
    )
    legs[np.arange(len(LEGS)) >= state[:, [col.LOCOMOTIONS]]] = -1.0
    layers[np.arange(len(LAYERS)) >= state[:, [col.ACTIONS]]] = -1.0
    return np.concatenate([legs.reshape(len(state), -1), layers.reshape(len(state), -1)], axis=1)


def steady_rows(row: States) -> Iterator[States]:
    """Yields state rows of characters that together play everything in `row`, each without transitions."""
    count = int(row[col.LOCOMOTIONS])
    heads = [number for number in range(count) if row[LEGS[number] + col.HEAD]]
    for head in heads:
        alone = alone_of(row, head)
        alone[[col.NEXT_COUNT, col.WHEN, col.HANDS_WAIT, col.LOCK, col.LOCKED]] = 0.0
        alone[LEGS + col.LASTING] = alone[LAYERS + col.LASTING] = alone[LAYERS + col.LEAVING] = 0.0
        alone[LAYERS + col.LOOP] = 1.0
        for part in PARTS.values():
            alone[part + col.CHANGED : part + col.AIM_COLUMNS] = 0.0
            alone[[part + col.SHOWN, part + col.SPINE, part + col.STEADY]] = alone[part + WANTED]
        for actions in range(int(row[col.ACTIONS]) + 1):
            under = alone.copy()
            under[col.ACTIONS] = actions
            yield under


def alone_of(row: States, head: int) -> States:
    """Returns a state row that plays nothing but the group of locomotions that begins at slot `head`."""
    size, alone = int(row[LEGS[head] + col.HEAD]), row.copy()
    alone[LEGS[0] : LEGS[size - 1] + col.LOCOMOTION_COLUMNS] = row[
        LEGS[head] : LEGS[head + size - 1] + col.LOCOMOTION_COLUMNS
    ]
    alone[col.LOCOMOTIONS] = size
    alone[LEGS + col.SHARE] = alone[LEGS + col.WEIGHT]
    return alone


def is_fading(state: States) -> NDArray[np.bool_]:
    """Returns for each row [n] whether any slot is fading in. A clip that blends into its own start counts too."""
    legs = state[:, LEGS + col.ELAPSED] < state[:, LEGS + col.LASTING]
    legs &= (state[:, LEGS + col.HEAD] > 0.0) & (np.arange(len(LEGS)) < state[:, [col.LOCOMOTIONS]])
    layers = state[:, LAYERS + col.ELAPSED] < state[:, LAYERS + col.LASTING]
    layers &= np.arange(len(LAYERS)) < state[:, [col.ACTIONS]]
    return np.asarray(legs[:, 1:].any(axis=1) | layers.any(axis=1))


def play_on(stage: Stage, rows: Sequence[States]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Plays state rows on for FRAMES, and returns two arrays [n], metres per second.

    The first is the speed of the fastest joint, the second the largest change of a joint's velocity between two frames.
    Frames in which a slot fades in do not count.
    """
    watches = []
    for first in range(0, len(rows), AT_ONCE):
        characters = Characters(stage, RATE, np.array(rows[first : first + AT_ONCE]))
        watches.append(Watch(len(characters)))
        for _ in range(FRAMES):
            watches[-1].add(character_positions(characters), ~is_fading(characters.state))
            characters.advance()
    return np.concatenate([watch.speed for watch in watches]), np.concatenate([watch.jump for watch in watches])
