"""One character that plays in real time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from motionsplice.sending.schedule import Schedule

Frame = tuple[float, NDArray[Any], NDArray[Any]]


def perform(bank: Bank, locomotion: str, action: str | None, schedule: Schedule) -> Iterator[Frame]:
    """Yields frames when they are due: seconds since the first, the root's position [3] and the rotations [J, 4].

    The next frame overwrites the arrays. Locomotion and action loop. Raises UnknownClipError before the first frame.
    """
    stage = Stage(Evaluator(bank))
    characters = Characters(stage, schedule.rate)
    characters.add(1, locomotion)
    if action is not None:
        characters.act(0, Action(action))
    poses, before = stage.evaluator.poses(1), 0
    characters.evaluate(poses)  # compiles kernels before the clock starts
    for number in schedule:
        characters.advance(number - before)
        characters.evaluate(poses)
        before = number
        yield number / schedule.rate, poses.root_positions[0], poses.rotations[0]
