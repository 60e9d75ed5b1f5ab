"""The rows of characters: chosen, checked, added, removed and moved to another bank."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionsplice.motion.errors import SettingsError, UnknownClipError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests.playing import RATE, Setup, run_frames


def test_a_stale_waiting_slot_is_not_looked_up_in_another_bank(one: Setup, hands_bank: Bank) -> None:
    """A waiting slot stays in its row after it has begun, and the other bank may have fewer clips."""
    characters = one()
    characters.add(1, "walk")
    characters.act([0], Action("wave", loop=False))
    run_frames(characters, 400)
    assert characters.state[0, col.NEXT_ACTION + col.CLIP] >= len(hands_bank.clips)
    moved = characters.moved(Stage(Evaluator(hands_bank)))
    part = slice(col.NEXT_ACTION, col.WHEN)
    np.testing.assert_array_equal(moved.state[:, part], characters.state[:, part])


@pytest.mark.parametrize(
    "rows", [[-1], np.array([False, False, True]), slice(2, 3), np.array([2])], ids=["back", "mask", "slice", "array"]
)
def test_rows_may_be_any_numpy_index(one: Setup, rows: Any) -> None:
    plain, other = one(), one()
    for characters, which in ((plain, [2]), (other, rows)):
        characters.add(3, "walk")
        characters.play(which, {"run": 1.0, "side_step": 1.0})
        characters.mix(which, {"run": 1.0})
        characters.act(which, Action("wave"))
        characters.weight(which, 0.5)
    assert other.state.tobytes() == plain.state.tobytes()


@pytest.mark.parametrize("rate", [0.0, -60.0, np.nan, np.inf])
def test_an_invalid_rate_is_refused(one: Setup, rate: float) -> None:
    with pytest.raises(SettingsError, match="frames per second"):
        Characters(one().stage, rate)


@pytest.mark.parametrize("column", [col.LOCOMOTIONS, col.ACTIONS, col.HANDS, col.NEXT_COUNT])
@pytest.mark.parametrize("number", [-1.0, 99.0, 0.5, np.nan])
def test_a_state_with_an_invalid_number_of_slots_is_refused(one: Setup, column: int, number: float) -> None:
    characters = one()
    characters.add(2, "walk")
    state = characters.state.copy()
    state[1, column] = number
    with pytest.raises(SettingsError, match="row 1 "):
        Characters(characters.stage, RATE, state)


@pytest.mark.parametrize("number", [-1.0, 99.0, np.nan])
def test_a_state_with_unknown_clips_is_refused(one: Setup, number: float) -> None:
    characters = one()
    characters.add(2, "walk")
    characters.act([0, 1], Action("wave", when="left_foot"))
    waits = characters.state.copy()
    characters.act([0, 1], Action("wave"))
    characters.play([0, 1], "run")
    while not characters.state[1, col.NEXT_COUNT]:  # until a group has to wait
        characters.play([0, 1], {"walk": 1.0, "side_step": 2.0})
    Characters(characters.stage, RATE, characters.state.copy())
    places = [col.FIRST_LOCOMOTION, col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS, col.FIRST_ACTION, col.NEXT_CLIPS + 1]
    for sound, column in ((waits, col.NEXT_ACTION), *((characters.state, place) for place in places)):
        state = sound.copy()
        state[1, column] = number
        with pytest.raises(SettingsError, match=r"row 1 .*another bank"):
            Characters(characters.stage, RATE, state)


def test_a_state_with_unknown_hands_is_refused(one: Setup) -> None:
    characters = one()
    characters.add(2, "walk")
    characters.state[1, [col.HANDS, col.FIRST_HANDS]] = 1.0, 0.0  # this bank has no hands
    with pytest.raises(SettingsError, match=r"row 1 .*another bank"):
        Characters(characters.stage, RATE, characters.state)


def test_characters_may_be_added_one_by_one(one: Setup) -> None:
    single, together = one(), one()
    for _ in range(40):
        single.add(1, "walk")
    together.add(40, "walk")
    assert single.state.tobytes() == together.state.tobytes()
    copied = single.copy()
    copied.add(1, "run")
    single.remove([3, 7])
    single.add(3, "wave")
    assert (len(copied), len(single)) == (41, 41)
    assert copied.state[:40].tobytes() == together.state.tobytes()
    assert single.state[:38].tobytes() == together.state[:38].tobytes()
    with pytest.raises(UnknownClipError):
        single.add(2, "wlak")
    assert len(single) == 41
