from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.preparation.neutral import AT_ONCE, TEMPO_WEIGHT, ShownGait, nearest_gaits

BINS = 4


def naive(action: ShownGait, locomotions: list[ShownGait]) -> str:
    """The slow, readable twin of `nearest_gaits`, for one action."""
    apart = {}
    for one in [one for one in locomotions if one.shows_a_stride] or locomotions:
        squares = np.sum((one.gait - action.gait) ** 2, axis=-1)
        common = squares[np.isfinite(squares)]
        difference = np.sqrt(common.mean()) if len(common) else np.inf
        apart[one.name] = float(difference) + TEMPO_WEIGHT * abs(np.log(one.tempo / action.tempo))
    return min(apart, key=lambda name: (apart[name], name))


def gait(random: np.random.Generator) -> Floats:
    found = random.normal(size=(BINS, 3, 3))
    found[random.random(BINS) < 0.3] = np.nan
    return found


@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.sampled_from(["some", "all", "none"]))
def test_the_nearest_gait_is_that_of_the_twin(seed: int, count: int, usable: str) -> None:
    random = np.random.default_rng(seed)
    gaits = [gait(random) for _ in range(count)]

    def shown(name: str, gait: Floats) -> ShownGait:
        shows = {"some": bool(random.integers(2)), "all": True, "none": False}[usable]
        return ShownGait(name, gait, float(random.uniform(0.5, 2.0)), shows)

    locomotions = [shown(f"{random.integers(100):02}-{number}", gait) for number, gait in enumerate(gaits)]
    actions = [shown(str(number), gait(random)) for number in range(3)]
    assert nearest_gaits(actions, locomotions) == [naive(action, locomotions) for action in actions]


def test_more_gaits_than_are_compared_at_once_are_all_compared() -> None:
    random = np.random.default_rng(3)
    actions, locomotions = (
        [
            ShownGait(f"{kind}-{number:03}", gait(random), float(random.uniform(0.5, 2.0)), True)
            for number in range(count)
        ]
        for kind, count in (("action", AT_ONCE + 2), ("walk", 2 * AT_ONCE + 1))
    )
    nearest = nearest_gaits(actions, locomotions)
    for number in (0, AT_ONCE - 1, AT_ONCE, AT_ONCE + 1):
        assert nearest[number] == naive(actions[number], locomotions)
    last = ShownGait("wave", locomotions[-1].gait, locomotions[-1].tempo, True)
    assert nearest_gaits([last], locomotions) == [locomotions[-1].name]


def test_of_equals_the_first_by_name_is_taken() -> None:
    still = np.zeros((BINS, 3, 3))
    locomotions = [ShownGait(name, still, 1.0, True) for name in ("c", "a", "b")]
    assert nearest_gaits([ShownGait("wave", still, 1.0, True)], locomotions) == ["a"]
    nothing = np.full((BINS, 3, 3), np.nan)
    assert nearest_gaits([ShownGait("wave", nothing, 1.0, True)], locomotions) == ["a"]


def test_without_actions_no_locomotion_is_needed() -> None:
    assert nearest_gaits([], []) == []
