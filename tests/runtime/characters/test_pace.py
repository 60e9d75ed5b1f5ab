"""Actions that the legs would hurry: how fast they play, and how they come back into step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion.clip import Clip
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.action_kernels import MOST_PACE
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests import naive_character
from tests.conftest import CLIPS, built, written
from tests.playing import RATE, evaluated, layer, run_frames, slot

STROLL = "stroll"  # a box carried at half the walk's pace


@pytest.fixture(scope="module")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Stage:
    """A bank of a walk, a walk at half its pace, a run, a walk that hurries and waits, and an action of few strides."""
    walk, frames = CLIPS["walk"], np.arange(301.0)
    uneven = walk.sampled(np.minimum(frames + 25.0 * np.sin(frames / 40.0), 300.0))
    clips = {
        "walk": walk,
        "half": replace(walk, rate=30.0),
        "run": CLIPS["run"],
        "uneven": Clip("uneven", walk.skeleton, walk.rate, *uneven),
        STROLL: replace(CLIPS["carry_box"], rate=30.0),
        "box": CLIPS["carry_box"],
    }
    folder = written(tmp_path_factory.mktemp("pace"), clips, '[stroll]\nkind = "action"\n[box]\nkind = "action"\n')
    return Stage(Evaluator(built(folder, folder / "bank")))


def apart(characters: Characters) -> float:
    """Returns the cycles from the locomotion to the action, but for whole ones."""
    cycles = layer(characters, 0, col.PHASE) - slot(characters, 0, col.PHASE)
    return cycles - round(cycles)


def paces(characters: Characters, frames: int) -> list[float]:
    """Advances frame by frame; returns the action's pace in each frame in which it does not jump back."""
    rate, before, found = characters.stage.bank.clip(STROLL).rate, layer(characters, 0, col.FRAME), []
    for _ in range(frames):
        characters.advance()
        now = layer(characters, 0, col.FRAME)
        if now > before:
            found.append((now - before) * RATE / rate)
        before = now
    return found


def test_an_action_is_not_hurried_and_catches_up_when_the_legs_slow_down(stage: Stage) -> None:
    characters = Characters(stage, RATE)
    characters.add(1, "walk")
    characters.act([0], Action(STROLL))
    assert max(paces(characters, 40)) == pytest.approx(MOST_PACE, abs=1e-4)
    assert -0.5 < apart(characters) < -0.05
    characters.play([0], "half", blend=0.3)
    run_frames(characters, 20)
    assert min(paces(characters, 300)) > 0.9
    assert abs(apart(characters)) < 1e-6


def test_an_action_follows_legs_at_any_pace_if_told_so(stage: Stage) -> None:
    characters = Characters(stage, RATE)
    characters.add(1, "run")
    characters.act([0], Action(STROLL, own_clock=False))
    assert min(paces(characters, 200)) > 2.0
    assert abs(apart(characters)) < 1e-6


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    locomotion=st.sampled_from(["walk", "half", "run", "uneven"]),
    action=st.sampled_from([STROLL, "box"]),
    clock=st.sampled_from([None, False]),
    start=st.floats(0.0, 3.0),
    speed=st.floats(0.5, 1.5),
)
def test_the_clock_of_an_action_agrees_with_the_twin(
    stage: Stage, locomotion: str, action: str, clock: bool | None, start: float, speed: float
) -> None:
    characters = Characters(stage, RATE)
    characters.add(1, locomotion)
    characters.speed([0], speed)
    characters.act([0], Action(action, start=start, own_clock=clock))
    loops = stage.bank.clip(locomotion).loop, stage.bank.clip(action).loop
    for _ in range(300):
        before, phase = characters.state[0, col.FIRST_ACTION :].copy(), slot(characters, 0, col.PHASE)
        characters.advance()
        passed = slot(characters, 0, col.PHASE) - phase
        passed += loops[0] * (passed < 0.0)
        step = naive_character.action_step(stage.bank, before, passed, slot(characters, 0, col.PHASE), speed / RATE)
        error = before[col.PHASE] + step - layer(characters, 0, col.PHASE)
        assert min(abs(error), abs(error - loops[1])) < 1e-5


def test_an_action_that_was_left_behind_is_restored_to_the_same_bytes(stage: Stage) -> None:
    characters = Characters(stage, RATE)
    characters.add(1, "uneven")
    characters.act([0], Action(STROLL))
    run_frames(characters, 50)
    again = Characters(stage, RATE, np.frombuffer(characters.state.tobytes()).reshape(characters.state.shape).copy())
    for one in (characters, again):
        run_frames(one, 100)
    assert characters.state.tobytes() == again.state.tobytes()
    assert evaluated(characters)[1].tobytes() == evaluated(again)[1].tobytes()
