from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import MotionError, SettingsError, TimeRangeError, UnknownClipError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.feet_kernels import LONGEST
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import POSTURES
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests import naive_character
from tests.playing import RATE, Setup, evaluated, layer, run_frames, slot

seeds = st.integers(0, 2**32 - 1)


def commanded(characters: Characters, draw: np.random.Generator, frames: int) -> None:
    """Advances by `frames`, with random commands: one per character in about 25 frames."""
    for _ in range(frames):
        for row in np.flatnonzero(draw.random(len(characters)) < 0.04):
            command(characters, [int(row)], draw)
        characters.advance()


def command(characters: Characters, rows: list[int], draw: np.random.Generator) -> None:
    names = [clip.name for clip in characters.stage.bank.numbered]
    first, second = draw.choice(names, 2, replace=False)
    blend = float(draw.uniform(0.2, 0.6))
    kind = draw.integers(6)
    if kind == 0:
        characters.play(rows, first, blend=blend)
    elif kind == 1:
        characters.play(rows, {first: 0.4, second: 0.6}, blend=blend)
    elif kind == 2:
        when: Any = draw.choice(list(col.WHENS))
        characters.act(rows, Action(first, blend=blend, blend_out=blend, loop=bool(draw.integers(2)), when=when))
    elif kind == 3:
        mask: Any = draw.choice(list(col.MASKS))
        posture: Any = draw.choice(sorted(POSTURES.keys() - {"running"}))
        weight = draw.choice([1.0, draw.uniform(0.3, 1.0)])
        characters.act(rows, Action(first, blend=blend, mask=mask, weight=weight, posture=posture))
    elif kind == 4:
        characters.stop(rows, blend=blend)
    else:
        characters.speed(rows, draw.uniform(0.7, 1.2))


def test_one_locomotion_is_the_clip_at_another_place(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "turn_180")
    clip = characters.stage.evaluator.clip(Splice("turn_180"))
    path = bank.root_path("turn_180")
    for frame in range(200):
        root, rotations = evaluated(characters)
        at = frame / RATE * clip.rate
        roots, sampled = clip.sampled([at])
        turn = quaternion.about([0.0, 1.0, 0.0], -path[0, 3])
        np.testing.assert_allclose(rotations[0, 1:], sampled[0, 1:], atol=2e-6)
        np.testing.assert_allclose(root[0], quaternion.rotate(turn, roots[0] - path[0, :3]), atol=2e-5)
        assert quaternion.angle(rotations[0, 0], quaternion.multiply(turn, sampled[0, 0])) < 1e-5
        characters.advance()


def test_an_action_of_weight_0_is_the_locomotion_and_of_weight_1_the_splice(one: Setup) -> None:
    alone, none, whole = one(), one(), one()
    for characters in (alone, none, whole):
        characters.add(1, "walk", time=0.5)
    none.act([0], Action("carry_box", blend=0.0, weight=0.0))
    whole.act([0], Action("carry_box", blend=0.0))
    evaluator = whole.stage.evaluator
    for frame in range(90):
        np.testing.assert_allclose(evaluated(none)[1], evaluated(alone)[1], atol=1e-6)
        splice = evaluator.pose(Splice("walk", "carry_box"), 0.5 + frame / RATE).rotations[0, 1:]
        if whole.state[0, col.ACTIONS] == 1:
            frames = evaluator.action_frames(Splice("walk", "carry_box"), np.array([0.5 + frame / RATE]))
            if abs(frames[0] - layer(whole, 0, col.FRAME)) < 1e-6:
                np.testing.assert_allclose(evaluated(whole)[1][0, 1:], splice, atol=1e-6)
        for characters in (alone, none, whole):
            characters.advance()
    assert layer(whole, 0, col.PHASE) % 1.0 == pytest.approx(slot(whole, 0, col.PHASE) % 1.0, abs=1e-9)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seeds)
def test_poses_agree_with_the_twin(one: Setup, seed: int) -> None:
    draw, characters = np.random.default_rng(seed), one()
    names = [clip.name for clip in characters.stage.bank.numbered]
    for _ in range(3):
        characters.add(1, str(draw.choice(names)))
    commanded(characters, draw, 60)
    naive_character.check(characters)


