"""Scenes that are advanced and evaluated together, without a socket."""

from __future__ import annotations

import gc
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.service.characters.commands import checked, parse
from motionsplice.service.characters.ensemble import Ensemble
from motionsplice.service.characters.scene import Scene
from motionsplice.service.serving import Edition, Serving

LONG = 6  # frames in a step of 0.1 s


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


def do(scene: Scene, *commands: dict[str, Any]) -> Scene:
    for command in checked(parse(json.dumps(commands)), AXES["gltf"]):
        scene.do(command)
    return scene


def playing(edition: Edition, posture: str = "relative", start: float = 0.0) -> Scene:
    create = {"do": "create", "id": [5, 6], "locomotion": "walk", "time": start}
    return do(
        Scene(edition, 60.0, 100), create, {"do": "act", "id": 6, "action": "wave", "posture": posture, "loop": False}
    )


def shown(scene: Scene) -> bytes:
    """Evaluates a scene. Returns its poses and state, but for the root motion of the last frame."""
    poses = scene.edition.evaluator.poses(len(scene))
    scene.evaluate(poses)
    state = scene.characters.state.copy()
    state[:, col.DELTA : col.DELTA + 4] = 0.0
    return poses.root_positions.tobytes() + poses.rotations.tobytes() + state.tobytes()


def test_a_scene_plays_on_after_its_bank_was_exchanged_and_removed(edition: Edition, tmp_path: Path) -> None:
    expected, serving = playing(edition), Serving(Bank.open(shutil.copytree(edition.bank.path, tmp_path / "bank")))
    serving.exchange(Edition.warm(serving.bank))
    found = playing(serving.edition)
    serving.exchange(edition)
    shutil.rmtree(tmp_path / "bank")
    gc.collect()
    for _ in range(20):
        assert shown(expected) == shown(found)
        for scene in (expected, found):
            scene.pass_frame()


@pytest.mark.parametrize("posture", ["relative", "running"])
def test_frames_are_left_out_one_by_one_as_if_they_had_been_sent(edition: Edition, posture: str) -> None:
    sent, late = playing(edition, posture), playing(edition, posture)
    for _ in range(50):
        sent.pass_frame()
    Ensemble([late]).leave_out(50, 1)
    assert shown(late) == shown(sent)


@pytest.mark.parametrize("step", [1, LONG])
def test_the_root_motion_of_frames_that_are_left_out_is_added_to_the_next(edition: Edition, step: int) -> None:
    late = playing(edition)
    late.characters.play([1], "turn_180", time=2.0, blend=0.0)
    late.characters.place([1], (1.0, 0.0, 2.0), 0.7)
    begun = late.characters.state.copy()
    late.pass_frame()
    Ensemble([late, playing(edition)]).leave_out(49, step)
    left, up, ahead, turn = late.characters.deltas.T
    heading = begun[:, col.HEADING]
    sin, cos = np.sin(heading), np.cos(heading)
    moved = np.column_stack((cos * left + sin * ahead, up, cos * ahead - sin * left))
    places = late.characters.state[:, col.PLACE : col.PLACE + 3] - begun[:, col.PLACE : col.PLACE + 3]
    np.testing.assert_allclose(moved, places, atol=1e-9)
    np.testing.assert_allclose(heading + turn, late.characters.state[:, col.HEADING], atol=1e-9)
    assert abs(turn[1]) > 0.1
    assert np.abs(places).max() > 0.5


def test_long_steps_end_near_the_same_place(edition: Edition) -> None:
    sent, late = playing(edition), playing(edition)
    for _ in range(50):
        sent.pass_frame()
    Ensemble([late]).leave_out(50, LONG)
    places = [col.PLACE, col.PLACE + 2, col.FIRST_LOCOMOTION + col.PHASE]
    np.testing.assert_allclose(late.characters.state[:, places], sent.characters.state[:, places], atol=0.02)


@settings(max_examples=20, deadline=None)
@given(groups=st.lists(st.lists(st.sampled_from(range(4)), min_size=1, unique=True), min_size=1, max_size=12))
def test_scenes_move_as_they_would_alone(edition: Edition, groups: list[list[int]]) -> None:
    """Each tick takes other scenes together, some with characters that were just added or removed."""
    posture = ("relative", "running", "absolute", "off")
    joined, alone = ([playing(edition, posture[one], one / 3) for one in range(4)] for _ in range(2))
    for number, group in enumerate(groups):
        ensemble = Ensemble([joined[one] for one in group])
        ensemble.evaluate(edition.evaluator.poses(len(ensemble)))
        ensemble.advance()
        for one in group:
            alone[one].pass_frame()
        change: Sequence[dict[str, Any]] = [{"do": "create", "id": 100 + number, "locomotion": "run"}]
        if number % 3 == 2:
            change = [{"do": "remove", "id": 99 + number}]
        if number % 3:
            do(joined[groups[0][0]], *change)
            do(alone[groups[0][0]], *change)
    for one in range(4):
        assert joined[one].characters.state.tobytes() == alone[one].characters.state.tobytes()


def test_it_knows_when_its_scenes_are_others(edition: Edition) -> None:
    one, two, three = (playing(edition) for _ in range(3))
    ensemble = Ensemble([one, two])
    assert ensemble.holds([one, two])
    assert not ensemble.holds([two, one])
    assert not ensemble.holds([one])
    other = Ensemble([two, three])
    assert other.holds([two, three])
    assert not ensemble.holds([one, two])


def test_each_scene_has_its_own_events(edition: Edition) -> None:
    act = {"do": "act", "id": 5, "action": "wave", "when": "left_foot"}
    *scenes, twin = [do(playing(edition), act) for _ in range(4)]
    scenes[1].subscribe(["action_ended", "left_down"])
    scenes[2].subscribe([])
    found = Ensemble(scenes).leave_out(400, 1)
    assert found == sorted(found, key=lambda one: one[:2])
    twin.subscribe(["action_began", "action_ended", "left_down"])
    expected = [(frame + 1, event) for frame in range(400) for event in twin.advance()]
    assert {event["event"] for _, event in expected} == {"action_began", "action_ended", "left_down"}
    for row, names in enumerate((("action_began", "action_ended"), ("action_ended", "left_down"), ())):
        wanted = [(frame, event) for frame, event in expected if event["event"] in names]
        assert [(frame, event) for frame, number, event in found if number == row] == wanted
