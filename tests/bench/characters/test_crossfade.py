from __future__ import annotations

import numpy as np
import pytest

from bench.characters.crossfade import crossfade
from bench.characters.feet import standing_feet
from bench.characters.joint_speeds import RATE, character_positions
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

FRAMES = 60


@pytest.mark.parametrize("clip", ["walk", "run", "turn_180"])
def test_one_clip_alone_goes_where_a_character_goes(bank: Bank, clip: str) -> None:
    stage = Stage(Evaluator(bank))
    characters = Characters(stage, RATE)
    characters.add(1, clip, time=0.4)
    before = crossfade(stage, bank.clip(clip), bank.clip("side_step"), 0.4, np.zeros(FRAMES))
    after = crossfade(stage, bank.clip("side_step"), bank.clip(clip), 0.3, np.ones(FRAMES))
    for frame in range(FRAMES):
        np.testing.assert_allclose(before[0][frame], character_positions(characters)[0], atol=1e-4)
        np.testing.assert_array_equal(before[1][frame], standing_feet(characters)[0])
        characters.advance()
    beginning = crossfade(stage, bank.clip(clip), bank.clip("run"), 0.0, np.zeros(FRAMES))
    np.testing.assert_allclose(after[0], beginning[0], atol=1e-5)


def test_halfway_a_crossfade_goes_as_far_as_the_mean_of_both(bank: Bank) -> None:
    stage, shares = Stage(Evaluator(bank)), np.full(FRAMES, 0.5)
    walk, run = bank.clip("walk"), bank.clip("run")
    mixed, walked, ran = (
        crossfade(stage, first, second, 0.0, shares)[0][:, 0]
        for first, second in ((walk, run), (walk, walk), (run, run))
    )
    np.testing.assert_allclose(mixed, 0.5 * (walked + ran), atol=0.06)  # x: they do not go exactly the same way
