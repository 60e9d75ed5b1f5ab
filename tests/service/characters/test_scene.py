"""The characters of a connection, without a socket."""

from __future__ import annotations

import gc
import shutil
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.service.characters import scene
from motionsplice.service.characters.commands import checked, parse
from motionsplice.service.characters.scene import Scene
from motionsplice.service.serving import Edition, Serving


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


def playing(edition: Edition) -> Scene:
    found = Scene(edition, 60.0, 100)
    for command in checked(parse('[{"do": "create", "id": [5, 6], "locomotion": "walk"},'
                                 '{"do": "act", "id": 6, "action": "wave"}]'), AXES["gltf"]):  # fmt: skip
        found.do(command)
    return found


def test_a_few_frames_are_left_out_as_if_they_had_been_evaluated(edition: Edition) -> None:
    evaluated, late = playing(edition), playing(edition)
    for _ in range(50):
        evaluated.pass_frame()
    late.leave_out(50)
    late.characters.deltas[:] = evaluated.characters.deltas  # which are those of all 50 frames
    assert late.characters.state.tobytes() == evaluated.characters.state.tobytes()


def test_a_scene_plays_on_after_its_bank_was_exchanged_and_removed(edition: Edition, tmp_path: Path) -> None:
    expected, serving = playing(edition), Serving(Bank.open(shutil.copytree(edition.bank.path, tmp_path / "bank")))
    serving.exchange(Edition.warm(serving.bank))
    found = playing(serving.edition)
    serving.exchange(edition)
    shutil.rmtree(tmp_path / "bank")
    gc.collect()
    for _ in range(20):
        poses = [one.edition.evaluator.poses(2) for one in (expected, found)]
        for one, into in zip((expected, found), poses, strict=True):
            one.advance()
            one.evaluate(into)
        assert poses[0].rotations.tobytes() == poses[1].rotations.tobytes()


@pytest.mark.parametrize("few", [True, False])
def test_the_root_motion_of_frames_that_are_left_out_is_added_to_the_next(
    edition: Edition, few: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    late = playing(edition)
    late.characters.play([1], "turn_180", time=2.0, blend=0.0)
    late.characters.place([1], (1.0, 0.0, 2.0), 0.7)
    begun = late.characters.state.copy()
    late.pass_frame()
    monkeypatch.setattr(scene, "FEW", 10_000 if few else 1)
    late.leave_out(49)
    left, up, ahead, turn = late.characters.deltas.T
    heading = begun[:, col.HEADING]
    sin, cos = np.sin(heading), np.cos(heading)
    moved = np.column_stack((cos * left + sin * ahead, up, cos * ahead - sin * left))
    places = late.characters.state[:, col.PLACE : col.PLACE + 3] - begun[:, col.PLACE : col.PLACE + 3]
    np.testing.assert_allclose(moved, places, atol=1e-9)
    np.testing.assert_allclose(heading + turn, late.characters.state[:, col.HEADING], atol=1e-9)
    assert abs(turn[1]) > 0.1
    assert np.abs(places).max() > 0.5


def test_many_frames_are_left_out_in_long_steps(edition: Edition, monkeypatch: pytest.MonkeyPatch) -> None:
    evaluated, late = playing(edition), playing(edition)
    for _ in range(50):
        evaluated.pass_frame()
    monkeypatch.setattr(scene, "FEW", 99)
    monkeypatch.setattr(Scene, "pass_frame", None)
    late.leave_out(50)
    places = [col.PLACE, col.PLACE + 2, col.FIRST_LOCOMOTION + col.PHASE]
    np.testing.assert_allclose(late.characters.state[:, places], evaluated.characters.state[:, places], atol=0.02)
