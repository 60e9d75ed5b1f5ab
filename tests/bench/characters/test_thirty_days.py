from __future__ import annotations

import numpy as np

from bench.characters.thirty_days import RATE, hour
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage


def test_far_from_the_origin_only_positions_in_the_world_are_rough(bank: Bank) -> None:
    characters = Characters(Stage(Evaluator(bank)), RATE)
    characters.add(2, "walk")
    characters.place([1], [50_000.0, 0.0, 50_000.0])
    with_origins, in_the_world = hour(characters, 60)
    np.testing.assert_allclose(with_origins[1], with_origins[0], rtol=0.01)
    assert in_the_world[1] > 1.5 * with_origins[1]
    np.testing.assert_allclose(in_the_world[0], with_origins[0], rtol=0.01)
