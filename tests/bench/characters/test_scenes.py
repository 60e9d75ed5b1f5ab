from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench.characters.commanded_fades import cross_fades, fastest_of_fades
from bench.characters.gaits import phases
from bench.characters.joint_speeds import RATE, Watch, character_positions
from bench.characters.replay import perform, record, replay
from bench.characters.scenes import MOST, fastest_of_scenes, pops, random_command
from bench.characters.steady import LAYERS, LEGS, is_fading, slot_contents, steady_rows
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

FEW = 20  # scenes
WAVE = Action("wave", blend=0.3)
REAL = ("16.asf", "16_15.amc", "16_17.amc", "09.asf", "09_01.amc", "02.asf", "02_03.amc", "14.asf", "14_21.amc")
seeds = st.lists(st.integers(0, 2**32 - 1), min_size=4, max_size=4)


@pytest.fixture(scope="module")
def stage(bank: Bank) -> Stage:
    return Stage(Evaluator(bank))


@pytest.fixture(scope="module")
def real_stage(real_motion: Path, tmp_path_factory: pytest.TempPathFactory) -> Stage:
    """Two walks, two runs and a person who hardly walks; two of the clips also serve as actions."""
    folder = tmp_path_factory.mktemp("real")
    for name in REAL:
        (folder / name).symlink_to((real_motion / name).resolve())
    build_bank([folder], folder / "bank", baseline="16_15", jobs=1)
    return Stage(Evaluator(Bank.open(folder / "bank")))


@settings(max_examples=20, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seeds)
def test_no_joint_pops(stage: Stage, seeds: list[int]) -> None:
    fastest = fastest_of_scenes(stage, seeds, random_command)
    assert np.all(fastest.played < MOST * np.maximum(fastest.clips, fastest.steady))


@settings(max_examples=20, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seeds)
def test_no_joint_of_captured_motion_pops(real_stage: Stage, seeds: list[int]) -> None:
    fastest = fastest_of_scenes(real_stage, seeds, random_command)
    assert np.all(fastest.played < MOST * np.maximum(fastest.clips, fastest.steady))
    assert np.all(fastest.jump < MOST * np.maximum(fastest.clips, fastest.steady_jump))


@pytest.mark.parametrize("give", [lambda one: one.play([0], "run", blend=0.3), lambda one: one.act([0], WAVE)])
def test_a_cross_fade_is_as_fast_as_the_character_that_follows_the_command(
    stage: Stage, give: Callable[..., None]
) -> None:
    characters, watch = Characters(stage, RATE), Watch(1)
    characters.add(1, "walk", time=0.4)
    give(characters)
    [fade] = cross_fades(characters.state[0])
    assert fade.lasting == 0.3
    for _ in range(19):
        watch.add(character_positions(characters))
        characters.advance()
    assert watch.speed[0] == pytest.approx(fastest_of_fades(stage, [fade])[0], rel=0.1)


@pytest.mark.parametrize("method", ["play", "act", "stop"])
def test_a_cut_is_detected(stage: Stage, monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    assert not pops(stage, FEW).missed
    monkeypatch.setattr(Characters, method, partialmethod(cut_instead, getattr(Characters, method)))
    assert any("largest" in one for one in pops(stage, FEW).missed)


def cut_instead(characters: Characters, do, *arguments, **options) -> None:  # type: ignore[no-untyped-def]
    if do.__name__ == "act":
        rows, action = arguments
        do(characters, rows, replace(action, blend=0.0))
    else:
        do(characters, *arguments, **{**options, "blend": 0.0})


def test_steady_rows_are_each_locomotion_under_each_stack_of_actions(stage: Stage) -> None:
    characters = Characters(stage, RATE)
    characters.add(1, "walk")
    characters.act([0], Action("wave", blend=0.0))
    characters.play([0], "run", blend=0.4)
    characters.act([0], Action("carry_box", blend=0.4))
    rows = np.array(list(steady_rows(characters.state[0])))
    names = [clip.name for clip in stage.bank.clips]
    played = [
        (names[int(row[LEGS[0]])], *(names[int(row[LAYERS[number]])] for number in range(int(row[col.ACTIONS]))))
        for row in rows
    ]
    under = [(), ("wave",), ("wave", "carry_box")]
    assert played == [(legs, *layers) for legs in ("walk", "run") for layers in under]
    assert is_fading(characters.state).all()
    assert not is_fading(rows).any()
    assert len(np.unique(slot_contents(rows), axis=0)) == len(rows)


def test_a_watch_keeps_the_largest_speed_and_jump() -> None:
    watch = Watch(2)
    for x in (0.0, 0.01, 0.02, 0.07):
        watch.add(np.array([[[x, 0.0, 0.0]], [[0.0, 0.0, 2.0 * x]]]), np.array([True, x < 0.05]))
    np.testing.assert_allclose(watch.speed, [3.0, 1.2])
    np.testing.assert_allclose(watch.jump, [2.4, 0.0], atol=1e-9)


def test_gaits_stay_in_step(stage: Stage) -> None:
    assert not phases(stage).missed


def test_replayed_commands_give_the_same_bytes(stage: Stage) -> None:
    assert not replay(stage, commands=400, frames=160).missed


def test_a_lost_command_changes_the_state(stage: Stage) -> None:
    recorded = record(stage, np.random.default_rng(1), 40, 60)
    rows = max(one.row for one in recorded) + 1
    whole, without = Characters(stage, RATE), Characters(stage, RATE)
    for characters in (whole, without):
        characters.add(rows, "walk")
    first = perform(whole, recorded, range(60))
    second = perform(without, recorded[:-1], range(60))
    assert first.state != second.state
