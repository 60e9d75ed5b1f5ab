from __future__ import annotations

from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest

from bench.characters import aimed, aiming
from bench.generated import Size, generate
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.aim import Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage

FEW = 20  # scenes


@pytest.fixture(scope="module")
def stage(bank: Bank) -> Stage:
    return Stage(Evaluator(bank))


def test_a_jump_to_a_target_is_detected(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not any("jump" in one for one in aiming.pops(stage, FEW).missed)
    for method in ("look", "aim"):
        do = getattr(Characters, method)
        monkeypatch.setattr(Characters, method, partialmethod(at_once, do))
    assert any("jump" in one for one in aiming.pops(stage, FEW).missed)


def at_once(characters: Characters, do, *arguments, **options) -> None:  # type: ignore[no-untyped-def]
    do(characters, *arguments, **{**options, "blend": 0.0})


def test_targets_are_missed_without_commands_and_met_with_them(stage: Stage) -> None:
    to = np.array(aiming.ASIDE)
    found = []
    for tell in (aimed.nothing, lambda one: one.look([0], Look(aiming.ASIDE))):
        clip = aimed.shown(stage, "walk", "carry_box", tell)
        ways = to - clip.places[:, stage.bank.roles.head]
        within = aimed.is_within(clip, ways)
        assert 60 < within.sum() <= aimed.FRAMES - aimed.SETTLED
        found.append(aimed.degrees_apart(aimed.gazes(stage, clip), ways)[within].min())
    assert found[0] > 5.0 > 0.1 > found[1]


def test_the_swivel_of_hands_is_that_of_a_run_unless_it_is_taken_out(stage: Stage) -> None:
    swings = [
        aimed.swivel(stage, aimed.shown(stage, "run", "carry_box", tell), aimed=True)
        for tell in (aiming.ahead_of(0.0), aiming.ahead_of(1.0))
    ]
    assert swings[0] > 4.0 > 0.1 > swings[1]
    assert "carry_box" in aiming.in_front(stage)


def test_each_piece_of_work_that_is_timed_has_its_targets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = list[int]()
    monkeypatch.setattr(aiming, "frame_work", lambda one: told.append(int(one.state[0, col.AIMED])))
    monkeypatch.setattr(aiming, "interleaved", lambda work, rounds: {name: np.ones(2) for name in work})
    aiming.costs(Stage(Evaluator(generate(tmp_path / "bank", Size(clips=2, seconds=3.0)))))
    assert told[0] == 0
    assert set(told[1:]) == {1}
