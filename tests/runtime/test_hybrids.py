"""Hybrid actions, which stand and walk by turns, in the evaluator and in characters."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion import quaternion
from motionsplice.motion.errors import BankError, SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.clip_references import clip_references
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.format.checks import check_fit
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.splice import Splice
from motionsplice.runtime.stage import Stage
from tests import naive
from tests.random_bank import random_bank

RATE = 60.0
STRETCHES = ("talk~1", "talk~2", "talk~3")


@pytest.fixture(scope="module")
def evaluator(talk_bank: Bank) -> Evaluator:
    return Evaluator(talk_bank)


def test_the_job_finds_the_stretches(talk_bank: Bank) -> None:
    hybrid = talk_bank.clip("talk")
    assert hybrid.stretches == STRETCHES
    assert not hybrid.stands
    assert not hybrid.warnings
    assert [talk_bank.clip(name).stands for name in STRETCHES] == [False, True, False]
    assert [talk_bank.begin_of(name) for name in STRETCHES] == pytest.approx([0.0, 4.0, 8.0], abs=0.3)
    assert talk_bank.clip("talk~2").uses[:1] != ()
    assert {talk_bank.whole(name) for name in STRETCHES} == {"talk"}
    assert talk_bank.whole("walk") == "walk"
    assert talk_bank.clip("talk~mirror").stretches == tuple(f"{name}~mirror" for name in STRETCHES)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_poses_agree_with_the_twin(data: st.DataObject) -> None:
    bank = random_bank(data.draw(st.integers(0, 10**6)), 6, 6, 4, "torso", hybrids=True)
    locomotion, hybrid = (
        data.draw(st.sampled_from(bank.numbered)),
        data.draw(st.sampled_from(("clip 0", "clip 3~mirror"))),
    )
    time, start = (data.draw(st.floats(0.0, one.duration)) for one in (locomotion, bank.clip(hybrid)))
    posture: Any = data.draw(st.sampled_from(["relative", "off"]))
    evaluator, cycles = Evaluator(bank), data.draw(st.integers(0, 12))
    requests, found = Requests.empty(1), evaluator.poses(1)
    requests.records[0] = evaluator.record(Splice(locomotion.name, hybrid, start=start, posture=posture))
    requests.time[:], requests.cycles[:] = time, cycles
    evaluator.evaluate(requests, found)
    root, rotations = naive.pose(bank, locomotion.name, time, hybrid, start, "splice", posture, cycles)
    np.testing.assert_allclose(found.root_positions[0], root, atol=1e-5)
    assert quaternion.angle(found.rotations[0], rotations).max() < 1e-4


def whole_of(characters: Characters, column: int) -> str:
    """Returns the name of the action that a column of the first row refers to."""
    bank = characters.stage.bank
    return bank.whole(bank.numbered[int(characters.state[0, column])].name)


def test_a_standing_stretch_plays_at_its_own_speed_and_a_walking_one_in_step(evaluator: Evaluator) -> None:
    bank, times = evaluator.bank, np.arange(0.0, 13.0, 0.05)
    for locomotion in ("walk", "walk~mirror"):
        frames = evaluator.action_frames(Splice(locomotion, "talk"), times)
        second = (frames > 60.0 * bank.begin_of("talk~2")) & (frames < 60.0 * bank.begin_of("talk~3"))
        np.testing.assert_allclose(np.diff(frames[second]), 3.0, atol=1e-6)
        for name in ("talk~1", "talk~3"):
            one = bank.clip(name)
            at = frames - 60.0 * bank.begin_of(name) + one.enters
            within = (at >= one.enters + 30.0) & (at < one.leaves)
            phases = np.interp(at[within], np.arange(one.row_count), bank.phase(name, seam=True))
            own = np.interp(times[within] * 60.0, np.arange(bank.clip(locomotion).frame_count), bank.phase(locomotion))
            apart = phases - own - np.round(phases - own)  # whole loops
            np.testing.assert_allclose(apart, 0.0, atol=1e-5)


def test_nothing_jumps_where_a_stretch_takes_over(evaluator: Evaluator) -> None:
    times = np.arange(0.0, 13.5, 1.0 / RATE)
    talking = evaluator.sequence(Splice("walk", "talk"), times).rotations.astype(np.float64)
    steps = quaternion.angle(talking[1:], talking[:-1])
    alone = [evaluator.sequence(Splice("walk", name), times).rotations.astype(np.float64) for name in STRETCHES]
    most = np.max([quaternion.angle(one[1:], one[:-1]).max(axis=0) for one in alone], axis=0)
    assert (steps.max(axis=0) <= most + np.radians(180.0) / RATE).all()


def test_a_character_plays_the_stretches_as_the_evaluator_does(evaluator: Evaluator) -> None:
    characters = Characters(Stage(evaluator), RATE)
    characters.add(1, "walk")
    characters.act([0], Action("talk", blend=0.0))
    assert whole_of(characters, col.BEGAN) == "talk"
    out, frames = evaluator.poses(1), range(round(13.0 * RATE))
    expected = evaluator.sequence(Splice("walk", "talk"), [frame / RATE for frame in frames])
    apart = []
    for frame in frames:
        characters.evaluate(out)
        apart.append(
            quaternion.angle(out.rotations[0, 1:].astype(float), expected.rotations[frame, 1:].astype(float)).max()
        )
        assert not characters.events[0] & col.ACTION_ENDED
        characters.advance()
    assert np.degrees(max(apart)) < 8.0
    assert np.degrees(np.mean(apart)) < 0.5


def test_an_action_that_does_not_loop_ends_after_its_last_stretch(evaluator: Evaluator) -> None:
    characters = Characters(Stage(evaluator), RATE)
    characters.add(1, "walk")
    characters.act([0], Action("talk", start=9.0, loop=False))
    ended = [bool(characters.advance() & col.ACTION_ENDED) for _ in range(round(6.0 * RATE))]
    assert 2.0 < ended.index(True) / RATE < 5.5
    assert whole_of(characters, col.ENDED) == "talk"


def test_a_stretch_that_is_played_alone_does_not_go_on(evaluator: Evaluator) -> None:
    characters, number = Characters(Stage(evaluator), RATE), evaluator.bank.number("talk~2")
    characters.add(1, "walk")
    characters.act([0], Action("talk~2", loop=False))
    played = set[int]()
    for _ in range(round(7.0 * RATE)):
        played |= set(clip_references(characters.state)[1].tolist())
        characters.advance()
    assert played == {number, evaluator.bank.number("walk")}
    assert characters.state[0, col.ACTIONS] == 0


def test_own_clock_is_refused(evaluator: Evaluator) -> None:
    characters = Characters(Stage(evaluator), RATE)
    characters.add(1, "walk")
    with pytest.raises(SettingsError, match="talk~1, talk~2, talk~3"):
        characters.act([0], Action("talk", own_clock=True))


def test_a_hybrid_is_a_locomotion_whose_phase_runs_on_steadily(talk_bank: Bank) -> None:
    phase, stands = talk_bank.phase("talk"), slice(round(60 * 4.8), round(60 * 7.2))
    speeds = 60.0 * np.diff(phase[stands])
    assert speeds.min() > 0.6
    assert speeds.max() < 1.4
    assert np.ptp(speeds) < 0.1


@pytest.mark.parametrize(
    ("name", "field", "value"),
    [("talk", "stretches", ("talk~1", "nobody")), ("hail", "stretches", ("talk~1",)), ("talk~2", "leaves", 1e6)],
)
def test_a_bank_whose_stretches_do_not_match_is_refused(talk_bank: Bank, name: str, field: str, value: Any) -> None:
    changed: dict[str, Any] = {field: value}
    clips = tuple(replace(clip, **changed) if clip.name == name else clip for clip in talk_bank.clips)
    with pytest.raises(BankError, match="does not match the clips"):
        check_fit(replace(talk_bank.manifest, clips=clips), talk_bank.tables, "bank")
