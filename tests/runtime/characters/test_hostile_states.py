"""States that no command leads to are refused, or do no harm; all that commands lead to are accepted."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion.errors import BankError, SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import MOST_FRAMES, Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.characters.commands import MOST
from motionsplice.runtime.characters.ranges import RANGES, used_parts
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests.playing import RATE, Setup, evaluated, layer, run_frames, slot
from tests.random_bank import random_bank

HOSTILE = (np.nan, np.inf, -np.inf, -1.0, 1e9, -1e9, 1e17, 1e300, -1e300, 0.5, 7.0)
seeds = st.integers(0, 2**32 - 1)
banks = pytest.mark.parametrize("kind", ["bank", "standing_bank", "talk_bank", "hands_bank"])


@pytest.fixture(scope="module")
def stages(bank: Bank, standing_bank: Bank, talk_bank: Bank, hands_bank: Bank) -> dict[str, Stage]:
    opened = {"bank": bank, "standing_bank": standing_bank, "talk_bank": talk_bank, "hands_bank": hands_bank}
    return {name: Stage(Evaluator(one)) for name, one in opened.items()}


def command(characters: Characters, rows: list[int], draw: np.random.Generator) -> None:
    """Gives any command with any settings, extreme ones included."""
    bank, kind = characters.stage.bank, draw.integers(11)
    names = [clip.name for clip in bank.numbered]
    first, second, third = draw.choice(names, 3, replace=False).tolist()
    blend = float(draw.choice([0.0, 1e-300, 0.1, 0.3, 5.0, MOST]))
    curve: Any = draw.choice(list(col.CURVES))
    loop, weight = bool(draw.integers(2)), float(draw.choice([0.0, 1e-3, 0.4, 1.0]))
    if kind == 0:
        characters.play(rows, first, blend=blend, curve=curve, loop=loop, time=0.9 * bank.clip(first).duration)
    elif kind == 1:
        characters.play(rows, {first: 1.0, second: weight, third: 1e-6}, blend=blend, curve=curve, loop=loop)
        characters.mix(rows, {second: 1.0})
    elif kind in (2, 3):
        whens: Any = draw.choice(list(col.WHENS))
        mask: Any = draw.choice(list(col.MASKS))
        posture: Any = draw.choice(["off", "relative", "absolute", "running"])
        method: Any = draw.choice(["splice", "splice", "naive"])
        own: Any = (None, True, False, (0.2, 0.9))[draw.integers(4)] if not bank.clip(first).stretches else None
        settings = {"when": whens, "mask": mask, "posture": posture, "method": method, "own_clock": own, "loop": loop}
        act = Action(first, blend=blend, blend_out=0.5 * blend, curve=curve, weight=weight, **settings)
        characters.act(rows, act)
    elif kind == 4:
        characters.stop(rows, blend=blend, curve=curve)
    elif kind == 5:
        characters.speed(rows, float(draw.choice([0.0, 1e-300, 1e-14, 0.3, 1.0, 3.0, MOST])))
    elif kind == 6:
        characters.place(rows, draw.choice([0.0, 3.0, -1e9], 3).tolist(), float(draw.choice([0.0, 1e9])))
        characters.in_place(rows, loop)
    elif kind == 7 and bank.hand_clips:
        characters.wear(rows, None if loop else bank.hand_clips[0], blend=blend, weight=weight)
    elif kind == 8:
        characters.lock_feet(rows, loop)
    elif kind == 9:
        target = Look([1.0, 1e9, -2.0], weight=weight) if loop else Look(direction=[1e-300, 0.0, -1.0])
        characters.look(rows, None if weight == 0.0 else target, blend=blend)
    else:
        part: Any = draw.choice(["chest", "left_arm", "right_arm"])
        characters.aim(rows, Aim(direction=draw.normal(size=3).tolist(), part=part, weight=weight), blend=blend)


def played(stage: Stage, draw: np.random.Generator, frames: int) -> Characters:
    """Returns characters after random commands and steps, most of them of a frame and some of an age."""
    characters = Characters(stage, RATE)
    characters.add(6, stage.bank.clips[int(draw.integers(len(stage.bank.clips)))].name)
    for _ in range(frames):
        for row in np.flatnonzero(draw.random(len(characters)) < 0.1):
            command(characters, [int(row)], draw)
        evaluated(characters)
        characters.advance(
            int(draw.choice([0, 1, 1, 1, 1, 1, 10, 1000, MOST_FRAMES], p=[0.04, *[0.18] * 5, 0.02, 0.02, 0.02]))
        )
    return characters


@banks
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seeds)
def test_whatever_commands_lead_to_is_accepted(stages: dict[str, Stage], kind: str, seed: int) -> None:
    draw = np.random.default_rng(seed)
    characters = played(stages[kind], draw, 60)
    again = Characters(characters.stage, RATE, characters.state.copy())
    for one in (characters, again):
        one.moved(Stage(Evaluator(one.stage.bank)))
        roots, rotations = evaluated(one)
        assert np.isfinite(roots).all()
        np.testing.assert_allclose(np.linalg.norm(rotations, axis=2), 1.0, atol=1e-3)
        one.advance()
    assert again.state.tobytes() == characters.state.tobytes()


def busy(stage: Stage) -> Characters:
    """Returns a character of which nearly all columns are in use."""
    names = [clip.name for clip in stage.bank.numbered]
    characters = Characters(stage, RATE)
    characters.add(2, {names[0]: 0.5, names[1]: 0.5})
    characters.play([0, 1], {names[1]: 0.5, names[2]: 0.5}, blend=1.0)
    characters.lock_feet([0, 1])
    characters.look([0, 1], Look([1.0, 1.0, 3.0]))
    for part in ("chest", "left_arm", "right_arm"):
        characters.aim([0, 1], Aim([1.0, 1.0, 3.0], part=part))
    for number in range(2):
        characters.act([0, 1], Action(names[number], mask="arms", posture="running", blend=1.0))
        if stage.bank.hand_clips:
            characters.wear([0, 1], stage.bank.hand_clips[number], blend=1.0)
    run_frames(characters, 20)
    evaluated(characters)
    characters.play([0, 1], dict.fromkeys(names[:4], 1.0), blend=1.0)
    characters.play([0, 1], dict.fromkeys(names[:4], 1.0), blend=1.0)
    characters.act([0, 1], Action(names[0], when="left_foot"))
    if stage.bank.hand_clips:
        characters.wear([0, 1], None, blend=1.0)
    return characters


def test_every_column_has_a_range() -> None:
    columns = [column for part, _ in used_parts(np.zeros((1, col.COLUMNS))) for column in range(part.start, part.stop)]
    assert sorted(RANGES) == sorted(columns) == list(range(col.FIRST_AIM + 4 * col.AIM_COLUMNS))


def hostile_door(stage: Stage) -> None:
    """Puts every hostile number into every column in use. It is refused, or the row plays on, with finite poses."""
    sound = busy(stage).state
    refused = accepted = 0
    columns = [column for part, used in used_parts(sound) if used[1] for column in range(part.start, part.stop)]
    for column in columns:
        for number in HOSTILE:
            state = sound.copy()
            state[1, column] = number
            try:
                characters = Characters(stage, RATE, state)
            except SettingsError as error:
                refused += str(error).startswith("row 1 ") and "another bank" in str(error)
                continue
            accepted += 1
            assert not np.isinf(number) or column in (_own(col.OWN_FROM) + _own(col.OWN_TO))
            for frames in (1, 3, MOST_FRAMES, 1):
                assert all(np.isfinite(values).all() for values in evaluated(characters)), (column, number)
                characters.advance(frames)
    assert refused + accepted == len(columns) * len(HOSTILE)
    assert refused > accepted


def _own(column: int) -> list[int]:
    return [col.FIRST_ACTION + number * col.ACTION_COLUMNS + column for number in range(col.MOST_ACTIONS + 1)]


def hostile_kernels(stage: Stage, seed: int, rounds: int) -> None:
    """Writes hostile numbers into rows behind the door: kernels finish, and read nothing outside their tables."""
    draw, numbers = np.random.default_rng(seed), np.array([*HOSTILE, 0.0, 1.0, 2.0, 3.0, 4.0, 8.0])
    sound = busy(stage).state
    for _ in range(rounds):
        characters = Characters(stage, RATE, np.tile(sound[:1], (5, 1)))
        for _ in range(int(draw.integers(1, 12))):
            characters.state[draw.integers(5), draw.choice([*range(26), *draw.integers(0, col.COLUMNS, 40)])] = (
                draw.choice(numbers)
            )
        # in plain Python, NaN is no mask, and nothing is divided by 0
        with np.errstate(all="ignore"), suppress(ValueError, ArithmeticError):
            evaluated(characters)
            for frames in (1, MOST_FRAMES, 1):
                characters.advance(frames)
                evaluated(characters)
            characters.play([0, 1, 2, 3, 4], characters.stage.bank.clips[0].name)


def test_a_bank_whose_roles_are_those_of_no_body_has_no_stage() -> None:
    with pytest.raises(BankError, match="the joints of its roles are not those of a body"):
        Stage(Evaluator(random_bank(4, 9, 3, 4, "torso")))


BEHIND = """
import sys, faulthandler
faulthandler.enable()
from tests.runtime.characters import test_hostile_states as tests
stage = tests.Stage(tests.Evaluator(tests.Bank.open(sys.argv[1])))
getattr(tests, sys.argv[2])(stage, *map(int, sys.argv[3:]))
"""


def apart(path: Path, name: str, *numbers: int, **environment: str) -> None:
    """Calls a function of this file in a process of its own, which may crash."""
    given = [sys.executable, "-c", BEHIND, str(path), name, *map(str, numbers)]
    done = subprocess.run(given, capture_output=True, text=True, env=os.environ | environment, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.parametrize("kind", ["bank", "hands_bank"])
def test_a_hostile_number_is_refused_or_does_no_harm(stages: dict[str, Stage], kind: str) -> None:
    apart(stages[kind].bank.path, "hostile_door")


@pytest.mark.parametrize("kind", ["bank", "hands_bank"])
def test_kernels_stay_in_their_tables_whatever_a_state_holds(stages: dict[str, Stage], kind: str) -> None:
    apart(stages[kind].bank.path, "hostile_kernels", 1, 400)


def test_plain_kernels_stay_in_their_tables_whatever_a_state_holds(stages: dict[str, Stage]) -> None:
    """Plain Python checks bounds, of all but the lanes that compiled code loads together."""
    apart(stages["hands_bank"].bank.path, "hostile_kernels", 2, 6, NUMBA_DISABLE_JIT="1")


@pytest.mark.parametrize("name", ["walk", "run", "side_step", "walk~mirror"])
def test_a_step_of_many_loops_goes_as_far_as_its_frames(one: Setup, name: str) -> None:
    assert one().stage.bank.clip(name).loop > 0.0
    whole, by_frame = one(), one()
    for characters in (whole, by_frame):
        characters.add(1, name)
    whole.advance(3000)
    run_frames(by_frame, 3000)
    places = slice(col.PLACE, col.HEADING + 1)
    np.testing.assert_allclose(whole.state[0, places], by_frame.state[0, places], rtol=1e-6, atol=1e-6)
    assert slot(whole, 0, col.FRAME) == pytest.approx(slot(by_frame, 0, col.FRAME), abs=1e-6)


def test_an_action_far_out_of_step_begins_at_once(one: Setup) -> None:
    """The phase of a clip that is held at its end goes on; it may be any number of cycles ahead."""
    characters = one()
    characters.add(1, "walk")
    characters.state[0, col.FIRST_LOCOMOTION + col.PHASE] += 1e9
    characters.act([0], Action("wave"))
    assert layer(characters, 0, col.PHASE) < characters.stage.bank.clip("wave").last_phase
