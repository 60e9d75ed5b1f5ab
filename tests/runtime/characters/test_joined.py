"""Characters that are joined, so that one call advances or evaluates all."""

from __future__ import annotations

import numpy as np
import pytest

from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.requests import Posture
from motionsplice.runtime.stage import Stage

POSTURES: tuple[Posture, ...] = ("relative", "running", "off")


def acting(stage: Stage, posture: Posture) -> Characters:
    characters = Characters(stage, 60.0)
    characters.add(2, "walk")
    characters.act(1, Action("wave", posture=posture))
    return characters


def pass_frames(characters: Characters, count: int) -> None:
    for _ in range(count):
        characters.evaluate(characters.stage.evaluator.poses(len(characters)))
        characters.advance()


def test_they_move_as_they_would_alone(stage: Stage) -> None:
    parts, alone = ([acting(stage, posture) for posture in POSTURES] for _ in range(2))
    whole = Characters.joined(parts)
    pass_frames(whole, 20)
    parts[1].add(1, "run")
    parts[2].remove(0)
    pass_frames(whole, 1)  # of which only the first part takes notice
    for one, posture in zip(alone, POSTURES, strict=True):
        pass_frames(one, 21 if posture == "relative" else 20)
    alone[1].add(1, "run")
    alone[2].remove(0)
    for one, other in zip(parts, alone, strict=True):
        assert one.state.tobytes() == other.state.tobytes()


def test_one_part_is_its_own_whole(stage: Stage) -> None:
    part = acting(stage, "off")
    assert Characters.joined([part]) is part


@pytest.mark.parametrize("posture", POSTURES)
def test_what_is_remembered_is_all_that_later_poses_depend_on(stage: Stage, posture: Posture) -> None:
    shown, unseen = acting(stage, posture), acting(stage, posture)
    pass_frames(shown, 30)
    for _ in range(30):
        unseen.remember()
        unseen.advance()
    poses, others = (stage.evaluator.poses(2) for _ in range(2))
    shown.evaluate(poses)
    unseen.evaluate(others)
    np.testing.assert_array_equal(poses.rotations, others.rotations)
    np.testing.assert_array_equal(poses.root_positions, others.root_positions)
    assert shown.state.tobytes() == unseen.state.tobytes()
