"""What a character plays in a transition, played on without it.

Each group of locomotions by itself; and that under no action, under the lowest, under the two lowest, and so on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from bench.characters.joint_speeds import RATE, Watch, shown
from motionsplice.runtime.character import Characters, States
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.stage import Stage

FRAMES = 240  # that it is played on
AT_ONCE = 2000  # characters
LEGS = col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS * np.arange(col.MOST_LOCOMOTIONS)
LAYERS = col.FIRST_ACTION + col.ACTION_COLUMNS * np.arange(col.MOST_ACTIONS)


def what_is_played(state: States) -> NDArray[np.float64]:
    """What of each row [n] says which slots there are, of what."""
    legs, layers = (
        state[:, LEGS[:, None] + [col.CLIP, col.HEAD]],
        state[:, LAYERS[:, None] + [col.CLIP, col.KIND, col.MASK]],
    )
    legs[np.arange(len(LEGS)) >= state[:, [col.LOCOMOTIONS]]] = -1.0
    layers[np.arange(len(LAYERS)) >= state[:, [col.ACTIONS]]] = -1.0
    return np.concatenate([legs.reshape(len(state), -1), layers.reshape(len(state), -1)], axis=1)


def steadily(row: States) -> Iterator[States]:
    """The rows of characters who play what one plays, without transitions."""
    count = int(row[col.LOCOMOTIONS])
    heads = [number for number in range(count) if row[LEGS[number] + col.HEAD]]
    for head in heads:
        size = int(row[LEGS[head] + col.HEAD])
        alone = row.copy()
        alone[[col.NEXT_COUNT, col.WHEN, col.HANDS_WAIT]] = 0.0
        alone[LEGS[0] : LEGS[size - 1] + col.LOCOMOTION_COLUMNS] = row[
            LEGS[head] : LEGS[head + size - 1] + col.LOCOMOTION_COLUMNS
        ]
        alone[col.LOCOMOTIONS] = size
        alone[LEGS + col.LASTING] = alone[LAYERS + col.LASTING] = alone[LAYERS + col.LEAVING] = 0.0
        alone[LEGS + col.SHARE] = alone[LEGS + col.WEIGHT]
        alone[LAYERS + col.LOOP] = 1.0
        for actions in range(int(row[col.ACTIONS]) + 1):
            under = alone.copy()
            under[col.ACTIONS] = actions
            yield under


def is_fading(state: States) -> NDArray[np.bool_]:
    """Whether anything is being faded in, of each row [n]: a clip that begins again over itself, if nothing else."""
    legs = state[:, LEGS + col.ELAPSED] < state[:, LEGS + col.LASTING]
    legs &= (state[:, LEGS + col.HEAD] > 0.0) & (np.arange(len(LEGS)) < state[:, [col.LOCOMOTIONS]])
    layers = state[:, LAYERS + col.ELAPSED] < state[:, LAYERS + col.LASTING]
    layers &= np.arange(len(LAYERS)) < state[:, [col.ACTIONS]]
    return np.asarray(legs[:, 1:].any(axis=1) | layers.any(axis=1))


def played_on(stage: Stage, rows: Sequence[States]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The fastest joint of each row [n] while it is played on, and the most that a joint's velocity changes in a frame
    of that."""
    watches = []
    for first in range(0, len(rows), AT_ONCE):
        characters = Characters(stage, RATE, np.array(rows[first : first + AT_ONCE]))
        watches.append(Watch(len(characters)))
        for _ in range(FRAMES):
            watches[-1].see(shown(characters), ~is_fading(characters.state))
            characters.advance()
    return np.concatenate([one.speed for one in watches]), np.concatenate([one.jump for one in watches])
