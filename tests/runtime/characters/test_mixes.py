"""Locomotions in step: transitions and mixes."""

from __future__ import annotations

import numpy as np
import pytest

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from tests.playing import RATE, Setup, run_frames, slot


def test_a_new_locomotion_enters_in_step(one: Setup) -> None:
    characters = one()
    characters.add(1, "walk", time=0.4)
    run_frames(characters, 37)
    characters.play([0], "run", blend=0.5)
    assert characters.state[0, col.LOCOMOTIONS] == 2
    for _ in range(25):
        apart = slot(characters, 0, col.PHASE) - slot(characters, 1, col.PHASE)
        assert abs(apart - round(apart)) < 1e-9
        characters.advance()
    run_frames(characters, 6)
    assert characters.state[0, col.LOCOMOTIONS] == 1


def test_the_clips_of_a_first_mix_are_in_step_with_each_other(one: Setup) -> None:
    characters = one()
    characters.add(1, {"walk": 0.5, "run": 0.3, "side_step": 0.2}, time=0.4)
    for _ in range(100):
        phases = np.array([slot(characters, number, col.PHASE) for number in range(3)])
        np.testing.assert_allclose((phases - phases[0] + 0.5) % 1.0, 0.5, atol=1e-9)
        characters.advance()


@pytest.mark.parametrize("name", ["walk", "run", "carry_box", "turn_180"])
def test_a_clip_with_nearly_all_weight_plays_as_alone(one: Setup, name: str) -> None:
    """The test goes past the clip's end and through its seam, where its phase bends."""
    alone, mixed = one(), one()
    for characters in (alone, mixed):
        characters.add(1, name, time=0.013)  # so that no frame falls exactly on the last one
    mixed.play([0], "side_step", blend=1e6)
    for _ in range(500):
        assert slot(mixed, 0, col.FRAME) == pytest.approx(slot(alone, 0, col.FRAME), abs=1e-3)
        for characters in (alone, mixed):
            characters.advance()


def test_mixed_gaits_play_as_fast_as_captured_on_average(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, {"walk": 0.3, "run": 0.7})
    speeds = []
    for _ in range(60):  # neither clip ends
        before = [slot(characters, number, col.FRAME) for number in (0, 1)]
        characters.advance()
        passed = [slot(characters, number, col.FRAME) - before[number] for number in (0, 1)]
        speeds.append(
            [RATE * frames / bank.clip(name).rate for frames, name in zip(passed, ("walk", "run"), strict=True)]
        )
    np.testing.assert_allclose(np.dot(speeds, [0.3, 0.7]), 1.0, atol=0.03)
    walked, ran = np.mean(speeds, axis=0)
    assert walked > 1.05 > 0.95 > ran


def test_a_mix_follows_its_weights_and_its_speed_lies_between(one: Setup) -> None:
    characters = one()
    characters.add(1, {"walk": 1.0, "run": 0.0})
    speeds = []
    for weight in (0.0, 0.5, 1.0):
        characters.mix([0], {"walk": 1.0 - weight, "run": weight})
        run_frames(characters, 60)
        before = characters.state[0, col.PLACE + 2]
        run_frames(characters, 120)
        speeds.append((characters.state[0, col.PLACE + 2] - before) / 2.0)
    assert speeds[0] < speeds[1] - 0.3 < speeds[2] - 0.6
    with pytest.raises(SettingsError, match="not one of the locomotions"):
        characters.mix([0], {"side_step": 1.0})


def test_a_group_waits_until_slots_are_free(one: Setup) -> None:
    characters = one()
    characters.add(1, {"walk": 1.0, "run": 1.0, "side_step": 1.0})
    characters.play([0], {"walk": 1.0, "run": 1.0, "side_step": 1.0}, blend=0.5)
    characters.play([0], {"walk": 1.0, "turn_180": 1.0, "stairs_up": 1.0}, blend=0.5)
    assert characters.state[0, col.NEXT_COUNT] == 3
    run_frames(characters, 32)
    assert characters.state[0, col.NEXT_COUNT] == 0


def test_a_clip_held_at_its_end_does_not_slow_down_the_next_one(one: Setup) -> None:
    held, alone = one(), one()
    held.add(1, "walk", loop=False)
    run_frames(held, 400)
    ended = slot(held, 0, col.FRAME)
    held.play([0], "run", blend=0.5)
    alone.add(1, "run")
    alone.state[0, col.FIRST_LOCOMOTION : col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS] = held.state[
        0, col.FIRST_LOCOMOTION + col.LOCOMOTION_COLUMNS : col.FIRST_LOCOMOTION + 2 * col.LOCOMOTION_COLUMNS
    ]
    for _ in range(28):
        for characters in (held, alone):
            characters.advance()
        assert slot(held, 1, col.FRAME) == pytest.approx(slot(alone, 0, col.FRAME), abs=1e-6)
        assert slot(held, 0, col.FRAME) == ended


def test_a_mix_without_a_loop_ends_and_is_held(one: Setup, bank: Bank) -> None:
    """The run ends first; the rest of the walk then plays as fast as captured."""
    characters = one()
    characters.add(1, {"walk": 0.5, "run": 0.5}, loop=False)
    last = {name: bank.clip(name).frame_count - 1.0 for name in ("walk", "run")}
    speeds = []
    for _ in range(500):
        run_ended, before = slot(characters, 1, col.FRAME) == last["run"], slot(characters, 0, col.FRAME)
        characters.advance()
        walked = slot(characters, 0, col.FRAME) - before
        assert walked >= 0.0
        if run_ended and slot(characters, 0, col.FRAME) < last["walk"]:
            speeds.append(walked * RATE / bank.clip("walk").rate)
    np.testing.assert_allclose(speeds, 1.0, atol=1e-6)
    assert len(speeds) > 20
    assert (slot(characters, 0, col.FRAME), slot(characters, 1, col.FRAME)) == (last["walk"], last["run"])
    assert not characters.deltas.any()
