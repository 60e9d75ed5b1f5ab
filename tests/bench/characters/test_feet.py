from __future__ import annotations

import numpy as np
import pytest

from bench.characters.feet import stances
from bench.characters.joint_speeds import RATE
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

DRIFT = 0.004  # metres in a frame


@pytest.fixture
def walker(bank: Bank) -> Characters:
    characters = Characters(Stage(Evaluator(bank)), RATE)
    characters.add(1, "walk")
    return characters


def test_each_stance_of_a_walk_is_found(walker: Characters, bank: Bank) -> None:
    whole = [one for one in bank.contacts("walk") if one.down > 0.0 and one.up < 4.0]
    found = sorted(stances(walker, 241), key=lambda one: one.first)
    np.testing.assert_allclose([one.first / RATE for one in found], [one.down for one in whole], atol=1.5 / RATE)
    np.testing.assert_allclose([(one.end - 1) / RATE for one in found], [one.up for one in whole], atol=1.5 / RATE)
    assert max(one.slide for one in found) < 0.015


def test_a_character_that_is_pushed_slides_by_the_push(walker: Characters) -> None:
    def push(_: int) -> None:
        walker.state[0, col.PLACE] += DRIFT

    for one in stances(walker, 241, push):
        assert one.slide == pytest.approx(DRIFT * (one.end - one.first - 1), abs=0.015)