@pytest.mark.parametrize("mask", ["arms", "head"])
@pytest.mark.parametrize("locomotion", ["walk", "walk~mirror", {"walk": 0.5, "run": 0.5}])
def test_a_whole_action_behind_a_mask_agrees_with_the_twin_and_with_nearly_all_of_it(
    one: Setup, locomotion: Any, mask: Any
) -> None:
    whole, nearly = one(), one()
    for characters, weight in ((whole, 1.0), (nearly, 1.0 - 1e-7)):
        characters.add(1, locomotion, time=0.4)
        characters.act([0], Action("carry_box", mask=mask, blend=0.0, weight=weight))
        characters.advance(20)
    np.testing.assert_allclose(evaluated(whole)[1], evaluated(nearly)[1], atol=1e-6)
    naive_character.check(whole)


@pytest.mark.parametrize("locomotion", ["walk", "run", "turn_180", "stairs_up", {"walk": 0.5, "run": 0.5}])
def test_deltas_add_up_to_the_path_and_loops_do_not_jump(one: Setup, locomotion: Any) -> None:
    characters = one()
    characters.add(1, locomotion)
    place, heading = np.zeros(3), 0.0
    roots = []
    for _ in range(900):
        roots.append(evaluated(characters)[0][0])
        characters.advance()
        delta = characters.deltas[0]
        place += quaternion.rotate(quaternion.about([0.0, 1.0, 0.0], heading), delta[:3])
        heading += delta[3]
    np.testing.assert_allclose(place, characters.state[0, col.PLACE : col.PLACE + 3], atol=1e-9)
    assert heading == pytest.approx(characters.state[0, col.HEADING])
    steps = np.linalg.norm(np.diff(roots, axis=0), axis=1) * RATE
    assert steps.max() < 1.5 * np.percentile(steps, 95.0)


def test_in_place_stays_at_the_origin_with_the_same_pose(one: Setup) -> None:
    moved, still = one(), one()
    for characters in (moved, still):
        characters.add(1, "turn_180")
    still.in_place([0])
    for _ in range(400):
        moved.advance()
        still.advance()
        np.testing.assert_array_equal(evaluated(moved)[1][:, 1:], evaluated(still)[1][:, 1:])
        assert np.hypot(*evaluated(still)[0][0, [0, 2]]) < 0.15
    assert np.linalg.norm(moved.state[0, col.PLACE : col.PLACE + 3]) > 0.5


def test_an_own_clock_keeps_time_and_returns_into_step(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "run", time=0.3)
    characters.act([0], Action("wave", own_clock=(0.2, 0.9), start=0.2))
    rate = bank.clip("wave").rate
    run_frames(characters, 30)
    assert layer(characters, 0, col.FRAME) / rate == pytest.approx(0.2 + 30 / RATE, abs=0.02)
    run_frames(characters, 240)
    apart = layer(characters, 0, col.PHASE) - slot(characters, 0, col.PHASE)
    assert abs(apart - round(apart)) < 1e-6


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seeds)
def test_the_same_commands_give_the_same_bytes_alone_among_others_and_after_a_restore(one: Setup, seed: int) -> None:
    draw = np.random.default_rng(seed)
    together = one()
    together.add(21, "walk")
    commanded(together, draw, 120)
    row = int(draw.integers(21))
    alone = Characters(together.stage, RATE, together.state[[row]].copy())
    restored = np.frombuffer(together.state.tobytes()).reshape(together.state.shape).copy()
    twice = Characters(together.stage, RATE, restored)
    for frame in range(60):
        if frame == 20:
            for characters, rows in ((together, [row]), (twice, [row]), (alone, [0])):
                characters.act(rows, Action("carry_box", when="foot"))
        roots, rotations = evaluated(together)
        assert roots[row].tobytes() == evaluated(alone)[0][0].tobytes()
        assert rotations[row].tobytes() == evaluated(alone)[1][0].tobytes()
        assert rotations.tobytes() == evaluated(twice)[1].tobytes()
        for characters in (together, alone, twice):
            characters.advance()
    assert together.state.tobytes() == twice.state.tobytes()


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Stage:
    """A bank with a clip without a gait: someone who stands and sways."""
    folder = tmp_path_factory.mktemp("standing")
    walk = make("walk", seed=1, seconds=4.0)
    frames = np.zeros(walk.frame_count, np.int64)
    rotations = walk.rotations[frames].copy()
    sway = 0.03 * np.sin(np.arange(walk.frame_count) / 40.0)
    rotations[:, 1] = quaternion.multiply(rotations[:, 1], quaternion.about([0.0, 0.0, 1.0], sway))
    idle = Clip("idle", walk.skeleton, walk.rate, walk.root_positions[frames], rotations)
    for name, clip in {"walk": walk, "idle": idle, "wave": make("walk", "wave", seed=2)}.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    build_bank([folder], folder / "bank", baseline="walk", jobs=1)
    return Stage(Evaluator(Bank.open(Path(folder / "bank"))))


