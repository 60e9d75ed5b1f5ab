"""Helpers of tests that play characters and read their rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action

RATE = 60.0
Setup = Callable[[], Characters]


def evaluated(characters: Characters) -> tuple[Floats, Floats]:
    """Returns root positions [n, 3] and rotations [n, J, 4] of the characters' poses."""
    poses = characters.stage.evaluator.poses(len(characters))
    characters.evaluate(poses)
    return poses.root_positions.astype(np.float64), poses.rotations.astype(np.float64)


def slot(characters: Characters, number: int, column: int, row: int = 0) -> float:
    """Returns a column of locomotion slot `number`."""
    return float(characters.state[row, col.FIRST_LOCOMOTION + number * col.LOCOMOTION_COLUMNS + column])


def layer(characters: Characters, number: int, column: int, row: int = 0) -> float:
    """Returns a column of action slot `number`."""
    return float(characters.state[row, col.FIRST_ACTION + number * col.ACTION_COLUMNS + column])


def run_frames(characters: Characters, frames: int) -> list[int]:
    """Advances frame by frame; returns the events of each frame."""
    return [characters.advance() for _ in range(frames)]


def command(characters: Characters, do: str, values: Mapping[str, Any]) -> None:
    """Adds a character, or commands the only one, with the keys of a WebSocket command."""
    if do == "add":
        characters.add(1, **values)
    elif do == "act":
        keys = dict(values)
        characters.act([0], Action(keys.pop("action"), **keys))
    else:
        getattr(characters, do)([0], **values)
