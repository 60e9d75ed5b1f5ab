"""Events of characters: actions that begin and end, feet, strides, and locomotions that end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from tests.playing import RATE, Setup, evaluated, layer, run_frames


def test_an_action_without_a_loop_ends_with_an_event(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "walk")
    characters.act([0], Action("wave", loop=False, blend_out=0.3))
    assert characters.events[0] & col.ACTION_BEGAN
    events = run_frames(characters, 400)
    ended = [frame for frame, bits in enumerate(events) if bits & col.ACTION_ENDED]
    assert len(ended) == 1
    assert ended[0] / RATE == pytest.approx(bank.clip("wave").duration, abs=0.8)
    assert characters.state[0, col.ACTIONS] == 0
    assert bank.clips[int(characters.state[0, col.ENDED])].name == "wave"


def test_an_action_begins_at_the_commanded_moment(one: Setup, bank: Bank) -> None:
    for when, event in (("left_foot", col.LEFT_DOWN), ("right_foot", col.RIGHT_DOWN)):
        characters = one()
        characters.add(1, "walk")
        characters.act([0], Action("wave", when=when))  # type: ignore[arg-type]
        begun = next(bits for bits in run_frames(characters, 200) if bits & col.ACTION_BEGAN)
        assert begun & event
    characters = one()
    characters.add(1, "walk")
    characters.act([0], Action("wave", when="phase", start=0.7))
    for _ in range(200):
        if characters.advance() & col.ACTION_BEGAN:
            break
    assert layer(characters, 0, col.FRAME) / bank.clip("wave").rate == pytest.approx(0.7, abs=0.05)


def test_strides_and_contacts_are_events(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "walk")
    events = run_frames(characters, round(bank.clip("walk").duration * RATE) - 1)
    contacts = bank.contacts("walk")
    for foot, bit in (("left", col.LEFT_DOWN), ("right", col.RIGHT_DOWN)):
        downs = [contact.down for contact in contacts if contact.foot == foot and contact.down > 0.0]
        times = [(frame + 1) / RATE for frame, bits in enumerate(events) if bits & bit]
        np.testing.assert_allclose([one for one in times if one > 0.1], [one for one in downs if one > 0.1], atol=0.03)
    strides = [(frame + 1) / RATE for frame, bits in enumerate(events) if bits & col.STRIDE]
    left = [contact.down for contact in contacts if contact.foot == "left" and contact.down > 0.0]
    assert all(min(abs(stride - down) for down in left) < 0.08 for stride in strides)


def test_a_locomotion_without_a_loop_is_held_with_one_event(one: Setup) -> None:
    characters = one()
    characters.add(1, "stairs_up", loop=False)
    events = run_frames(characters, 400)
    assert sum(bool(bits & col.LOCOMOTION_ENDED) for bits in events) == 1
    before = evaluated(characters)
    characters.advance()
    np.testing.assert_array_equal(evaluated(characters)[0], before[0])


@pytest.mark.parametrize("locomotion", ["walk", {"side_step": 0.2, "walk": 0.8}])
def test_a_foot_that_stands_from_the_beginning_does_not_come_down(one: Setup, bank: Bank, locomotion: Any) -> None:
    stance = next(one for one in bank.contacts("walk") if one.foot == "left" and one.down > 0.1)
    characters = one()
    characters.add(1, locomotion, time=0.5 * (stance.down + stance.up))
    characters.act([0], Action("wave", when="left_foot"))
    events = run_frames(characters, 90)
    assert events[0] & (col.LEFT_DOWN | col.RIGHT_DOWN | col.ACTION_BEGAN) == 0
    down = next(frame for frame, bits in enumerate(events) if bits & col.LEFT_DOWN)
    assert [bool(bits & col.ACTION_BEGAN) for bits in events] == [frame == down for frame in range(90)]