def test_without_a_gait_an_action_plays_by_its_own_clock(standing: Stage) -> None:
    assert not standing.bank.clip("idle").gait
    characters = Characters(standing, RATE)
    characters.add(1, "idle")
    characters.act([0], Action("wave", blend=0.2))
    run_frames(characters, 60)
    assert layer(characters, 0, col.FRAME) / standing.bank.clip("wave").rate == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(characters.state[0, col.PLACE : col.PLACE + 3], 0.0, atol=1e-9)
    characters.play([0], "walk", blend=0.4)
    run_frames(characters, 120)
    apart = layer(characters, 0, col.PHASE) - slot(characters, 0, col.PHASE)
    assert abs(apart - round(apart)) < 1e-6


@pytest.mark.parametrize(
    ("do", "error"),
    [
        (lambda one: one.play([0], "wakl"), UnknownClipError),
        (lambda one: one.play([0], "walk", time=99.0), TimeRangeError),
        (lambda one: one.play([0], "walk", blend=-1.0), SettingsError),
        (lambda one: one.play([0], {}), SettingsError),
        (lambda one: one.play([0], {"walk": -1.0, "run": 2.0}), SettingsError),
        (lambda one: one.act([0], Action("wave", when="soon")), SettingsError),  # type: ignore[arg-type]
        (lambda one: one.act([0], Action("wave", mask="tail")), SettingsError),  # type: ignore[arg-type]
        (lambda one: one.act([0], Action("wave", weight=np.nan)), SettingsError),
        (lambda one: one.act([0], Action("wave", own_clock=(2.0, 1.0))), SettingsError),
        (lambda one: one.act([0], Action("wave", own_clock=(np.nan, 1.0))), SettingsError),
        (lambda one: one.place([0], [np.nan, 0.0, 0.0]), SettingsError),
        (lambda one: one.place([0], [0.0, 0.0]), SettingsError),
        (lambda one: one.place([0], [0.0, 0.0, 0.0], np.inf), SettingsError),
        (lambda one: one.speed([0], np.inf), SettingsError),
        (lambda one: one.add(-1, "walk"), SettingsError),
        (lambda one: one.advance(-1), SettingsError),
        (lambda one: one.act([0], Action("wave", method="none")), SettingsError),  # type: ignore[arg-type]
        (lambda one: one.add(1, "nobody"), UnknownClipError),
    ],
)
def test_an_invalid_command_changes_nothing(one: Setup, do: Callable[..., None], error: Any) -> None:
    characters = one()
    characters.add(1, "walk")
    before = characters.state.copy()
    with pytest.raises(error) as raised:
        do(characters)
    assert isinstance(raised.value, MotionError)
    np.testing.assert_array_equal(characters.state, before)


@pytest.mark.parametrize("frames", [6, 15])
def test_several_frames_in_one_step_are_nearly_the_same_as_one_by_one(one: Setup, frames: int) -> None:
    steps, apart = one(), one()
    for characters in (steps, apart):
        characters.add(2, "walk")
        characters.play([1], {"walk": 1.0, "run": 1.0}, blend=0.0)
        characters.act([0], Action("wave"))
    for _ in range(120 // frames):
        apart.advance(frames)
    run_frames(steps, 120)
    columns = [col.PLACE, col.PLACE + 1, col.PLACE + 2, col.FIRST_LOCOMOTION + col.PHASE, col.FIRST_ACTION + col.PHASE]
    alone = 1 if frames / RATE > LONGEST else 2  # in longer steps no foot drives the root of the mix
    np.testing.assert_allclose(steps.state[:alone, columns], apart.state[:alone, columns], atol=0.04)


def test_at_another_rate_the_same_characters_go_on(stage: Stage) -> None:
    characters = Characters(stage, 60.0)
    characters.add(2, "walk")
    expected, faster = Characters(stage, 30.0, characters.state.copy()), characters.at_rate(30.0)
    assert faster.state is characters.state
    for one in (expected, faster):
        one.advance(7)
    assert faster.rate == 30.0
    assert faster.state.tobytes() == expected.state.tobytes()
    with pytest.raises(SettingsError, match="the rate is nan"):
        characters.at_rate(float("nan"))
